# SPDX-License-Identifier: Apache-2.0
"""The documentation's example, and the package as pip installs it."""
import os
import pathlib
import re
import subprocess
import sys

import covis
from conftest import ROOT

sys.path.insert(0, str(ROOT / 'python'))
import backend  # noqa: E402


def test_the_example_of_the_documentation_runs(recording, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'office').symlink_to(recording('desk_rgbd'))
    for page in ('docs/python.md', 'docs/howto.md'):
        for example in re.findall(r'```python\n(.*?)```', (ROOT / page).read_text(), re.DOTALL):
            exec(compile(example, page, 'exec'), {})
    said = capsys.readouterr().out
    assert 'ATE' in said and 'not recognised' not in said
    assert (tmp_path / 'path.png').stat().st_size > 5000
    assert (tmp_path / 'trajectory.txt').exists() and (tmp_path / 'office.m').exists()


def test_the_wheel_can_be_installed(recording, tmp_path, monkeypatch):
    """With the module that is built already; pip install . compiles it."""
    monkeypatch.setattr(backend, 'build_package', lambda: pathlib.Path(covis.__file__).parent)
    name = backend.build_wheel(str(tmp_path))
    assert name.startswith(f'covis-{covis.__version__}-cp3')
    target = tmp_path / 'site'
    subprocess.run([sys.executable, '-m', 'pip', 'install', '--quiet', '--no-deps', '--no-index', '--target', target,
                    tmp_path / name], check=True)
    environment = {**os.environ, 'PYTHONPATH': str(target)}
    said = subprocess.run([sys.executable, '-c', 'import covis, sys; print(covis.__file__, covis.default_vocabulary());'
                           'print(next(iter(covis.Recording(sys.argv[1]))).image.shape)', recording('desk_rgbd')],
                          check=True, env=environment, capture_output=True, text=True, cwd=tmp_path).stdout
    assert said.count(str(target)) == 2
    assert pathlib.Path(said.split()[1]).exists()
    assert '(240, 320)' in said, 'it brings what reads images'


LOADED_BY_A_RELATIVE_PATH = """
import importlib.machinery, importlib.util, os, sys
loader = importlib.machinery.ExtensionFileLoader('_covis', sys.argv[1])
module = importlib.util.module_from_spec(importlib.machinery.ModuleSpec('_covis', loader, origin=sys.argv[1]))
os.chdir(sys.argv[2])
next(iter(module.Recording('.')))
"""


def test_plug_ins_are_not_looked_for_from_the_working_folder(recording):
    """The loader keeps a relative path as it was, and another folder may have become the working one."""
    module = pathlib.Path(covis._covis.__file__)
    run = subprocess.run([sys.executable, '-c', LOADED_BY_A_RELATIVE_PATH, f'./{module.name}', recording('desk_rgbd')],
                         cwd=module.parent, capture_output=True, text=True)
    assert f"can't be looked for: Covis was loaded by a relative path, ./{module.name}" in run.stderr


def test_arrays_are_made_so_that_numpy_2_is_served():
    """pybind11 before 2.12 reads the size of an untyped array's elements where NumPy 2 keeps flags; py::array_t knows it by itself."""
    untyped = re.compile(r'\bpy::array(?!_t)\b(?! *(?:>|::))\s*\w*\s*[({]|\bpy::dtype\b|\b(?:itemsize|nbytes|has_fields)\(')
    assert untyped.search('py::array a(shape)') and untyped.search('return py::array({2}, p);') and untyped.search('array.nbytes()')
    sources = [source for suffix in ('*.cpp', '*.h') for source in (ROOT / 'python').glob(suffix)]
    assert len(sources) > 3
    assert [source.name for source in sources if untyped.search(source.read_text())] == []
