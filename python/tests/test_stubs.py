# SPDX-License-Identifier: Apache-2.0
"""The stubs name what the module has, and nothing else; every name says what it is, and every array its shape and dtype."""
import ast
import pathlib
import re

import pytest

import covis
from covis import _covis

STUBS = ast.parse(pathlib.Path(covis.__file__).with_name('__init__.pyi').read_text())


def names_of(nodes):
    names = {}
    for node in nodes:
        if isinstance(node, ast.ClassDef):
            names[node.name] = names_of(node.body)
        elif isinstance(node, ast.FunctionDef):
            names[node.name] = {}
        elif isinstance(node, ast.AnnAssign):
            names[node.target.id] = {}
    return names


def public(thing):
    return {name for name in dir(thing) if not name.startswith('_')}


def is_enum(thing):
    return hasattr(thing, '__members__')


def test_the_stubs_are_complete():
    stubs = names_of(STUBS.body)
    assert public(_covis) | {'plot', 'default_vocabulary'} == {name for name in stubs if not name.startswith('_')}
    for name, members in stubs.items():
        thing = getattr(covis, name)
        if not isinstance(thing, type) or issubclass(thing, Exception):
            continue
        mine = public(thing) - {'name', 'value'} if is_enum(thing) else public(thing)
        assert mine == {m for m in members if not m.startswith('_')}, name


def doc_of(thing):
    """Without what pybind11 writes by itself: the signature of a function, the members of an enum."""
    doc = re.sub(r'^\w+\(.*\) -> .*\n', '', thing.__doc__ or '')
    return re.split(r'^Members:', doc, flags=re.MULTILINE)[0].strip()


def test_everything_says_what_it_is():
    silent = []
    for name in public(_covis) | {'plot', 'default_vocabulary'}:
        thing = getattr(covis, name)
        if isinstance(thing, tuple):  # a constant
            continue
        members = public(thing) if isinstance(thing, type) and not is_enum(thing) and not issubclass(thing, Exception) else ()
        for path, each in [(name, thing)] + [(f'{name}.{member}', getattr(thing, member)) for member in members]:
            if len(doc_of(each)) < 5:
                silent.append(path)
    assert silent == []


def array_properties():
    """(class, property, dtype) of each array in the stubs."""
    for node in STUBS.body:
        for member in node.body if isinstance(node, ast.ClassDef) else ():
            returns = ast.unparse(member.returns) if isinstance(member, ast.FunctionDef) and member.decorator_list else ''
            found = re.search(r'NDArray\[np\.([a-z0-9]+)', returns)
            if found and returns.startswith(('NDArray', 'Optional')):
                yield node.name, member.name, found.group(1)


def test_arrays_are_what_their_documentation_and_stubs_say(desk, recording):
    slam, results, truth = desk
    frame = next(covis.Recording(recording('desk_rgbd'), first=10))
    pair = next(covis.Recording(recording('street_stereo')))
    path = slam.trajectory()
    things = [slam.snapshot(), path, path[0], covis.evaluate(path, truth), results[-1], frame, pair,
              slam.locate(frame.image, depth=frame.depth)]
    listed = list(array_properties())
    assert len(listed) > 30
    for cls, name, dtype in listed:
        doc = doc_of(getattr(getattr(covis, cls), name))
        shape = re.match(rf'\(([\w, ]+)\), {dtype}: ', doc)
        assert shape, f'{cls}.{name}: {doc}'
        arrays = [getattr(thing, name) for thing in things if type(thing).__name__ == cls]
        arrays = [array for array in arrays if array is not None]
        assert arrays, f'{cls}.{name}'
        for array in arrays:
            assert array.dtype == dtype, f'{cls}.{name}'
            wanted = shape.group(1).split(', ')
            assert array.ndim == len(wanted), f'{cls}.{name}'
            assert all(not w.isdigit() or int(w) == n for w, n in zip(wanted, array.shape)), f'{cls}.{name}'


@pytest.mark.parametrize('call', ['track', 'locate'])
def test_the_images_of_a_call_are_described(call):
    doc = doc_of(getattr(covis.Slam, call))
    for words in ('(height, width), uint8', '(height, width), float32, metres', '(height, width, 3), uint8'):
        assert words in doc
    assert call != 'track' or 'nanoseconds' in doc
