# SPDX-License-Identifier: Apache-2.0
"""Kinds of bad input, by groups."""
import importlib

MODULES = ('options', 'settings', 'cameras', 'recordings', 'images', 'trajectories', 'maps', 'outputs')


def all_kinds():
    """All kinds, in the order in which they are tried. No two of a group have one name."""
    kinds = [kind for name in MODULES for kind in importlib.import_module(f'.{name}', __name__).kinds()]
    names = [(kind.group, kind.name) for kind in kinds]
    assert len(set(names)) == len(names), sorted(name for name in names if names.count(name) > 1)
    return kinds
