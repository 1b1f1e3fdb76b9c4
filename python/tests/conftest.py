# SPDX-License-Identifier: Apache-2.0
"""Recordings for the tests, rendered by the command (environment: COVIS its file, COVIS_SOURCE the project's root)."""
import os
import pathlib
import subprocess
import sys

import pytest

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
