#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the project's rules of structure and words, and says where they are broken.

  tools/check_house.py [ROOT] [--list]

--list prints all that was measured, not only what breaks a bar. What each rule counts is said at its function; the bars
are in the table below. A line that must use a word of the old dialect says `house:ok` in a comment.
"""
import argparse
import pathlib
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from check_layers import is_test  # noqa: E402
from cpp_outline import Outline  # noqa: E402

BARS = {
    'fields of a class of tracking': 15,
    'methods of a class of tracking': 20,
    'fields of another class or struct': 12,
    'fields of an options struct': 15,
    'bool parameters, per 1000 lines': 1.0,      # fewer than this
    'sources with a test of their own, %': 60,   # at least
    'include circles of files': 0,
    'include circles of folders': 0,
    'lines of a file': 400,
    'lines of a function': 100,
    'functions over 50 lines, %': 3,
    'comments that begin with a fragment, %': 1.0,  # fewer than this
    'words of the old dialect': 0,
}
CLASS_FOLDERS = ['src/covis/tracking', 'src/covis/mapping', 'src/covis/loops', 'src/covis/slam']
CODE_FOLDERS = ['src', 'include', 'apps', 'synth']
TEXT_FOLDERS = CODE_FOLDERS + ['tests', 'bench']
LONG_FUNCTION = 50
FRAGMENTS = {'of', 'what', 'whether', 'where', 'nothing', 'which'}
NO_PROSE = re.compile(r'namespace\b|NOLINT|clang-format\b|clang-tidy\b|IWYU\b')  # comments for programs, and of closing braces

# The dialect that was renamed: what a text must not say, and what it says instead.
WORDS = [
    (r'key\s+points?', 'keypoint'),
    (r'base\s+lines?', 'baseline'),
    (r'gone\s+on\s+with', 'continued'),
    (r'made\s+one', 'fused, joined'),
    (r'(hangs?|hanging|hung)\s+on', 'relative to, depends on'),
    (r'told', 'reported'),
    (r'(takes?|taken|took|taking)\s+over', 'apply'),
    (r'doubtful', 'tentative'),
    (r'bridged', 'dead-reckoned'),
    (r'usual\s+share', 'expected match ratio'),
    (r'submaps?\s+of\s+the\s+map', 'submap'),
    (r'(a\s+part|parts)\s+of\s+the\s+map', 'submap'),
]
WORDS = [(re.compile(rf'\b{pattern}\b', re.IGNORECASE), instead) for pattern, instead in WORDS]


class Source:
    def __init__(self, root, path):
        self.path = path
        self.name = path.relative_to(root).as_posix()
        self.folder = path.parent.relative_to(root).as_posix()
        self.test = is_test(path.relative_to(root))
        self.text = path.read_text(encoding='utf-8')
        self.outline = Outline(self.text)
        self.code = not self.test and self.name.split('/')[0] in CODE_FOLDERS


class Rule:
    """One line of the table: what was measured, and whether it is within its bar."""

    def __init__(self, name, value, good, problems=(), rows=(), summary=None):
        self.name, self.value, self.good = name, value, good
        head = [summary] if summary else []
        self.rows = head + list(rows)  # for --list
        self.problems = [] if good else head + list(problems)


def at(source, line):
    return f'{source.name}:{line}'


def read_sources(root):
    paths = [p for folder in TEXT_FOLDERS for p in (root / folder).rglob('*') if p.suffix in ('.h', '.hpp', '.cpp')]
    return [Source(root, path) for path in sorted(paths)]


def most(name, measured):
    """The rule that no value is above its bar; measured: (value, place, what)."""
    measured = sorted(measured, key=lambda m: (-m[0], m[1]))
    bar, worst = BARS[name], measured[0][0] if measured else 0
    broken = [f'{place}: {what} has {value} {name.split(" of ")[0]}, at most {bar}' for value, place, what in measured if value > bar]
    return Rule(name, worst, not broken, broken, [f'{value:5d}  {place} {what}' for value, place, what in measured])


def check_classes(sources):
    """Fields are non-static data members and static ones that are not const. Methods are all that is declared in the class but
    constructors, destructors, and what is defaulted or deleted; each overload is one. Nested classes count for themselves."""
    found = {'tracking': [], 'methods': [], 'options': [], 'other': []}
    for source in sources:
        if source.test or not any(source.folder == f or source.folder.startswith(f + '/') for f in CLASS_FOLDERS):
            continue
        for c in source.outline.classes:
            fields = (len(c.fields), at(source, c.line), c.name)
            if c.name.endswith('Options'):
                found['options'].append(fields)
            elif c.key == 'class' and source.folder.startswith('src/covis/tracking'):
                found['tracking'].append(fields)
                found['methods'].append((len(c.methods), at(source, c.line), c.name))
            else:
                found['other'].append(fields)
    yield most('fields of a class of tracking', found['tracking'])
    yield most('methods of a class of tracking', found['methods'])
    yield most('fields of another class or struct', found['other'])
    yield most('fields of an options struct', found['options'])


def is_bool(parameter):
    """bool by value: `bool x`, `const bool x = true`, `bool`."""
    words = parameter[:parameter.index('=')] if '=' in parameter else parameter
    words = [w for w in words if w not in ('const', '[', ']', 'maybe_unused')]
    return words[:1] == ['bool'] and len(words) <= 2 and (len(words) == 1 or words[1].isidentifier())


def check_bools(sources):
    """Parameters of type bool, by value, of functions, methods and lambdas; a function's declaration and its definition
    count once. Per 1000 lines of files that are no tests, all lines counted."""
    name, lines, places = 'bool parameters, per 1000 lines', 0, {}
    headers_first = sorted((s for s in sources if s.code), key=lambda s: (s.path.suffix == '.cpp', s.name))
    for source in headers_first:
        lines += source.outline.lines
        for f in source.outline.functions:
            which = tuple(n for n, parameter in enumerate(f.parameters) if is_bool(parameter))
            if which:
                key = (f.name, len(f.parameters), which) + ((source.name, f.line) if f.local else ())
                where = f'{at(source, f.line)}: {f.name} takes ' + ', '.join(' '.join(f.parameters[n]) for n in which)
                places.setdefault(key, (where, len(which)))
    count = sum(n for _, n in places.values())
    value = 1000 * count / max(1, lines)
    rows = sorted(where for where, _ in places.values())
    return Rule(name, round(value, 2), value < BARS[name], rows, rows,
                f'{count} bool parameters in {lines} lines are {value:.2f} per 1000, less than {BARS[name]} wanted:')


def check_tests(sources):
    """A source is a .cpp that is no test of src/covis, apps (without main.cpp and cmd_*.cpp) and synth, or a header there
    with a function's body in it and no .cpp of its name. x.cpp, x.h and x-inl.h are tested by x_test.cpp in the same folder."""
    name, with_test, without = 'sources with a test of their own, %', [], []
    names = {s.name for s in sources}
    for source in sources:
        path = pathlib.PurePosixPath(source.name)
        if not source.code or path.parts[0] == 'include' or path.parts[0] == 'apps' and re.match(r'main$|cmd_', path.stem):
            continue
        stem = path.parent / path.stem.removesuffix('-inl')
        if path.suffix != '.cpp' and (f'{stem}.cpp' in names or not any(f.lines for f in source.outline.functions)):
            continue
        (with_test if f'{stem}_test.cpp' in names else without).append(source.name)
    share = 100 * len(with_test) / max(1, len(with_test) + len(without))
    rows = [f'{n}: tested' for n in with_test] + [f'{n}:1: no {pathlib.PurePosixPath(n).stem}_test.cpp beside it' for n in without]
    return Rule(name, round(share, 1), share >= BARS[name] or not with_test + without, rows[len(with_test):], rows,
                f'{len(with_test)} of {len(with_test) + len(without)} sources have a test of their own, {BARS[name]} % wanted:')


