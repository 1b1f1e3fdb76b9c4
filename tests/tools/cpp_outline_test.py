#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/cpp_outline.py: what it reads from declarations that are easy to misread."""
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tools'))
from cpp_outline import Outline  # noqa: E402


def classes(text):
    """Class name to (fields, methods)."""
    return {c.name: (c.fields, c.methods) for c in Outline(text).classes}


def fields(members):
    return classes(f'struct S {{\n{members}\n}};')['S'][0]


def methods(members):
    return classes(f'class S {{\n{members}\n}};')['S'][1]


def functions(text):
    """(name, lines) of all but lambdas."""
    return [(f.name, f.lines) for f in Outline(text).functions if f.name != 'lambda']


def parameters(text):
    return [' '.join(p) for p in Outline(text).functions[0].parameters]


class FieldsTest(unittest.TestCase):
    def test_lists_and_initialisers(self):
        self.assertEqual(fields('int a, b = 2, c{3};'), ['a', 'b', 'c'])
        self.assertEqual(fields('double m[3] = {1, 2, 3}, *p = nullptr; const char& r;'), ['m', 'p', 'r'])
        self.assertEqual(fields('std::vector<int> v{1, 2}; Foo f = Foo{.x = 1, .y = 2};'), ['v', 'f'])
        self.assertEqual(fields('unsigned flag : 1, rest : 7;'), ['flag', 'rest'])
        self.assertEqual(fields('Point first, second;\nSE3 T_21;'), ['first', 'second', 'T_21'])

    def test_commas_and_angles_in_types(self):
        self.assertEqual(fields('std::map<int, std::pair<int, int>> a, b;'), ['a', 'b'])
        self.assertEqual(fields('std::array<int, (3 > 2) ? 4 : 5> a;'), ['a'])
        self.assertEqual(fields('static_vector<int, 1 << 4> a; int b = 1 < 2, c = 3 > 2;'), ['a', 'b', 'c'])

    def test_functions_as_fields(self):
        self.assertEqual(fields('std::function<void(int, bool)> visit_;'), ['visit_'])
        self.assertEqual(fields('std::function<int()> make_ = [](int a) { struct T { int x; }; return a; };'), ['make_'])
        self.assertEqual(len(fields('void (*callback_)(int, int);')), 1)
        self.assertEqual(fields('decltype(f(1)) a; alignas(64) std::atomic<int> b; int c GUARDED_BY(mutex_) = 0;'), ['a', 'b', 'c'])

    def test_what_is_no_field(self):
        self.assertEqual(fields('static constexpr int kA = 1; static const int kB = 2; using T = int; typedef int U;'), [])
        self.assertEqual(fields('friend class X; class Y; struct Z; enum class E { a, b }; enum F : int { c };'), [])
        self.assertEqual(fields('static_assert(sizeof(int) == 4, "int x;"); // int y;\n/* int z; */ template <class T> T f();'), [])
        self.assertEqual(fields('int f(); int g(int a = 3); S(); ~S(); S& operator=(const S&) = default; operator bool() const;'), [])
        self.assertEqual(fields('template <class T>\nstatic constexpr int size = sizeof(T);'), [])

    def test_static_state_is_a_field(self):
        self.assertEqual(fields('static int calls; inline static std::mutex lock;'), ['calls', 'lock'])

    def test_access_and_attributes(self):
        self.assertEqual(fields('public: int a;\nprivate: [[maybe_unused]] int b = 0; mutable std::mutex m;'), ['a', 'b', 'm'])

    def test_nested_classes_count_for_themselves(self):
        found = classes('class A { struct B { int x; struct C { int y, z; }; }; B b; struct D { int u; } d, e; enum { f, g } h; };')
        self.assertEqual({name: f for name, (f, _) in found.items()},
                         {'A': ['b', 'd', 'e', 'h'], 'A::B': ['x'], 'A::B::C': ['y', 'z'], 'A::D': ['u']})

    def test_unnamed_members(self):
        self.assertEqual(fields('union { int a; float b; }; struct { int c; } d;'), ['a', 'b', 'd'])

    def test_heads_of_classes(self):
        for head in ['class COVIS_API A final : public B<int, C>, D {', 'template <class T = std::less<int>>\nstruct A {',
                     'struct alignas(16) A {', 'template <class T> requires (sizeof(T) > 2) class A {', 'struct [[nodiscard]] A {']:
            self.assertEqual(classes(head + ' int x; };'), {'A': (['x'], [])}, head)
        self.assertEqual(classes('struct A::B { int x; void f(); };')['A::B'], (['x'], ['f']))

    def test_classes_in_functions(self):
        self.assertEqual(classes('void f() { struct L { int x, y; int g() { return 1; } }; if (a < b) { class M {}; } }'),
                         {'L': (['x', 'y'], ['g']), 'M': ([], [])})

    def test_one_branch_of_conditions(self):
        self.assertEqual(fields('#ifdef X\nint a;\n#else\nint a, b;\n#endif\nint c;'), ['a', 'c'])

    def test_text_is_no_code(self):
        self.assertEqual(fields('const char* s = "} int x; {"; char c = \'{\'; int n = 1\'000\'000;'), ['s', 'c', 'n'])
        self.assertEqual(fields('const char* raw = R"x(}; "int" )" )x"; int after;'), ['raw', 'after'])


