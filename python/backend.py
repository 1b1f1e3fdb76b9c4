# SPDX-License-Identifier: Apache-2.0
"""Builds the wheel of the Python package for pip (PEP 517): CMake compiles the module, and the result is put into a zip.

    pip install .
"""
import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]


def version():
    return re.search(r'project\(covis VERSION (\S+)', (ROOT / 'CMakeLists.txt').read_text()).group(1)


def metadata():
    return (f'Metadata-Version: 2.1\nName: covis\nVersion: {version()}\n'
            'Summary: Visual SLAM for monocular, stereo and RGB-D cameras\nLicense: Apache-2.0\nRequires-Python: >=3.9\n'
            'Requires-Dist: numpy\n')


def build_package():
    """The folder of the built package."""
    build = ROOT / 'build' / 'wheel'
    subprocess.run(['cmake', '-S', ROOT, '-B', build, '-G', 'Ninja', '-DCMAKE_BUILD_TYPE=Release', '-DCMAKE_UNITY_BUILD=ON',
                    '-DCOVIS_PRECOMPILE=ON', '-DCOVIS_TESTS=OFF', '-DCOVIS_APPS=OFF', '-DCOVIS_PYTHON=ON',
                    f'-DPython_EXECUTABLE={sys.executable}'], check=True)
    subprocess.run(['cmake', '--build', build, '--target', 'covis_python'], check=True)
    return build / 'python' / 'covis'


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = build_package()
    python = f'cp{sys.version_info.major}{sys.version_info.minor}'
    tag = f'{python}-{python}-{sysconfig.get_platform().replace("-", "_").replace(".", "_")}'
    info = f'covis-{version()}.dist-info'
    files = {f'covis/{file.name}': file.read_bytes() for file in sorted(package.iterdir()) if file.is_file()}
    files[f'{info}/METADATA'] = metadata().encode()
    files[f'{info}/WHEEL'] = f'Wheel-Version: 1.0\nGenerator: covis\nRoot-Is-Purelib: false\nTag: {tag}\n'.encode()
    for name in ('LICENSE', 'NOTICE'):
        files[f'{info}/{name}'] = (ROOT / name).read_bytes()
    record = ''
    for name, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()
        record += f'{name},sha256={digest},{len(data)}\n'
    files[f'{info}/RECORD'] = (record + f'{info}/RECORD,,\n').encode()
    name = f'covis-{version()}-{tag}.whl'
    with zipfile.ZipFile(os.path.join(wheel_directory, name), 'w', zipfile.ZIP_DEFLATED) as wheel:
        for file, data in files.items():
            wheel.writestr(file, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError('there is no source distribution: install from a checkout')
