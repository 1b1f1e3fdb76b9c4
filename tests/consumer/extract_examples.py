#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the C++ examples of the documentation as sources, for the consumer to compile against the installed library.

  tests/consumer/extract_examples.py ROOT OUT

Examples are the fences of README.md and docs/**/*.md that begin with ```cpp, and the indented code in the comment at the
head of each public header (include/covis/*.h). In OUT

- an example with a main() becomes program_NAME.cpp, which is compiled and run without arguments and must succeed;
  after ```cpp compile-only it becomes compiled_NAME.cpp, which is not run;
- all others become fragment_NAME.cpp: their includes, example_prelude.h, and the rest as the body of a function. One after
  ```cpp continued goes on where the one before it in the same file ends.

C++ that is not to be compiled stands after ```cpp-fragment, what is no C++ after ```text or another language.
"""
import dataclasses
import pathlib
import re
import sys

FENCE = re.compile(r'( *)(```+|~~~+)(.*)')
LANGUAGES = {'c++', 'cc', 'cxx', 'c', 'hpp', 'h'}  # other names of C++, which would go by unseen
FLAGS = {'compile-only', 'continued'}
CODE = re.compile(r'[;{}]$')
INCLUDE = re.compile(r'\s*#\s*include\b')
MAIN = re.compile(r'^\s*(int|auto)\s+main\s*\(', re.MULTILINE)


class BadExample(Exception):
    pass


@dataclasses.dataclass
class Example:
    file: str   # relative to the root
    line: int   # of its first line of code
    lines: list
    flags: list

    def name(self):
        return re.sub(r'\W', '_', self.file) + f'_{self.line}'

    def is_program(self):
        return MAIN.search('\n'.join(self.lines)) is not None


def examples_of_markdown(file, text):
    examples, fence = [], None
    for number, line in enumerate(text.split('\n'), 1):
        found = FENCE.match(line)
        if fence is None and found:
            words = found.group(3).split()
            fence = found.group(2)
            indent = len(found.group(1))
            if words and words[0].lower() in LANGUAGES:
                raise BadExample(f'{file}:{number}: write ```cpp, so that it is compiled, or ```cpp-fragment')
            taken = words[:1] == ['cpp']
            if taken:
                if set(words[1:]) - FLAGS:
                    raise BadExample(f'{file}:{number}: after ```cpp may stand {", ".join(sorted(FLAGS))}')
                examples.append(Example(file, number + 1, [], words[1:]))
        elif fence is not None and found and found.group(2).startswith(fence) and not found.group(3).strip():
            fence = None
        elif fence is not None and taken:
            examples[-1].lines.append(line[indent:] if not line[:indent].strip() else line)
    if fence is not None:
        raise BadExample(f'{file}: the last fence is not closed')
    return examples


def examples_of_header(file, text):
    """Indented blocks of the comment at the head that end a line as code does."""
    examples, block = [], None
    for number, line in enumerate(text.split('\n'), 1):
        if not line.startswith('//'):
            break
        inside = line.startswith('//   ') or block and line == '//'
        if inside and block is None:
            block = Example(file, number, [], [])
        if inside:
            block.lines.append(line[5:])
        elif block:
            examples.append(block)
            block = None
    examples += [block] if block else []
    return [e for e in examples if any(CODE.search(line.rstrip()) for line in e.lines)]


def joined(examples):
    """Lists of examples that are one source: those continued come with the ones before."""
    sources = []
    for example in examples:
        if 'continued' not in example.flags:
            sources.append([example])
        elif not sources or sources[-1][0].file != example.file or sources[-1][0].is_program():
            raise BadExample(f'{example.file}:{example.line - 1}: there is no fragment before it to continue')
        else:
            sources[-1].append(example)
    return sources


def source_file(parts):
    """(name, text) of the source that compiles one example with those that continue it."""
    name, program = parts[0].name(), parts[0].is_program()
    if program:
        kind = 'compiled' if 'compile-only' in parts[0].flags else 'program'
        return f'{kind}_{name}.cpp', f'#line {parts[0].line} "{parts[0].file}"\n' + '\n'.join(parts[0].lines) + '\n'
    includes = [line for part in parts for line in part.lines if INCLUDE.match(line)]
    text = includes + ['#include "example_prelude.h"', f'int example_{name}();', f'int example_{name}() {{']
    for part in parts:
        text += [f'#line {part.line} "{part.file}"'] + ['' if INCLUDE.match(line) else line for line in part.lines]
    return f'fragment_{name}.cpp', '\n'.join(text + ['return 0;', '}', ''])


def extract(root):
    """Returns [(name, text)] of all sources."""
    examples = []
    for path in [root / 'README.md'] + sorted((root / 'docs').rglob('*.md')):
        if path.is_file():
            examples += examples_of_markdown(path.relative_to(root).as_posix(), path.read_text(encoding='utf-8'))
    for path in sorted((root / 'include' / 'covis').glob('*.h')):
        examples += examples_of_header(path.relative_to(root).as_posix(), path.read_text(encoding='utf-8'))
    return [source_file(parts) for parts in joined(examples)]


def main():
    root, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    try:
        sources = extract(root)
    except BadExample as problem:
        print(problem)
        return 1
    if not sources:
        print(f'{root}: no examples found')
        return 1
    out.mkdir(parents=True, exist_ok=True)
    for name, text in sources + [('fragment_main.cpp', 'int main() { return 0; }\n')]:
        (out / name).write_text(text, encoding='utf-8')
    print(f'{len(sources)} examples: {", ".join(name for name, _ in sources)}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
