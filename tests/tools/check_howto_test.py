#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tests/tools/check_howto.py: rows and pictures that hold, and those that do not."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_howto  # noqa: E402

FILES = {'tests/a_test.cpp': 'TEST_F(Suite, Case) {\n  run("--out");\n  slam->save_map(file);\n}\n',
         'tests/b_test.py': 'class Some(unittest.TestCase):\n    def test_it(self):\n        run("--to")\n\ndef test_alone():\n    pass\n',
         'tests/CMakeLists.txt': 'add_test(NAME whole COMMAND x)\n'}
GOOD = '| a | `covis run x.mp4 --out y`, `slam->save_map(…)` | more | [`Suite.Case`](../tests/a_test.cpp) |'


class CheckHowtoTest(unittest.TestCase):
    def problems(self, row, rows=check_howto.ROWS, more=''):
        with tempfile.TemporaryDirectory() as folder:
            table = '\n'.join(['| wanted | how | more | tests |', '| --- | --- | --- | --- |', *[GOOD] * (rows - 1), row])
            for name, content in {**FILES, 'docs/howto.md': f'# Page\n\n{table}\n\n{more or "| another | table |"}\n',
                                  **({'docs/images/a.png': ''} if more else {})}.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(content, encoding='utf-8')
            return list(check_howto.problems(pathlib.Path(folder).resolve()))

    def test_rows_that_hold(self):
        for row in (GOOD, '| b | `covis map export --to x` | | [`Some.test_it`](../tests/b_test.py) |',
                    '| c | `x` | | [`test_alone`](../tests/b_test.py), [`whole`](../tests/CMakeLists.txt) |'):
            self.assertEqual(self.problems(row), [])

    def test_rows_that_do_not(self):
        for row, problem in (('| b | `x` | | none |', 'b: no test is named'),
                             ('| b | `x` | | [`Suite.Other`](../tests/a_test.cpp) |', 'b: ../tests/a_test.cpp has no test Suite.Other'),
                             ('| b | `x` | | [`Other.test_it`](../tests/b_test.py) |', 'b: ../tests/b_test.py has no test Other.test_it'),
                             ('| b | `x` | | [`other`](../tests/CMakeLists.txt) |', 'b: ../tests/CMakeLists.txt has no test other'),
                             ('| b | `run --out-of` | | [`Suite.Case`](../tests/a_test.cpp) |', 'b: none of its tests uses --out-of'),
                             ('| b | `slam.load_map(f)` | | [`Suite.Case`](../tests/a_test.cpp) |', 'b: none of its tests uses load_map')):
            self.assertEqual(self.problems(row), [problem])
        self.assertEqual(self.problems('| b | `x` | | [`X.Y`](../gone.cpp) |')[0], 'b: there is no ../gone.cpp')
        self.assertIn('9 rows', self.problems(GOOD, 9)[0])

    def test_pictures(self):
        made = '| it, `docs/images/a.png` | `bench/it` |'
        self.assertEqual(self.problems(GOOD, more=f'![It](images/a.png)\n\n{made}'), [])
        self.assertEqual(self.problems(GOOD, more=made), ['docs/images/a.png: no page shows it'])
        self.assertEqual(self.problems(GOOD, more='![It](images/a.png)'), ['docs/images/a.png: docs/howto.md does not say how it is made'])


if __name__ == '__main__':
    unittest.main()
