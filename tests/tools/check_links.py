#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the links of README.md and docs/**/*.md and lists those that are broken.

  tests/tools/check_links.py [ROOT]

- A relative link, or a relative image, names a file or folder that exists.
- A link with a #heading names a heading of that page, as GitHub derives its anchor.
- A link whose text is code, such as [`Mapper::process`](../src/…/mapper.cpp), names something the linked file mentions.

Links to the web are not followed. Exit code 1 when a link is broken.
"""
import pathlib
import re
import sys

FENCE = re.compile(r'^(```|~~~).*?^\1', re.DOTALL | re.MULTILINE)
LINK = re.compile(r'\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(\s*<?([^)\s>]+)>?(?:\s+"[^"]*")?\s*\)')
HEADING = re.compile(r'^#{1,6}\s+(.+?)\s*#*\s*$', re.MULTILINE)
CODE_NAME = re.compile(r'`([A-Za-z_][\w:]*)(?:\(\))?`')


def without_fences(text):
    """The text with the same line numbers, code blocks blanked."""
    return FENCE.sub(lambda match: re.sub(r'[^\n]', ' ', match.group(0)), text)


def anchors(text):
    """The anchors of a page's headings."""
    found, seen = set(), {}
    for match in HEADING.finditer(without_fences(text)):
        title = re.sub(r'!?\[([^\]]*)\]\([^)]*\)', r'\1', match.group(1)).replace('`', '').lower()
        anchor = re.sub(r'[^\w\- ]', '', title).replace(' ', '-')
        count = seen.get(anchor, 0)
        seen[anchor] = count + 1
        found.add(anchor if count == 0 else f'{anchor}-{count}')
    return found


def problem_of(page, label, target):
    """What is wrong with a link of a page, or None."""
    if re.match(r'[a-z][a-z0-9+.-]*:', target):
        return None
    name, _, anchor = target.partition('#')
    file = (page.parent / name).resolve() if name else page
    if not file.exists():
        return f'{target} does not exist'
    if anchor and (file.suffix != '.md' or anchor not in anchors(file.read_text(encoding='utf-8'))):
        return f'{target}: there is no such heading'
    code = CODE_NAME.fullmatch(label.strip())
    if code and file.is_file() and file.suffix in {'.h', '.cpp'}:
        wanted = code.group(1).split('::')[-1]
        if not re.search(rf'\b{re.escape(wanted)}\b', file.read_text(encoding='utf-8')):
            return f'{target} does not mention {wanted}'
    return None


def pages(root):
    yield root / 'README.md'
    yield from sorted((root / 'docs').rglob('*.md'))


def broken_links(root):
    """Yields 'page:line: what is wrong'."""
    for page in pages(root):
        text = without_fences(page.read_text(encoding='utf-8'))
        for match in LINK.finditer(text):
            problem = problem_of(page, match.group(1), match.group(2))
            if problem:
                yield f'{page.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}: {problem}'


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    broken = list(broken_links(root))
    for line in broken:
        print(line)
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
