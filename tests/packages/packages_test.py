#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Debian packages that cpack makes of a build folder: what they are, and that what is in them runs from a clean folder.

  tests/packages/packages_test.py CPACK BUILD
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import inputs

CPACK, BUILD = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
WORK = pathlib.Path(tempfile.mkdtemp(prefix='covis_packages'))
ROOT = WORK / 'root'
PACKAGES = {}  # name: file


def run(*command, **more):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode != 0:
        raise AssertionError(f'{command}: exit code {done.returncode}\n{done.stdout}')
    return done.stdout


def setUpModule():
    run(CPACK, '-G', 'DEB', '--config', BUILD / 'CPackConfig.cmake', '-B', WORK / 'packages')
    for file in (WORK / 'packages').glob('*.deb'):
        PACKAGES[field(file, 'Package')] = file
        run('dpkg-deb', '-x', file, ROOT)


def tearDownModule():
    shutil.rmtree(WORK)


def field(file, name):
    return run('dpkg-deb', '--field', file, name).strip()


def installed(*command):
    """Runs a command of the packages, where nothing else of the project is in the way."""
    environment = {**os.environ, 'PATH': f'{ROOT}/usr/bin:/usr/bin:/bin', 'LD_LIBRARY_PATH': str(ROOT / 'usr/lib'),
                   'PYTHONPATH': str(next((ROOT / 'usr/lib').glob('python3*/dist-packages')))}
    return run(*command, cwd=WORK, env=environment)


