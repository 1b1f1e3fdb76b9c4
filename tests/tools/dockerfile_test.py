#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Dockerfile: tools/test_dockerfile builds it; here what it names must exist."""
import pathlib
import unittest


class DockerfileTest(unittest.TestCase):
    def test_it_names_what_there_is(self):
        root = pathlib.Path(__file__).resolve().parents[2]
        lines = [line.split() for line in (root / 'Dockerfile').read_text().split('\n') if line and not line.startswith('#')]
        stages, presets = [], (root / 'CMakePresets.json').read_text()
        for word, *rest in lines:
            self.assertIn(word, {'FROM', 'WORKDIR', 'COPY', 'RUN', 'ENTRYPOINT'})
            if word == 'FROM':
                self.assertEqual(rest[0], 'debian:12')
                stages.append(rest[-1])
            elif word == 'COPY' and rest[0].startswith('--from='):
                self.assertIn(rest[0].removeprefix('--from='), stages)
            elif word == 'COPY':
                self.assertTrue((root / rest[0]).exists(), rest)
            elif word == 'RUN' and '/' in rest[0]:
                self.assertTrue((root / rest[0]).is_file(), rest)
                usage = (root / rest[0]).read_text()
                for option in rest[1:]:
                    self.assertIn(f'    {option}) ', usage, rest)
            elif word == 'RUN' and rest[:2] == ['cmake', '--preset']:
                self.assertIn(f'"name": "{rest[2]}"', presets)
        self.assertEqual(len(stages), 2)


if __name__ == '__main__':
    unittest.main()