def circles(graph):
    """A path for each edge that closes a circle; graph: node to the set of nodes it points to."""
    found, done = [], set()

    def visit(node, path):
        if node in path:
            found.append(path[path.index(node):] + [node])
        elif node not in done:
            for other in sorted(graph.get(node, ())):
                visit(other, path + [node])
            done.add(node)

    for node in sorted(graph):
        visit(node, [])
    return found


def check_includes(root, sources):
    """Circles of #include between files that are no tests, and between the folders they are in."""
    files = {s.name: s for s in sources if not s.test}
    edges, lines = {}, {}
    for source in files.values():
        for line, target, quoted in source.outline.includes:
            tries = [f'src/{target}', f'include/{target}', target] + [f'{source.folder}/{target}'] * quoted
            other = next((t for t in tries if t in files), None)
            if not other:
                continue
            edges.setdefault(source.name, set()).add(other)
            lines[source.name, other] = at(source, line)
            folders = source.folder, files[other].folder
            if folders[0] != folders[1]:
                lines.setdefault(folders, at(source, line))
    folder_edges = {}
    for source, others in edges.items():
        for other in others:
            if files[source].folder != files[other].folder:
                folder_edges.setdefault(files[source].folder, set()).add(files[other].folder)
    for name, graph in [('include circles of files', edges), ('include circles of folders', folder_edges)]:
        found = [f'{lines[c[-2], c[-1]]}: closes the circle {" -> ".join(c)}' for c in circles(graph)]
        yield Rule(name, len(found), len(found) <= BARS[name], found, found)


