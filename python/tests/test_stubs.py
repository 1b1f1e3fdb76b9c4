# SPDX-License-Identifier: Apache-2.0
"""The stubs name what the module has, and nothing else."""
import ast
import pathlib

import covis
from covis import _covis

STUBS = pathlib.Path(covis.__file__).with_name('__init__.pyi')


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


def test_the_stubs_are_complete():
    stubs = names_of(ast.parse(STUBS.read_text()).body)
    assert public(_covis) | {'plot', 'default_vocabulary'} == {name for name in stubs if not name.startswith('_')}
    for name, members in stubs.items():
        thing = getattr(covis, name)
        if not isinstance(thing, type) or issubclass(thing, Exception):
            continue
        mine = public(thing) - {'name', 'value'} if hasattr(thing, '__members__') else public(thing)
        assert mine == {m for m in members if not m.startswith('_')}, name


def test_everything_says_what_it_is():
    for name in ('Slam', 'Pose', 'Camera', 'Recording', 'Snapshot', 'Trajectory', 'Evaluation'):
        assert getattr(covis, name).__doc__, name
    assert 'uint8' in covis.Slam.track.__doc__ and 'nanoseconds' in covis.Slam.track.__doc__
