#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the tables of docs/howto.md to the tests and the pictures they name.

  tests/tools/check_howto.py [ROOT]

Each of its ten rows names tests, as links such as [`Suite.Case`](../tests/some_test.cpp), [`Class.test_name`](….py) or a test of
ctest with the CMakeLists.txt that adds it. They must exist, and every option (--name) and member (->name, .name) that the row's
command shows must be used in one of those files. Each picture of docs/images (PNG) has a row of the page that says how it is made, and
a page shows it. Exit code 1 when something is missing.
"""
import pathlib
import re
import sys

ROWS = 10
LINK = re.compile(r'\[`([^`]+)`\]\(([^)#\s]+)\)')
CODE = re.compile(r'`([^`]+)`')
OPTION = re.compile(r'(?<![\w-])--[a-z][a-z-]+')
MEMBER = re.compile(r'(?:->|\.)([a-z_]{5,})\b')
SHOWN = re.compile(r'!\[[^\]]*\]\(([^)\s]+)\)')
# What stands after the dot of these is no member.
FILES = re.compile(r'\S+\.(?:mp4|bag|yaml|png|deb|m)\b')


def has_test(name, file, text):
    """True when the file defines the test."""
    if file.suffix == '.cpp':
        suite, _, case = name.partition('.')
        return re.search(rf'^TEST(?:_F|_P)?\({re.escape(suite)}, {re.escape(case)}\)', text, re.MULTILINE) is not None
    if file.suffix == '.py':
        owner, _, test = name.rpartition('.')
        return (not owner or re.search(rf'^class {re.escape(owner)}\b', text, re.MULTILINE) is not None) and \
            re.search(rf'^ *def {re.escape(test)}\(', text, re.MULTILINE) is not None
    return re.search(rf'add_test\(NAME {re.escape(name)}\b', text) is not None


def rows_of(page):
    """The cells of the rows of the page's first table, without its head."""
    rows = []
    for line in page.split('\n'):
        if line.startswith('|'):
            rows.append([cell.strip() for cell in line.strip('|').split('|')])
        elif rows:
            break
    return rows[2:]


def problems(root):
    """Yields what is wrong, one line each."""
    page = root / 'docs/howto.md'
    rows = rows_of(page.read_text(encoding='utf-8'))
    if len(rows) != ROWS:
        yield f'docs/howto.md: the table has {len(rows)} rows, where it should have {ROWS}'
    for wanted, how, _, tests in rows:
        texts = []
        for name, target in LINK.findall(tests):
            file = (page.parent / target).resolve()
            if not file.is_file():
                yield f'{wanted}: there is no {target}'
                continue
            text = file.read_text(encoding='utf-8')
            texts.append(text)
            if not has_test(name, file, text):
                yield f'{wanted}: {target} has no test {name}'
        if not texts:
            yield f'{wanted}: no test is named'
            continue
        code = '\n'.join(CODE.findall(LINK.sub('', how)))
        shown = set(OPTION.findall(code)) | set(MEMBER.findall(FILES.sub('', code)))
        for word in sorted(shown):
            if not any(re.search(rf'(?<![\w-]){re.escape(word)}(?![\w-])', text) for text in texts):
                yield f'{wanted}: none of its tests uses {word}'
    yield from problems_of_pictures(root)


def problems_of_pictures(root):
    """Yields the pictures that nobody shows, and those of which it is not said how they are made."""
    pages = {page: page.read_text(encoding='utf-8') for page in [root / 'README.md', *sorted((root / 'docs').rglob('*.md'))] if page.is_file()}
    shown = {(page.parent / target).resolve() for page, text in pages.items() for target in SHOWN.findall(text)}
    named = set(re.findall(r'[\w-]+\.png', ' '.join(line for line in pages[root / 'docs/howto.md'].split('\n') if line.startswith('|'))))
    for picture in sorted((root / 'docs/images').glob('*.png')):
        if picture.name not in named:
            yield f'docs/images/{picture.name}: docs/howto.md does not say how it is made'
        if picture.resolve() not in shown:
            yield f'docs/images/{picture.name}: no page shows it'


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    found = list(problems(root))
    print('\n'.join(found), end='\n' if found else '')
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main())
