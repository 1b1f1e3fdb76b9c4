#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the documentation to links that lead somewhere.

  tests/tools/check_links.py [ROOT]

Every relative link and picture of README.md and docs/**/*.md names a file or folder of the project, every #anchor a heading
of the page it leads to (as GitHub names headings), every #L12 a line of the source. Code and addresses on the net are left
out.
"""
import pathlib
import re
import sys
import urllib.parse

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tools'))
import checking  # noqa: E402

FENCE = re.compile(r' *(```+|~~~+)')
INLINE_CODE = re.compile(r'(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)')
LINK = re.compile(r'\[(?:[^\[\]]|\[[^\]]*\]|\\.)*\]\(\s*(?:<([^>]*)>|([^\s()]*(?:\([^\s()]*\)[^\s()]*)*))(?:\s+(?:"[^"]*"|\'[^\']*\'))?\s*\)')
PICTURE_LINK = re.compile(r'!\[[^\]]*\]\(([^\s)]+)[^)]*\)')  # also inside the text of a link
DEFINITION = re.compile(r' {0,3}\[([^\]]+)\]:\s+<?([^\s>]+)>?')
REFERENCE = re.compile(r'\[([^\[\]]+)\]\[([^\[\]]*)\]')
HTML = re.compile(r'<(?:a|img|source)\b[^>]*?\b(?:href|src|srcset)\s*=\s*["\']([^"\'\s]+)', re.IGNORECASE)
HTML_ANCHOR = re.compile(r'<\w+\b[^>]*?\b(?:id|name)\s*=\s*["\']([^"\']+)', re.IGNORECASE)
HEADING = re.compile(r' {0,3}#{1,6}\s+(.*?)\s*#*\s*$')
LINE_ANCHOR = re.compile(r'L(\d+)(?:-L(\d+))?$')


def prose(text):
    """(line number, line) of what is not in a fence."""
    fence = None
    for number, line in enumerate(text.split('\n'), 1):
        found = FENCE.match(line)
        if fence is None and found:
            fence = found.group(1)
        elif fence is not None:
            if found and found.group(1).startswith(fence):
                fence = None
        else:
            yield number, line


def slug(heading):
    """The anchor of a heading: its text in lower case without punctuation, with hyphens for spaces."""
    text = re.sub(r'!?\[([^\]]*)\]\([^)]*\)', r'\1', heading)  # the text of links
    text = re.sub(r'<[^>]+>|[`*]', '', text).strip().lower()
    return re.sub(r'[^\w\- ]', '', text).replace(' ', '-')


def anchors(text):
    found, lines = set(), list(prose(text))
    for n, (_, line) in enumerate(lines):
        heading = HEADING.match(line)
        if not heading and line.strip() and n + 1 < len(lines) and re.match(r'(=+|-+)\s*$', lines[n + 1][1]) and '|' not in line:
            heading = re.match(r'\s*(.*)', line)
        if heading:
            name, again = slug(heading.group(1)), 0
            while (f'{name}-{again}' if again else name) in found:
                again += 1
            found.add(f'{name}-{again}' if again else name)
        found.update(HTML_ANCHOR.findall(line))
    return found


def links(text):
    """Yields (line number, target, or None with what is wrong); a link may run over the end of a line."""
    shown = [''] * (text.count('\n') + 1)
    for number, line in prose(text):
        shown[number - 1] = INLINE_CODE.sub('``', line)
    defined = {m.group(1).lower() for line in shown for m in [DEFINITION.match(line)] if m}
    for number, line in enumerate(shown, 1):
        definition = DEFINITION.match(line)
        if definition:
            yield number, definition.group(2), None
    text = '\n'.join('' if DEFINITION.match(line) else line for line in shown)
    found = []
    for match in LINK.finditer(text):
        if '\n\n' in match.group():
            continue
        found.append((match.start(), match.group(2) if match.group(1) is None else match.group(1), None))
        found += [(match.start() + 1 + m.start(), m.group(1), None) for m in PICTURE_LINK.finditer(match.group()[1:])]
    found += [(m.start(), m.group(1), None) for m in HTML.finditer(text)]
    for match in REFERENCE.finditer(text):
        label = match.group(2) or match.group(1)
        if label.lower() not in defined:
            found.append((match.start(), None, f'[{label}] is not defined on this page'))
    for start, target, problem in sorted(found, key=lambda f: f[0]):
        yield text.count('\n', 0, start) + 1, target, problem


def check_target(root, page, target):
    """What is wrong with a link of the file `page`, or None."""
    if re.match(r'[a-z][a-z0-9+.\-]*:|//', target, re.IGNORECASE):
        return None
    path, _, anchor = target.partition('#')
    path, anchor = urllib.parse.unquote(path), urllib.parse.unquote(anchor)
    if path.startswith('/'):
        return f'{target}: write it relative to the page'
    file = (page.parent / path).resolve() if path else page
    if not path and not anchor:
        return 'a link to nowhere'
    if file != root and root not in file.parents:
        return f'{target} leads out of the project'
    if not file.exists():
        return f'{target}: there is no {file.relative_to(root).as_posix()}'
    if not anchor:
        return None
    name = file.relative_to(root).as_posix()
    if file.is_dir():
        return f'{target}: {name} is a folder, which has no headings'
    text = file.read_text(encoding='utf-8')
    lines = LINE_ANCHOR.match(anchor)
    if lines and file.suffix != '.md':
        return None if max(int(n) for n in lines.groups() if n) <= len(text.splitlines()) else f'{target}: {name} is shorter'
    return None if anchor in anchors(text) else f'{target}: no heading of {name} has the anchor {anchor}'


def check_tree(root):
    """Returns (number of links looked at, list of 'path:line: message')."""
    root, problems, count = root.resolve(), [], 0
    for page in [root / 'README.md'] + sorted((root / 'docs').rglob('*.md')):
        if not page.is_file():
            continue
        for line, target, problem in links(page.read_text(encoding='utf-8')):
            count += 1
            problem = problem or check_target(root, page, target)
            if problem:
                problems.append(f'{page.relative_to(root).as_posix()}:{line}: {problem}')
    return count, problems


if __name__ == '__main__':
    sys.exit(checking.run(check_tree, 'links', 'lead nowhere'))
