#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/check_includes.py: names with and without the header that declares them."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tools'))
import check_includes  # noqa: E402

FILES = {'src/covis/map/point.h': 'struct MapPoint {\n  struct Inner {};\n};\nconstexpr int kMost = 3;\nint count_points(const MapPoint& p);\n',
         'src/covis/map/map.h': '#include "covis/map/point.h"\nclass Map {\n  void add_all(int);\n};\n'}


class CheckIncludesTest(unittest.TestCase):
    def problems(self, text):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in {**FILES, 'src/covis/slam/a.cpp': text}.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(content)
            return check_includes.check_tree(pathlib.Path(folder))[1]

    def test_what_is_included_by_way_of_others_will_do(self):
        self.assertEqual(self.problems('#include "covis/map/map.h"\nMapPoint p;\nint n = count_points(p) + kMost;\n'), [])

    def test_what_is_not_is_named(self):
        for used, name in [('MapPoint p;', 'MapPoint'), ('int n = kMost;', 'kMost'), ('auto n = covis::count_points(p);', 'count_points()'),
                           ('std::vector<Map> m;', 'Map')]:
            found = self.problems(used + '\n')
            self.assertEqual(len(found), 1, used)
            self.assertIn(f'src/covis/slam/a.cpp: {name} is declared in src/covis/map/', found[0])

    def test_others_of_the_name_are_left_alone(self):
        for own in ['struct MapPoint {};\nMapPoint p;', '// MapPoint', 'auto s = "MapPoint";', 'other::MapPoint p;', 'x.count_points(1);',
                    'template <class Map>\nvoid f(const Map& m);', 'constexpr int kMost = 4;\nint n = kMost;']:
            self.assertEqual(self.problems(own + '\n'), [], own)


if __name__ == '__main__':
    unittest.main()
