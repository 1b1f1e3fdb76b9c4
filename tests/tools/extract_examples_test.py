#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tests/consumer/extract_examples.py: which code becomes which source."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / 'consumer'))
import extract_examples  # noqa: E402


class ExtractExamplesTest(unittest.TestCase):
    def sources(self, text, name='README.md'):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            return dict(extract_examples.extract(pathlib.Path(folder)))

    def assert_bad(self, text, problem):
        with self.assertRaisesRegex(extract_examples.BadExample, problem):
            self.sources(text)

    def test_fragments(self):
        self.assertEqual(self.sources('Text\n```cpp\n#include <a>\nuse(1);\n```\n'), {
            'fragment_README_md_3.cpp': '#include <a>\n#include "example_prelude.h"\nint example_README_md_3();\nint example_README_md_3() {\n'
                                        '#line 3 "README.md"\n\nuse(1);\nreturn 0;\n}\n'})

    def test_programs(self):
        text = '```cpp\nint main() {}\n```\n```cpp compile-only\nint main(int argc, char** argv) {}\n```\n'
        self.assertEqual(self.sources(text, 'docs/a.md'), {'program_docs_a_md_2.cpp': '#line 2 "docs/a.md"\nint main() {}\n',
                                                           'compiled_docs_a_md_5.cpp': '#line 5 "docs/a.md"\nint main(int argc, char** argv) {}\n'})

    def test_continued(self):
        made = self.sources('```cpp\nint a = 1;\n```\nand\n```cpp continued\n#include <b>\nuse(a);\n```\n')
        self.assertEqual(list(made), ['fragment_README_md_2.cpp'])
        self.assertIn('#include <b>\n#include "example_prelude.h"', made['fragment_README_md_2.cpp'])
        self.assertIn('int a = 1;\n#line 6 "README.md"\n\nuse(a);\nreturn 0;', made['fragment_README_md_2.cpp'])
        self.assert_bad('```cpp continued\nuse(a);\n```\n', 'README.md:1: there is no fragment before it')

    def test_what_is_not_compiled(self):
        self.assertEqual(self.sources('```cpp-fragment\nx\n```\n```text\n```cpp\n```\n```\nx\n```\n````\n```cpp\n````\n    ./covis\n'), {})

    def test_what_would_go_by_unseen(self):
        self.assert_bad('\n```c++\nx\n```\n', 'README.md:2: write ```cpp')
        self.assert_bad('```cpp run\nx\n```\n', 'after ```cpp may stand compile-only, continued')
        self.assert_bad('```cpp\nx\n', 'is not closed')

    def test_fences_in_lists(self):
        self.assertIn('\nif (a)\n  b();\n', self.sources('- a:\n\n  ```cpp\n  if (a)\n    b();\n  ```\n')['fragment_README_md_4.cpp'])

    def test_heads_of_headers(self):
        text = '// SPDX\n// What it is.\n//\n//   use(1);\n//\n//   use(2);\n//\n// And\n//   1. a list\n#pragma once\n//   not_the_head();\n'
        made = self.sources(text, 'include/covis/a.h')
        self.assertEqual(list(made), ['fragment_include_covis_a_h_4.cpp'])
        self.assertIn('\nuse(1);\n\nuse(2);\n', made['fragment_include_covis_a_h_4.cpp'])


if __name__ == '__main__':
    unittest.main()
