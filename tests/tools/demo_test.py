#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The script ./demo, with a build and a command that pretend: what it runs, and what it says of wrong options."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

DEMO = pathlib.Path(__file__).resolve().parents[2] / 'demo'
COVIS = '''#!/bin/bash
echo "$*" >> calls
case $1 in
  synth) mkdir -p "${@: -1}" ;;
  run) for file in report.html trajectory.png map.ply; do echo x > "$6/$file"; done ;;
  view) exit 7 ;;
esac
'''


class DemoTest(unittest.TestCase):
    def demo(self, *options):
        """Exit code, output, and the calls of covis, with the folder of results as OUT."""
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder).resolve()
            shutil.copy(DEMO, folder)
            for name, text in (('tools/setup', '#!/bin/bash\n'), ('bin/cmake', '#!/bin/bash\n'), ('build/demo/apps/covis', COVIS)):
                file = folder / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
                file.chmod(0o755)
            done = subprocess.run([folder / 'demo', *options], env={'PATH': f'{folder}/bin:/usr/bin:/bin'}, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True)
            calls = (folder / 'calls').read_text().replace(f'{folder}/demo-out/room-rgbd', 'OUT').splitlines() if (folder / 'calls').exists() else []
            return done.returncode, done.stdout, calls

    def test_it_renders_runs_and_compares(self):
        code, said, calls = self.demo()
        self.assertEqual(code, 0, said)
        self.assertEqual(calls, ['synth room --sensor rgbd --seed 1 --frames 600 --out OUT/recording', 'run OUT/recording --sensor rgbd --out OUT',
                                 'eval OUT/trajectory.txt OUT/recording/groundtruth.txt --align se3'])
        self.assertIn('report.html', said)

    def test_with_view_the_run_is_shown_and_then_its_result(self):
        code, said, calls = self.demo('--view', '--frames', '20')
        self.assertEqual(calls[1:2] + calls[3:], ['run OUT/recording --sensor rgbd --out OUT --view --view-close', 'view OUT'], said)
        self.assertEqual(code, 7, 'the end of covis view is that of the demo')

    def test_wrong_options_are_named(self):
        for options, message in ((['--vew'], 'unknown option: --vew'), (['--world'], '--world needs a value')):
            code, said, calls = self.demo(*options)
            self.assertEqual((code, calls), (2, []))
            self.assertIn(message, said)


if __name__ == '__main__':
    unittest.main()
