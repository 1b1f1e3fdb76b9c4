#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the sources to the project's rules of structure and says where they are broken.

  tools/check_layers.py [ROOT]

- A module includes only the modules that the table below allows it; tests may look further. The modules are the
  folders of src/covis, and synth/ with its folders.
- The core modules include nothing but the standard library, Eigen, Highway and tl::expected; those around it no
  logging library and no windows. What a test needs besides stays in its *_test.cpp or in a header of tests/: the
  helpers beside the sources (test_*.h) add GoogleTest alone.
- The library never sleeps, prints or exits, and draws no numbers from rand().
- Every source says its licence (SPDX) at its top.
"""
import pathlib
import re
import sys

import checking

# module: the modules it may include, bottom to top
LAYERS = {
    'core': set(),
    'geometry': {'core'},
    'features': {'core', 'geometry'},
    'vocabulary': {'core', 'features'},
    'map': {'core', 'geometry', 'features', 'vocabulary'},
    'matching': {'core', 'geometry', 'features', 'vocabulary', 'map'},
    'optimization': {'core', 'geometry'},
    'tracking': {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization'},
    'mapping': {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization'},
    'loops': {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization', 'mapping'},
    'slam': {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization', 'tracking', 'mapping', 'loops'},
    'api': {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization', 'tracking', 'mapping', 'loops', 'slam', 'storage'},
    'storage': {'core', 'geometry', 'features', 'vocabulary', 'map'},
    'io': {'core', 'geometry', 'features'},
    'exchange': {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization', 'mapping', 'io'},
    'eval': {'core', 'geometry', 'io'},
    'synth/render': {'core', 'geometry'},
    'synth/things': {'core', 'geometry', 'synth/render'},
    'synth/worlds': {'core', 'geometry', 'synth/render', 'synth/things'},
    'synth': {'core', 'geometry', 'io', 'synth/render', 'synth/things', 'synth/worlds'},
}
CORE = {'core', 'geometry', 'features', 'vocabulary', 'map', 'matching', 'optimization', 'tracking', 'mapping', 'loops', 'slam', 'api', 'storage'}
# Tests may include any module but those, which would turn the arrows round.
ABOVE_TESTS = {module: {'slam', 'api'} for module in LAYERS}
ABOVE_TESTS['slam'] = {'api'}
ABOVE_TESTS['api'] = set()

CORE_EXTERNAL = re.compile(r'[a-z_]+$|Eigen/|hwy/|tl/expected\.hpp$')  # a name without dot or slash is the standard library's
# What the standard library can't do: files that are used where they lie, and written whole or not at all; priorities and
# cores of threads. And the compression of saved maps.
EXCEPTIONS = {('core', header) for header in ('fcntl.h', 'sys/file.h', 'sys/mman.h', 'sys/stat.h', 'unistd.h')}
EXCEPTIONS |= {('core', header) for header in ('pthread.h', 'sched.h', 'sys/resource.h')}
EXCEPTIONS |= {('storage', 'zstd.h')}
TEST_HELPER_EXTERNAL = re.compile(r'g(test|mock)/')
OUTER_FORBIDDEN = re.compile(r'spdlog/|fmt/|CLI/|opencv2/(highgui|viz)')  # the command's, and windows
FORBIDDEN_CALLS = [
    (re.compile(r'\b(sleep_for|sleep_until|usleep|nanosleep|sleep)\s*\('), 'sleeps: wait on a condition variable'),
    (re.compile(r'\bthis_thread::yield\b'), 'polls: wait on a condition variable'),
    (re.compile(r'\bstd::(cout|cerr|clog)\b|\b(printf|puts|putchar)\s*\('), 'prints: use covis::log'),
    (re.compile(r'(?<![\w.>])(exit|_exit|quick_exit)\s*\('), 'exits: return an Error'),
    (re.compile(r'(?<![\w.>])(rand|srand)\s*\(|\brandom_device\b'), 'is not reproducible: use covis::Random'),
]

# Public headers of plain values, which the library works with too.
PLAIN_PUBLIC = {'covis/types.h', 'covis/snapshot.h', 'covis/log.h'}

SOURCE_FOLDERS = ['src', 'include', 'examples', 'python', 'synth', 'apps', 'bench', 'tests', 'fuzz', 'tools', 'cmake', '.ci']
SOURCE_SUFFIXES = {'.h', '.hpp', '.cpp', '.cmake', '.py', '.sh'}
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')
COMMENT_OR_STRING = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"', re.DOTALL)


def is_test(path):
    """Tests and their helpers: anything_test.cpp, test_anything.h, and what lies in a folder called testing."""
    return path.stem.endswith('_test') or path.stem.startswith('test_') or 'testing' in path.parts


def module_of(path):
    """The module of a source by its path from the root, or None when it belongs to none."""
    folders = path.parts[:-1]
    if folders[:2] == ('src', 'covis'):
        return '/'.join(folders[2:])
    return '/'.join(folders) if folders[:1] == ('synth',) else None


def blank(match):
    """The same number of lines, without the text."""
    return '\n' * match.group(0).count('\n') + ' '


def check_include(path, module, bracket, target):
    """What is wrong with including `target` in the file `path` of `module`, or None."""
    test = is_test(path)
    if target.startswith(('covis/', 'synth/')):
        other = module_of(pathlib.PurePosixPath('src' if target.startswith('covis/') else '', target))
        if not other:
            return None if test or module == 'api' or target in PLAIN_PUBLIC else f'the public header {target} is for module api and the outside'
        if other not in LAYERS:
            return f'{target} is of no module known to tools/check_layers.py'
        if other == module:
            return None
        if test:
            return f'a test of {module} must not include {other}' if other in ABOVE_TESTS[module] else None
        return None if other in LAYERS[module] else f'{module} must not include {other}'
    if bracket == '"' and '/' not in target:
        folder = module if module.startswith('synth') else f'covis/{module}'
        return f'"{target}": write the whole path, as "{folder}/{target}"'
    if path.stem.endswith('_test'):
        return None
    if module in CORE:
        allowed = (CORE_EXTERNAL.match(target) or (module, target) in EXCEPTIONS or
                   (test and TEST_HELPER_EXTERNAL.match(target)))
        return None if allowed else f'core module {module} must not include <{target}>'
    return f'{module} must not include <{target}>' if OUTER_FORBIDDEN.match(target) else None


def check_module_file(path, module):
    """Yields (line number, message) for each broken rule."""
    text = path.read_text(encoding='utf-8')
    for number, line in enumerate(text.split('\n'), 1):
        include = INCLUDE.match(line)
        problem = include and check_include(path, module, include.group(1), include.group(2))
        if problem:
            yield number, problem
    if is_test(path):
        return
    for number, line in enumerate(COMMENT_OR_STRING.sub(blank, text).split('\n'), 1):
        for pattern, message in FORBIDDEN_CALLS:
            found = pattern.search(line)
            if found:
                yield number, f'the library {message} ({found.group(0).strip()})'


def source_files(root):
    for folder in SOURCE_FOLDERS:
        for path in sorted((root / folder).rglob('*')):
            if not path.is_file() or '__pycache__' in path.parts:
                continue
            if path.suffix in SOURCE_SUFFIXES or path.name == 'CMakeLists.txt' or path.read_bytes()[:2] == b'#!':
                yield path
    for name in ['CMakeLists.txt', 'demo', 'test']:
        if (root / name).is_file():
            yield root / name


def check_tree(root):
    """Returns (number of files looked at, list of 'path:line: message')."""
    problems, count = [], 0
    for path in source_files(root):
        count += 1
        name = path.relative_to(root)
        head = path.read_text(encoding='utf-8').split('\n')[:2]
        if not any('SPDX-License-Identifier: Apache-2.0' in line for line in head):
            problems.append(f'{name}:1: its first lines must say SPDX-License-Identifier: Apache-2.0')
        module = module_of(name)
        if module is None or path.suffix not in {'.h', '.hpp', '.cpp'}:
            continue
        if module not in LAYERS:
            problems.append(f'{name}:1: {module} is no module known to tools/check_layers.py')
            continue
        problems += [f'{name}:{line}: {message}' for line, message in check_module_file(path, module)]
    return count, problems


if __name__ == '__main__':
    sys.exit(checking.run(check_tree, 'files', 'broken rules'))
