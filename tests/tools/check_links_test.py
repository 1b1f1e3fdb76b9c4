#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tests/tools/check_links.py: links that lead somewhere, and those that do not."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_links  # noqa: E402

FILES = {'docs/a.md': '# A page: `code` & more\n\n## Twice\n\n## Twice\n\n```\n# no heading\n```\n<a name="here"></a>\n\nUnderlined\n----------\n',
         'src/b.h': 'one\ntwo\n', 'docs/images/c d.png': ''}


class CheckLinksTest(unittest.TestCase):
    def check(self, text, page='README.md'):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in {**FILES, page: text}.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(content)
            return check_links.check_tree(pathlib.Path(folder))

    def assert_good(self, text, count=1, page='README.md'):
        self.assertEqual(self.check(text, page), (count, []))

    def assert_bad(self, text, problem, page='README.md'):
        found = self.check(text, page)[1]
        self.assertEqual(len(found), 1, found)
        self.assertIn(problem, found[0])

    def test_files_and_folders(self):
        self.assert_good('[a](docs/a.md), [b](src/b.h "title"), [docs](docs/), ![c](docs/images/c%20d.png), [d](<docs/images/c d.png>)', 5)
        self.assert_good('[b](../../src/b.h)', page='docs/notes/001-x.md')
        self.assert_bad('\n[a](docs/x.md)', 'README.md:2: docs/x.md: there is no docs/x.md')
        self.assert_bad('[b](src/b.h)', 'docs/x.md:1: src/b.h: there is no docs/src/b.h', 'docs/x.md')

    def test_anchors(self):
        self.assert_good('# Top\n[a](docs/a.md#a-page-code--more) [b](docs/a.md#twice-1) [c](docs/a.md#here) [d](#top) [e](docs/a.md#underlined)', 5)
        self.assert_bad('[a](docs/a.md#twice-2)', 'no heading of docs/a.md has the anchor twice-2')
        self.assert_bad('[a](docs/a.md#no-heading)', 'has the anchor no-heading')
        self.assert_bad('[a](#nowhere)', 'no heading of README.md')
        self.assert_bad('[a](docs#a)', 'is a folder')

    def test_lines_of_sources(self):
        self.assert_good('[b](src/b.h#L2) [b](src/b.h#L1-L2)', 2)
        self.assert_bad('[b](src/b.h#L3)', 'src/b.h is shorter')

    def test_other_forms(self):
        self.assert_good('[![pic](docs/images/c%20d.png)](docs/a.md)', 2)
        self.assert_bad('[![pic](docs/x.png)](docs/a.md)', 'there is no docs/x.png')
        self.assert_good('[a][one]\n\n[one]: docs/a.md')
        self.assert_bad('[one]: docs/x.md', 'there is no docs/x.md')
        self.assert_bad('[a][one]', '[one] is not defined')
        self.assert_bad('<img width="9" src="docs/x.png">', 'there is no docs/x.png')
        self.assert_bad('one [link over\ntwo lines](docs/x.md)', 'README.md:1: docs/x.md')

    def test_code_and_the_net_are_left_out(self):
        self.assert_good('`[a](x.md)` and ``[a](`x`.md)`` [w](https://example.org/x) [m](mailto:a@b.c)\n\n```\n[a](x.md)\n```\n~~~\n[a](x.md)\n~~~\n', 2)

    def test_ways_out(self):
        self.assert_bad('[a](/docs/a.md)', 'relative to the page')
        self.assert_bad('[a](../x)', 'leads out of the project')
        self.assert_bad('[a]()', 'a link to nowhere')


if __name__ == '__main__':
    unittest.main()
