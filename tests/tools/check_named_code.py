#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that a link whose text is code, such as [`Mapper::process`](../src/…/mapper.cpp), names something the linked source mentions.

  tests/tools/check_named_code.py [ROOT]

So a page that leads a reader through the sources stays true when a function is renamed or moved. That the files exist is
check_links.py's business. Exit code 1 when a name is missing.
"""
import pathlib
import re
import sys

LINK = re.compile(r'\[`([A-Za-z_][\w:]*)(?:\(\))?`\]\(([^)#\s]+\.(?:h|cpp))\)')


def missing_names(root):
    """Yields 'page:line: what is missing'."""
    for page in [root / 'README.md', *sorted((root / 'docs').rglob('*.md'))]:
        text = page.read_text(encoding='utf-8')
        for match in LINK.finditer(text):
            name, source = match.group(1), page.parent / match.group(2)
            if not source.is_file():
                continue
            # `Class::function` is either defined in the linked source or declared there inside the class.
            code = source.read_text(encoding='utf-8')
            for part in name.split('::'):
                if not re.search(rf'\b{re.escape(part)}\b', code):
                    yield f'{page.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}: {match.group(2)} does not mention {part}'


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    missing = list(missing_names(root))
    print('\n'.join(missing), end='\n' if missing else '')
    return 1 if missing else 0


if __name__ == '__main__':
    sys.exit(main())