class Packages(unittest.TestCase):
    def test_what_is_run_is_hardened(self):
        library = next((ROOT / 'usr/lib').glob('libcovis.so.*.*.*'))
        for file in (ROOT / 'usr/bin/covis', library):
            read = run('readelf', '--wide', '--dynamic', '--program-headers', '--symbols', file)
            for wanted in ('BIND_NOW', 'GNU_RELRO', '__stack_chk_fail', '_chk@'):
                self.assertTrue(wanted in read, f'{file}: {wanted}')
            self.assertTrue(re.search(r'GNU_STACK .* RW +0x', read), f'{file}: a stack that can be executed')
        for file in (ROOT / 'usr/lib/covis').iterdir():
            read = run('readelf', '--wide', '--dynamic', '--program-headers', file)
            self.assertTrue('BIND_NOW' in read and 'GNU_RELRO' in read and re.search(r'GNU_STACK .* RW +0x', read), file)
        self.assertTrue('PIE' in run('readelf', '--wide', '--dynamic', ROOT / 'usr/bin/covis'))

    def test_each_has_its_name_and_what_it_needs(self):
        version = field(PACKAGES['covis'], 'Version')
        library = f'libcovis{".".join(version.split(".")[:2])}'
        self.assertEqual(set(PACKAGES), {'covis', 'covis-data', 'libcovis-dev', library, 'python3-covis'})
        for name, wanted in (('covis', 'libopencv-core'), ('covis', 'librosbag-storage'), ('covis', 'libopencv-videoio'), ('covis', 'libopencv-imgcodecs'),
                             ('python3-covis', 'librosbag-storage'), ('python3-covis', 'libopencv-videoio'), ('covis', 'libsqlite3'),
                             ('covis', f'covis-data (= {version})'), (library, 'libhwy'),
                             ('libcovis-dev', f'{library} (= {version})'), ('python3-covis', 'python3-numpy'), ('python3-covis', 'python3 (<<')):
            self.assertIn(wanted, field(PACKAGES[name], 'Depends'))
        self.assertNotIn('opencv', field(PACKAGES[library], 'Depends'), 'the library needs none')
        self.assertEqual(field(PACKAGES['covis-data'], 'Architecture'), 'all')

    def test_each_has_its_licence_and_no_file_of_another(self):
        owners = {}
        for name, file in PACKAGES.items():
            for line in run('dpkg-deb', '--contents', file).splitlines():
                path = line.split()[5]
                if not path.endswith('/'):
                    self.assertNotIn(path, owners, name)
                    owners[path] = name
            self.assertIn(f'./usr/share/doc/{name}/NOTICE', owners)
        self.assertIn('three.js', (ROOT / 'usr/share/doc/covis/NOTICE').read_text())

    def test_apt_would_install_them(self):
        """On a machine without any package. tools/test_packages shows that the dependencies suffice."""
        (WORK / 'nothing').touch()
        bare = ('-o', f'Dir::State::status={WORK}/nothing')
        if not run('apt-cache', *bare, 'pkgnames', 'libhwy'):
            self.skipTest('apt has no lists of Debian here')
        text = run('apt-get', '-s', *bare, 'install', '--no-install-recommends', *PACKAGES.values())
        for name in PACKAGES:
            self.assertRegex(text, f'(?m)^Inst {re.escape(name)} ')

    def test_the_command_runs_and_finds_its_vocabulary(self):
        self.assertRegex(installed('covis', '--version'), r'^covis \d')
        installed('covis', 'synth', 'desk', '--out', 'desk', '--frames', '10', '--width', '320', '--height', '240', '--fps', '10')
        installed('covis', 'run', 'desk', '--out', 'out', '--save-map', 'desk.m', '--quiet')
        self.assertRegex(installed('covis', 'map', 'info', 'desk.m'), r'vocabulary +[0-9a-f]{16}')
        # The command knows the source folder's vocabulary too, which a machine with the packages alone has not.
        self.assertIn('./usr/share/covis/default.covis-voc', run('dpkg-deb', '--contents', PACKAGES['covis-data']))
        command, vocabulary = WORK / 'other/bin/covis', WORK / 'other/share/covis/default.covis-voc'
        for file in (command, vocabulary):
            file.parent.mkdir(parents=True)
        shutil.copy(ROOT / 'usr/bin/covis', command)
        shutil.copytree(ROOT / 'usr/lib/covis', WORK / 'other/lib/covis')
        vocabulary.write_text('no vocabulary')
        done = subprocess.run([command, 'run', WORK / 'desk', '--out', WORK / 'none'], stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f'{command.parent}/../share/covis/default.covis-voc: ', done.stderr)

    def test_the_command_and_python_find_their_plug_ins(self):
        self.assertNotRegex(run('readelf', '--dynamic', ROOT / 'usr/bin/covis'), 'opencv_(videoio|imgcodecs)|rosbag')
        inputs.write(WORK)
        for name in ('video.y4m', 'recording.bag'):
            self.assertIn('3, 0 unreadable', installed('covis', 'check', name, '--camera', 'camera.yaml'))
            self.assertIn('(72, 96)', installed('/usr/bin/python3', '-c', 'import covis, sys;'
                                                'print(next(iter(covis.Recording(sys.argv[1], camera_file="camera.yaml"))).image.shape)', name))

    def test_python_finds_the_package_and_its_vocabulary(self):
        text = installed('/usr/bin/python3', '-c', 'import covis; print(covis.__file__); open(covis.default_vocabulary(), "rb")')
        self.assertIn(str(ROOT), text)

    def test_manual_pages_name_the_options(self):
        pages = ROOT / 'usr/share/man/man1'
        self.assertIn('Subcommands', (pages / 'covis.1').read_text())
        run_page = (pages / 'covis-run.1').read_text().replace('\\-', '-')
        self.assertTrue(run_page.startswith('.\\"'))
        self.assertIn('--save-map', run_page)

    def test_bash_completes_subcommands_and_options(self):
        script = ROOT / 'usr/share/bash-completion/completions/covis'

        def completed(*words):
            line = f'source {script}; COMP_WORDS=({" ".join(words[:-1])} "{words[-1]}"); COMP_CWORD={len(words) - 1}; _covis; echo "${{COMPREPLY[@]}}"'
            return installed('bash', '-c', line).split()
        self.assertEqual(completed('covis', 'ru'), ['run'])
        self.assertEqual(completed('covis', 'map', 'exp'), ['export'])
        self.assertEqual(completed('covis', 'run', '--save-m'), ['--save-map'])
        self.assertEqual(completed('covis', 'map', 'export', 'file.m', '--head'), ['--heading'])
        self.assertEqual(completed('covis', 'run', 'folder'), [], 'files are left to bash')


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
