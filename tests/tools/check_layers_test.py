#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/check_layers.py: each rule on a tree that breaks it, and on one that only seems to."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tools'))
import check_layers  # noqa: E402

SPDX = '// SPDX-License-Identifier: Apache-2.0\n'


class CheckLayersTest(unittest.TestCase):
    def problems(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return check_layers.check_tree(pathlib.Path(folder))[1]

    def problem(self, name, text):
        """The only problem of a tree of one file."""
        found = self.problems({name: SPDX + text})
        self.assertEqual(len(found), 1, found)
        return found[0]

    def assert_clean(self, name, text):
        self.assertEqual(self.problems({name: SPDX + text}), [])

    def test_arrows_point_down(self):
        self.assert_clean('src/covis/map/a.h', '#include "covis/core/ids.h"\n#include "covis/map/b.h"\n')
        self.assertEqual(self.problem('src/covis/geometry/a.h', '\n#include "covis/map/map.h"\n'),
                         'src/covis/geometry/a.h:3: geometry must not include map')
        self.assertIn('optimization must not include features',
                      self.problem('src/covis/optimization/a.cpp', '#include "covis/features/features.h"\n'))
        self.assertIn('io must not include slam', self.problem('src/covis/io/a.cpp', '#  include <covis/slam/system.h>\n'))

    def test_the_table_has_no_way_back(self):
        for module, below in check_layers.LAYERS.items():
            for other in below:
                self.assertNotIn(module, check_layers.LAYERS[other], f'{module} and {other} include each other')

    def test_tests_look_further_but_not_up(self):
        self.assert_clean('src/covis/optimization/a_test.cpp', '#include "covis/map/map.h"\n#include <ceres/ceres.h>\n')
        self.assert_clean('src/covis/slam/test_scene.h', '#include "synth/worlds/world.h"\n')
        self.assertIn('a test of map must not include slam',
                      self.problem('src/covis/map/a_test.cpp', '#include "covis/slam/system.h"\n'))

    def test_the_core_needs_little(self):
        self.assert_clean('src/covis/features/a.cpp',
                          '#include <vector>\n#include <Eigen/Core>\n#include "hwy/highway.h"\n#include <tl/expected.hpp>\n')
        for header in ['opencv2/core.hpp', 'yaml-cpp/yaml.h', 'spdlog/spdlog.h', 'ceres/ceres.h', 'immintrin.h', 'unistd.h']:
            self.assertIn(f'must not include <{header}>', self.problem('src/covis/features/a.cpp', f'#include <{header}>\n'))

    def test_what_tests_of_the_core_share_needs_little_too(self):
        self.assert_clean('src/covis/features/test_a.h', '#include <gtest/gtest.h>\n#include <gmock/gmock.h>\n')
        self.assert_clean('src/covis/features/a_test.cpp', '#include <gtest/gtest.h>\n#include <opencv2/imgproc.hpp>\n')
        for header in ['opencv2/imgproc.hpp', 'ceres/ceres.h']:
            self.assertIn(f'must not include <{header}>',
                          self.problem('src/covis/features/test_a.h', f'#include <{header}>\n'))
        self.assertIn('must not include <opencv2/imgproc.hpp>',
                      self.problem('src/covis/features/test_opencv.h', '#include <opencv2/imgproc.hpp>\n'))
        self.assertIn('must not include <gtest/gtest.h>',
                      self.problem('src/covis/features/a.h', '#include <gtest/gtest.h>\n'))

    def test_modules_around_the_core(self):
        self.assert_clean('src/covis/io/a.cpp', '#include <opencv2/imgcodecs.hpp>\n#include <unistd.h>\n')
        for header in ['opencv2/highgui.hpp', 'spdlog/spdlog.h', 'CLI/CLI.hpp']:
            self.assertIn(f'synth must not include <{header}>',
                          self.problem('synth/a.cpp', f'#include <{header}>\n'))

    def test_synth_lies_beside_the_library(self):
        self.assert_clean('synth/a.cpp', '#include "covis/io/files.h"\n#include "synth/worlds/world.h"\n')
        self.assert_clean('synth/things/a.cpp', '#include "synth/render/scene.h"\n#include "covis/core/random.h"\n')
        self.assertIn('synth must not include slam', self.problem('synth/a.cpp', '#include "covis/slam/system.h"\n'))
        self.assertIn('synth/render must not include synth/things',
                      self.problem('synth/render/a.cpp', '#include "synth/things/prints.h"\n'))
        self.assertIn('io must not include synth', self.problem('src/covis/io/a.cpp', '#include "synth/synth.h"\n'))
        self.assertIn('is no module known', self.problem('synth/extra/a.cpp', ''))
        self.assertIn('as "synth/render/scene.h"', self.problem('synth/render/a.cpp', '#include "scene.h"\n'))

    def test_public_headers_are_for_the_outside(self):
        self.assert_clean('src/covis/api/a.cpp', '#include "covis/version.h"\n')
        self.assertIn('public header', self.problem('src/covis/slam/a.cpp', '#include "covis/version.h"\n'))

    def test_unknown_modules(self):
        self.assertIn('of no module known', self.problem('src/covis/slam/a.cpp', '#include "covis/extra/a.h"\n'))
        self.assertIn('is no module known', self.problem('src/covis/extra/a.cpp', ''))

    def test_relative_includes(self):
        self.assertIn('as "covis/map/slot.h"', self.problem('src/covis/map/a.cpp', '#include "slot.h"\n'))

    def test_forbidden_calls(self):
        for call in ['std::this_thread::sleep_for(ms(3));', 'usleep(3);', 'std::this_thread::yield();', 'std::cout << 1;',
                     'printf("x");', 'std::exit(1);', 'exit(1);', 'int i = rand();', 'std::random_device d;']:
            self.assertIn('src/covis/slam/a.cpp:2: the library', self.problem('src/covis/slam/a.cpp', call + '\n'))
            self.assert_clean('src/covis/slam/a_test.cpp', call + '\n')
            self.assert_clean('apps/main.cpp', call + '\n')

    def test_comments_strings_and_like_names_are_no_calls(self):
        self.assert_clean('src/covis/slam/a.cpp', '// never sleep_for(3)\n/* exit(1)\n rand() */\nauto s = "exit(1)";\n'
                          'std::snprintf(a, b, "c"); window.exit(); operand(1); loop_exit(2);\n')

    def test_licence(self):
        self.assertIn('src/covis/map/a.h:1: its first lines', self.problems({'src/covis/map/a.h': '#pragma once\n'})[0])
        self.assertEqual(self.problems({'tools/run': '#!/bin/sh\n# SPDX-License-Identifier: Apache-2.0\n'}), [])
        self.assertEqual(len(self.problems({'tools/run': '#!/bin/sh\ntrue\n'})), 1)


if __name__ == '__main__':
    unittest.main()
