#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds names of the project that a source uses without including, even by way of others, the header that declares them.

  tools/check_includes.py [ROOT]

Sources of a module are compiled together in most builds, where an include that one of them lacks does not show; the presets `dev`, `release` and
`bench` compile each by itself. Looked at are types and constants (`LocatedFrame`, `kMaxFeatures`) and functions at namespace level of more than one word that
are called without an object.
"""
import functools
import pathlib
import re
import sys

import checking
from check_layers import COMMENT_OR_STRING

FOLDERS = ['src', 'include', 'synth', 'apps', 'bench', 'tests', 'fuzz', 'python', 'examples']
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
TEST_NAME = re.compile(r'^TEST\w*\(\w+', re.MULTILINE)
# Declarations at namespace level, which are not indented.
TYPE = re.compile(r'^(?:template <[^>]*>\n)?(?:struct|class|enum class|enum)\s+([A-Z]\w+)(?:\s+final)?\s*[:{]|^using ([A-Z]\w+) =', re.MULTILINE)
CONSTANT = re.compile(r'^(?:inline )?constexpr [\w:<>, ]+ (k[A-Z]\w*)\b', re.MULTILINE)
FUNCTION = re.compile(r'^(?=\S)(?!using|return|else|namespace|static_assert)(?:inline )?[\w:<>,*& ]+[ *&](\w+)\([^;{]*[;{]', re.MULTILINE)
ANY_DECLARATION = re.compile(r'\b(?:struct|class|enum class|enum|using|typename|class)\s+(\w+)|\b(k[A-Z]\w*)\b\s*(?:=(?!=)|[{\[])')
WORD = re.compile(r'(?<![\w:.>])(?:(?:covis|io|storage|app|view|synth|eval|exchange)::)*([A-Z]\w+|k[A-Z]\w*)\b')
CALL = re.compile(r'(?<![\w.>:~])(?:(?:covis|io|storage|app|view|synth|eval|exchange)::)*(\w+)\(')


class Source:
    def __init__(self, path):
        raw = path.read_text(encoding='utf-8')
        self.includes = INCLUDE.findall(raw)
        self.text = TEST_NAME.sub(' ', COMMENT_OR_STRING.sub(' ', raw))


def declared_in(text):
    names = {a or b for a, b in TYPE.findall(text)} | set(CONSTANT.findall(text))
    functions = {name for name in FUNCTION.findall(text) if '_' in name and name.islower()}
    return names, functions


def check_tree(root):
    """Returns (number of files, list of 'path: message')."""
    sources = {path.relative_to(root).as_posix(): Source(path) for folder in FOLDERS for path in sorted((root / folder).rglob('*'))
               if path.suffix in ('.h', '.cpp')}

    def resolve(name, include):
        beside = (pathlib.PurePosixPath(name).parent / include).as_posix()
        for candidate in (beside, include, f'src/{include}', f'include/{include}', f'tests/{include}'):
            if candidate in sources:
                return candidate
        return None

    @functools.lru_cache(maxsize=None)
    def reached(name):
        seen, open_files = set(), [name]
        while open_files:
            file = open_files.pop()
            if file in seen:
                continue
            seen.add(file)
            open_files += [r for r in (resolve(file, include) for include in sources[file].includes) if r]
        return frozenset(seen)

    homes, calls = {}, {}  # name: headers that declare it
    for file, source in sources.items():
        if file.endswith('.h'):
            names, functions = declared_in(source.text)
            for table, found in ((homes, names), (calls, functions)):
                for name in found:
                    table.setdefault(name, set()).add(file)
    problems = []
    for file, source in sources.items():
        near = reached(file)
        # Names are declared nearby at any level: members, parameters of templates, forward declarations.
        own = {name for other in near for match in ANY_DECLARATION.findall(sources[other].text) for name in match if name}
        used = set(WORD.findall(source.text)) - own
        for name in sorted(used):
            if name in homes and not homes[name] & near:
                problems.append(f'{file}: {name} is declared in {sorted(homes[name])[0]}, which it does not include')
        for name in sorted(set(CALL.findall(source.text))):
            if name in calls and not calls[name] & near:
                # A member or a local function of this name, here or in what is included.
                if any(re.search(rf'[\w>&*\]] [*&]?{name}\(|\b{name} = |\b{name}\) ?[{{(]|\b{name}{{', sources[other].text) for other in near):
                    continue
                problems.append(f'{file}: {name}() is declared in {sorted(calls[name])[0]}, which it does not include')
    return len(sources), problems


if __name__ == '__main__':
    sys.exit(checking.run(check_tree, 'files', 'names without their header'))