def check_lengths(sources):
    """Lines of files, tests too; lines of functions that are no tests, from the first of the declaration to the closing
    brace. A lambda is part of the function it is in."""
    yield most('lines of a file', [(s.outline.lines, at(s, 1), s.path.name) for s in sources])
    functions = [(f.lines, at(s, f.line), f.name) for s in sources if s.code for f in s.outline.functions if f.lines]
    longest = most('lines of a function', functions)
    longest.rows = []
    yield longest
    over = sorted((f for f in functions if f[0] > LONG_FUNCTION), reverse=True)
    name, share = 'functions over 50 lines, %', 100 * len(over) / max(1, len(functions))
    rows = [f'{where}: {what} has {lines} lines' for lines, where, what in over]
    yield Rule(name, round(share, 2), share <= BARS[name], rows, rows,
               f'{len(over)} of {len(functions)} functions are over {LONG_FUNCTION} lines, at most {BARS[name]} % wanted:')


def check_comments(sources):
    """A comment is a run of // lines, or one behind code with the lines below it in its column. Not counted: the licence
    line, names of closed namespaces, and notes to clang-tidy and clang-format."""
    name, total, places = 'comments that begin with a fragment, %', 0, []
    for source in sources:
        for comment in source.outline.comments:
            first = re.match(r'\W*(\w+)', comment.text)
            if not first or NO_PROSE.match(comment.text):
                continue
            total += 1
            if first.group(1).lower() in FRAGMENTS:
                places.append(f'{at(source, comment.line)}: ' + comment.text.split('\n')[0])
    share = 100 * len(places) / max(1, total)
    return Rule(name, round(share, 2), share < BARS[name], places, places,
                f'{len(places)} of {total} comments begin with {"/".join(sorted(FRAGMENTS))}, less than {BARS[name]} % wanted:')


def check_words(root, sources):
    """Words in comments and strings of the code and its tests, in README.md and docs/*.md; also across the end of a line."""
    name, texts = 'words of the old dialect', []  # (file, first line, text, lines of the file)
    for source in sources:
        lines = source.text.split('\n')
        texts += [(source.name, c.line, c.text, lines) for c in source.outline.comments]
        texts += [(source.name, line, re.sub(r'\\[nt]', '  ', text), lines) for line, text in source.outline.strings()]
    for path in [root / 'README.md'] + sorted((root / 'docs').rglob('*.md')):
        if path.is_file():
            text = path.read_text(encoding='utf-8')
            texts.append((path.relative_to(root).as_posix(), 1, text, text.split('\n')))
    places = []
    for file, first, text, lines in texts:
        for pattern, instead in WORDS:
            for match in pattern.finditer(text):
                line = first + text.count('\n', 0, match.start())
                if 'house:ok' not in lines[line - 1]:
                    said = ' '.join(match.group().split())
                    places.append((file, line, f'"{said}": write {instead}'))
    places = [f'{file}:{line}: {what}' for file, line, what in sorted(places)]
    return Rule(name, len(places), len(places) <= BARS[name], places, places)


def check_tree(root):
    """Returns (number of files looked at, list of rules)."""
    sources = read_sources(root)
    rules = list(check_classes(sources)) + [check_bools(sources), check_tests(sources)]
    rules += list(check_includes(root, sources)) + list(check_lengths(sources))
    return len(sources), rules + [check_comments(sources), check_words(root, sources)]


def main():
    parser = argparse.ArgumentParser(description='Measures the project\'s rules of structure and words.')
    parser.add_argument('root', nargs='?', type=pathlib.Path, default=pathlib.Path(__file__).parent.parent)
    parser.add_argument('--list', action='store_true', help='print all that was measured')
    arguments = parser.parse_args()
    count, rules = check_tree(arguments.root.resolve())
    if count == 0:
        print(f'{arguments.root}: no sources found')
        return 1
    for rule in rules:
        rows = rule.rows if arguments.list else rule.problems
        if rows:
            print(f'\n{rule.name}:')
            print('\n'.join(rows))
    broken = [rule for rule in rules if not rule.good]
    print(f'\n{"rule":<42}{"today":>8}{"bar":>8}')
    for rule in rules:
        print(f'{rule.name:<42}{rule.value:>8}{BARS[rule.name]:>8}{"" if rule.good else "  broken"}')
    print(f'{count} files, {len(broken)} of {len(rules)} rules broken')
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