class MethodsTest(unittest.TestCase):
    def test_what_counts(self):
        self.assertEqual(methods('S(); explicit S(int a) : a_{a}, b_(1) {} ~S(); void f(); int f(int) const { return 1; }'), ['f', 'f'])
        self.assertEqual(methods('bool operator==(const S&) const = default; void g() = delete; virtual int h() = 0;'), ['h'])
        self.assertEqual(methods('friend void f(S); static int g(); template <class T> T h(T t) { return t < 1 ? t : 2; }'), ['g', 'h'])
        self.assertEqual(methods('int operator()(int a) const; operator bool() const; S& operator<<(int); auto f() -> std::map<int, int>;'),
                         ['operator()', 'operatorbool', 'operator<<', 'f'])


class FunctionsTest(unittest.TestCase):
    def test_lines(self):
        self.assertEqual(functions('int f(int a,\n      int b) {\n  if (a) {\n  }\n  return b;\n}\nint g() { return 1; }\nint h();\n'),
                         [('f', 6), ('g', 1), ('h', 0)])
        self.assertEqual(functions('template <class T>\nT f()\n{\n}'), [('f', 4)])

    def test_names(self):
        self.assertEqual(functions('namespace a::b { namespace { A::B C::D::e(int x) const noexcept { } } }'), [('C::D::e', 1)])
        self.assertEqual(functions('class A { struct B { void f() {} }; };'), [('A::B::f', 1)])
        self.assertEqual(functions('A::A(int b) : b_{b}, c_(b) {\n}\nA::~A() {}\nbool A::operator<(A b) { return a < b; }'),
                         [('A::A', 2), ('A::~A', 1), ('A::operator<', 1)])

    def test_initialisers_are_no_functions(self):
        self.assertEqual(functions('const int a[] = {f(1), g(2)};\nauto h = [](int x) { return x; };\nFoo b{c(1)};'), [])

    def test_parameters(self):
        self.assertEqual(parameters('void f(const std::map<int, bool>& a, bool b = g(1, 2), std::function<void(bool, int)> c = {});'),
                         ['const std :: map < int , bool > & a', 'bool b = g ( 1 , 2 )',
                          'std :: function < void ( bool , int ) > c = { }'])
        self.assertEqual(parameters('A::A(bool a) : b(a) {}'), ['bool a'])

    def test_lambdas(self):
        found = Outline('void f() { int a[3]; a[1](2); auto g = [&](bool x, int y) { return [=](bool z) { return z; }; }; }\n'
                        'struct S { std::function<int(int)> h = [](bool u) { return 1; }; };').functions
        self.assertEqual([f.parameters for f in found if f.name == 'lambda'], [[['bool', 'x'], ['int', 'y']], [['bool', 'z']], [['bool', 'u']]])


class CommentsTest(unittest.TestCase):
    def comments(self, text):
        return [(c.line, c.text) for c in Outline(text).comments]

    def test_runs(self):
        self.assertEqual(self.comments('// a\n// b\n\n// c\nint x;  // d\n        // e\nint y;  // f\nint z;  // g\n// h\n'),
                         [(1, 'a\nb'), (4, 'c'), (5, 'd\ne'), (7, 'f'), (8, 'g'), (9, 'h')])

    def test_licence_is_none(self):
        self.assertEqual(self.comments('// SPDX-License-Identifier: Apache-2.0\n// What it is.\n'), [(2, 'What it is.')])

    def test_behind_directives_and_in_strings(self):
        self.assertEqual(self.comments('#include <a>  // why\n#define A "x" // b\nauto s = "// no";\n'), [(1, 'why'), (2, 'b')])

    def test_strings(self):
        self.assertEqual(list(Outline('f("a"\n  "b", "c"); // "d"\n').strings()), [(1, 'a\nb'), (2, 'c')])

    def test_includes(self):
        self.assertEqual(Outline('#include "a/b.h"\n#  include <c>  // d\n// #include "e"\n').includes, [(1, 'a/b.h', True), (2, 'c', False)])


if __name__ == '__main__':
    unittest.main()
