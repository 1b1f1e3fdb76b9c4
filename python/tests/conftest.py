# SPDX-License-Identifier: Apache-2.0
"""Recordings for the tests, rendered by the command (environment: COVIS its file, COVIS_SOURCE the project's root)."""
import os
import pathlib
import subprocess
import sys

import pytest

import covis

ROOT = pathlib.Path(os.environ.get('COVIS_SOURCE', pathlib.Path(__file__).resolve().parents[2]))
COVIS = os.environ.get('COVIS', 'covis')
sys.path.insert(0, str(ROOT / 'tests' / 'golden'))
import golden  # noqa: E402


class Renderer:
    def __init__(self, folder):
        self.folder = folder

    def __call__(self, name):
        """The folder of one of the golden recordings."""
        out = self.folder / name
        if not out.exists():
            subprocess.run([COVIS, 'synth', *golden.RECORDINGS[name], *golden.SIZE, '--quiet', '--out', out], check=True)
        return str(out)


@pytest.fixture(scope='session')
def recording(tmp_path_factory):
    return Renderer(tmp_path_factory.mktemp('recordings'))


def system(recording, **options):
    options.setdefault('timing', covis.Timing.deterministic)
    options.setdefault('vocabulary', covis.default_vocabulary())
    return covis.Slam(recording.camera, recording.sensor, **options)


def track_all(slam, recording):
    return [slam.track(f.stamp, f.image, right=f.right, depth=f.depth) for f in recording]


@pytest.fixture(scope='session')
def desk(recording):
    """A system that has seen the desk, its results, and the truth."""
    source = covis.Recording(recording('desk_rgbd'))
    slam = system(source)
    results = track_all(slam, source)
    slam.finish()
    return slam, results, source.truth()
