# SPDX-License-Identifier: Apache-2.0
"""Names of files: any kind that Python's open() takes, and messages about names that are not of UTF-8."""
import os
import pathlib
import shutil

import numpy as np
import pytest

import covis
from conftest import system


@pytest.mark.parametrize('kind', [str, pathlib.Path, os.fsencode])
def test_files_are_named_as_for_open(desk, recording, tmp_path, kind):
    slam, _, _ = desk
    source = covis.Recording(kind(recording('desk_rgbd')), count=1)
    saved, path = kind(str(tmp_path / 'desk.m')), kind(str(tmp_path / 'path.txt'))
    slam.save_map(saved)
    later = system(source, map=saved, mode=covis.Mode.localisation, vocabulary=kind(covis.default_vocabulary()))
    later.load_map(saved)
    assert len(later.snapshot().points) == len(slam.snapshot().points)
    slam.trajectory().save(path)
    assert len(covis.Trajectory.load(path)) == len(slam.trajectory())


def test_a_name_that_is_not_utf8(recording, tmp_path):
    odd = os.fsdecode(os.fsencode(tmp_path) + b'/desk\xff')
    with pytest.raises(covis.Error, match=r'desk\\xff'):
        covis.Recording(odd)
    shutil.copytree(recording('desk_rgbd'), odd)
    source = covis.Recording(odd, count=3)
    assert source.description and next(source).image.shape == (240, 320)
    with pytest.raises(covis.Error, match=r'none\\xff'):
        covis.Trajectory.load(os.fsencode(tmp_path) + b'/none\xff')


def test_a_name_that_ends_early_is_refused(desk, tmp_path):
    with pytest.raises((TypeError, ValueError)):
        desk[0].save_map(str(tmp_path / 'desk') + '\0.m')
    assert not list(tmp_path.iterdir())


def test_true_may_be_numpys(recording):
    source = covis.Recording(recording('desk_rgbd'), count=1)
    for value, text in ((np.True_, 'true'), (False, 'false'), (np.bool_(False), 'false')):
        settings = {s.name: s.value for s in system(source, settings={'orb.subpixel': value}).settings}
        assert settings['orb.subpixel'] == text
