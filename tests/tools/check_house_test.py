#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/check_house.py: each rule on a tree that breaks it, and on one that only seems to."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tools'))
import check_house  # noqa: E402


def fields(count, head='class A'):
    return head + ' {\n' + ''.join(f'int a{n};\n' for n in range(count)) + '};\n'


class CheckHouseTest(unittest.TestCase):
    def rules(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return {rule.name: rule for rule in check_house.check_tree(pathlib.Path(folder).resolve())[1]}

    def rule(self, name, files):
        return self.rules(files)[name]

    def assert_broken(self, name, files, *problems):
        rule = self.rule(name, files)
        self.assertFalse(rule.good)
        for problem in problems:
            self.assertIn(problem, '\n'.join(rule.problems))

    def assert_good(self, name, files):
        rule = self.rule(name, files)
        self.assertEqual((rule.good, rule.problems), (True, []))

    def test_every_bar_has_its_rule(self):
        self.assertEqual(set(self.rules({'src/a.cpp': ''})), set(check_house.BARS))

    def test_fields_of_tracking(self):
        name = 'fields of a class of tracking'
        self.assert_broken(name, {'src/covis/tracking/a.h': '\n' + fields(16)}, 'src/covis/tracking/a.h:2: A has 16 fields, at most 15')
        self.assert_good(name, {'src/covis/tracking/a.h': fields(15)})
        self.assert_good(name, {'src/covis/tracking/a_test.cpp': fields(16), 'src/covis/map/a.h': fields(16)})

    def test_methods_of_tracking(self):
        methods = ''.join(f'void f{n}();\n' for n in range(21))
        self.assert_broken('methods of a class of tracking', {'src/covis/tracking/a.cpp': 'class A {\n' + methods + '};'},
                           'src/covis/tracking/a.cpp:1: A has 21 methods, at most 20')

    def test_fields_of_others(self):
        name = 'fields of another class or struct'
        for file, text in [('mapping/a.h', fields(13)), ('slam/sub/a.cpp', fields(13, 'struct A')), ('tracking/a.h', fields(13, 'struct A')),
                           ('loops/a.h', 'class B {\n' + fields(13) + '};')]:
            self.assert_broken(name, {f'src/covis/{file}': text}, 'A has 13 fields, at most 12')
        self.assert_good(name, {'src/covis/loops/a.h': fields(12) + fields(13, 'struct AOptions'), 'src/covis/core/b.h': fields(13)})

    def test_fields_of_options(self):
        name = 'fields of an options struct'
        self.assert_broken(name, {'src/covis/slam/a.h': fields(16, 'struct AOptions')}, 'AOptions has 16 fields, at most 15')
        self.assert_good(name, {'src/covis/slam/a.h': fields(15, 'struct AOptions')})

    def test_bools(self):
        name = 'bool parameters, per 1000 lines'
        self.assert_broken(name, {'src/a.cpp': 'void f(int a, const bool b = true);\n'}, 'src/a.cpp:1: f takes const bool b = true')
        self.assert_broken(name, {'synth/a.cpp': 'auto f = [](bool b) { return b; };\n'}, 'synth/a.cpp:1: lambda takes bool b')
        for text in ['void f(bool& out, bool* p, std::function<void(bool)> g, std::optional<bool> h);', 'struct A { bool b; bool c(); };',
                     'void f(bool);  // tests\n' + '\n' * 1001]:
            self.assert_good(name, {'src/a.h': text})
        self.assert_good(name, {'src/a_test.cpp': 'void f(bool b);', 'tests/b.cpp': 'void f(bool b);'})

    def test_a_declaration_and_its_definition_are_one(self):
        files = {'src/a.h': 'struct A { void f(bool x); };\nvoid g(int, bool y = true);\n',
                 'src/a.cpp': 'void A::f(bool x) {}\nvoid g(int i, bool y) {}\nnamespace { void h(bool z) {} }\n',
                 'src/b.cpp': 'namespace { void h(bool z) {} }\n'}
        self.assertEqual(len(self.rule('bool parameters, per 1000 lines', files).rows), 1 + 4)

    def test_tests_beside_the_sources(self):
        name = 'sources with a test of their own, %'
        code = 'inline int f() { return 1; }\n'
        self.assert_broken(name, {'src/covis/a/a.cpp': '', 'src/covis/b/a_test.cpp': ''}, '0 of 1 sources', 'src/covis/a/a.cpp:1: no a_test.cpp beside it')
        self.assert_broken(name, {'src/covis/a/a.h': code}, 'src/covis/a/a.h:1')
        self.assert_good(name, {'src/covis/a/a.h': code, 'src/covis/a/a.cpp': '', 'src/covis/a/a_test.cpp': ''})
        self.assert_good(name, {'synth/a-inl.h': code, 'synth/a.cpp': '', 'synth/a_test.cpp': '', 'synth/b.h': 'int f();\nstruct A {};'})
        self.assert_good(name, {'apps/main.cpp': '', 'apps/cmd_a.cpp': '', 'src/covis/a/test_a.h': code, 'include/covis/a.h': code})

    def test_circles_of_files(self):
        name = 'include circles of files'
        self.assert_broken(name, {'src/covis/a/a.h': '#include "covis/a/b.h"\n', 'src/covis/a/b.h': '\n#include "covis/a/c.h"\n',
                                  'src/covis/a/c.h': '#include "covis/a/a.h"\n'},
                           'src/covis/a/c.h:1: closes the circle src/covis/a/a.h -> src/covis/a/b.h -> src/covis/a/c.h -> src/covis/a/a.h')
        self.assert_good(name, {'src/covis/a/a.h': '#include "covis/a/b.h"\n#include "covis/a/c.h"\n#include <a.h>\n',
                                'src/covis/a/b.h': '#include "covis/a/c.h"\n', 'src/covis/a/c.h': '// #include "covis/a/a.h"\n'})

    def test_circles_of_folders(self):
        name = 'include circles of folders'
        circle = {'src/covis/a/a.h': '#include "covis/b/b.h"\n', 'src/covis/b/b.h': '', 'src/covis/b/c.cpp': '#include "covis/a/a.h"\n'}
        self.assert_broken(name, circle, 'closes the circle src/covis/a -> src/covis/b -> src/covis/a')
        self.assert_good('include circles of files', circle)
        self.assert_broken(name, {'synth/a.h': '#include "synth/worlds/b.h"\n', 'synth/worlds/b.h': '#include "synth/c.h"\n', 'synth/c.h': ''}, 'synth/worlds')
        self.assert_good(name, {**circle, 'src/covis/b/c.cpp': '', 'src/covis/b/c_test.cpp': circle['src/covis/b/c.cpp']})

    def test_lines_of_files(self):
        self.assert_broken('lines of a file', {'tests/a_test.cpp': '\n' * 401}, 'tests/a_test.cpp:1: a_test.cpp has 401 lines, at most 400')
        self.assert_good('lines of a file', {'src/a.cpp': '\n' * 400})

    def test_lines_of_functions(self):
        long = 'void f() {\n' + '\n' * 99 + '}\n'
        self.assert_broken('lines of a function', {'src/a.cpp': '\n' + long}, 'src/a.cpp:2: f has 101 lines, at most 100')
        self.assert_good('lines of a function', {'src/a.cpp': long.replace('\n\n', '\n', 1), 'src/a_test.cpp': long})

    def test_share_of_long_functions(self):
        name, long = 'functions over 50 lines, %', 'void f() {\n' + '\n' * 49 + '}\n'
        self.assert_broken(name, {'src/a.cpp': long + 'void g() {}\n' * 32}, '1 of 33 functions', 'src/a.cpp:1: f has 51 lines')
        self.assert_good(name, {'src/a.cpp': long + 'void g() {}\n' * 33})

    def test_comments_that_are_fragments(self):
        name = 'comments that begin with a fragment, %'
        for word in ['of the map', '"Whether it is', 'What it does', '… nothing else']:
            self.assert_broken(name, {'bench/a.cpp': f'int a;  // {word}\n'}, f'bench/a.cpp:1: {word}')
        self.assert_good(name, {'src/a.cpp': '// Offers\n// of it\n\n// 3 of them\nint a;  // often\n        // where it is\nauto s = "// of";\n'})

    def test_the_share_of_comments(self):
        text = '// A sentence.\n\n' * 99 + '// Of a fragment.\n'
        self.assert_broken('comments that begin with a fragment, %', {'src/a.cpp': text}, '1 of 100 comments')
        self.assert_good('comments that begin with a fragment, %', {'src/a.cpp': '// A sentence.\n\n' + text})

    def test_comments_that_are_not_counted(self):
        text = '// SPDX-License-Identifier: Apache-2.0\n\n// A sentence.\n\n}  // namespace covis\n// clang-format off\nint a;  // NOLINT\n// Of it.\n'
        self.assert_broken('comments that begin with a fragment, %', {'src/a.cpp': text}, '1 of 2 comments')

    def test_words(self):
        name = 'words of the old dialect'
        for said, written in [('key points', 'keypoint'), ('Base line', 'baseline'), ('gone on with', 'continued'), ('made one', 'fused'),
                              ('hangs on', 'relative to'), ('told', 'reported'), ('taken over', 'apply'), ('doubtful', 'tentative'),
                              ('bridged', 'dead-reckoned'), ('usual share', 'expected match ratio'), ('a part of the map', 'submap')]:
            for text in [f'int a;\n// It {said} here.\n', f'int a;\nauto s = "\\n{said}";\n', '\n// ' + said.replace(' ', '\n// ') + '\n']:
                self.assert_broken(name, {'src/a.cpp': text}, 'src/a.cpp:2: "', f'write {written}')
            self.assert_broken(name, {'docs/notes/a.md': f'A\n{said}.\n'}, 'docs/notes/a.md:2')

    def test_words_that_are_none(self):
        self.assert_good('words of the old dialect', {
            'src/a.cpp': 'int told, doubtful;  // untold keypoints, the hangar is only\n', 'README.md': 'A baseline.\n<!-- house:ok --> "key point"\n',
            'tools/a.md': 'told\n'})

    def test_the_table_says_nothing_it_forbids(self):
        for _, instead in check_house.WORDS:
            self.assertFalse(any(pattern.search(instead) for pattern, _ in check_house.WORDS), instead)


if __name__ == '__main__':
    unittest.main()
