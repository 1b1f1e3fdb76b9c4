#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of bench/suite and bench/recordings.py: what is found in folders, and whole suites of a command that only pretends."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
BENCH = pathlib.Path(__file__).resolve().parents[2] / 'bench'
sys.path.insert(0, str(BENCH))
import recordings  # noqa: E402

# Tracks all frames but those that --set lost=K loses, in real time one of them late; refuses mono; with --set slow=1 hangs from any start but 0;
# appends its arguments to a file beside itself.
PRETENDER = '''#!{python}
import json, pathlib, sys, time
if '--version' in sys.argv:
    sys.exit(print('pretender 1'))
with open(__file__ + '.calls', 'a') as calls:
    calls.write(' '.join(sys.argv[2:]) + chr(10))
value = lambda name, default: sys.argv[sys.argv.index(name) + 1] if name in sys.argv else default
if value('--sensor', '') == 'mono':
    sys.exit('no mono today')
lost = sum(int(a[len('--set=lost='):]) for a in sys.argv if a.startswith('--set=lost='))
out, first, stride = pathlib.Path(value('--out', '')), int(value('--first', 0)), int(value('--stride', 1))
if '--set=slow=1' in sys.argv and first > 0:
    time.sleep(600)
frames, poses = [], ''
for k in range(first, 40, stride):
    state = 'late' if k == first and '--realtime' in sys.argv else 'lost' if k < first + lost else 'tracking'
    frames.append(dict(frame=k, stamp=k / 10, state=state))
    if state == 'tracking':
        frames[-1].update(map=0, tentative=False)
        poses += f'{{k / 10:.9f}} {{k % 7 + (9 if k == 30 else 0)}} {{k}} 0 0 0 0 1\\n'
(out / 'map.ply').write_text('points')
(out / 'trajectory.txt').write_text(poses)
(out / 'trajectory_online.txt').write_text(poses)
(out / 'stats.jsonl').write_text(''.join(json.dumps(frame) + '\\n' for frame in frames))
(out / 'summary.json').write_text(json.dumps(dict(maps=[0], loops=[], merges=[], wall_s=1, tracking_ms=dict(median=2, p95=3), peak_rss_mb=9)))
'''


def make_tum(folder, count=40):
    (folder / 'rgb').mkdir(parents=True)
    (folder / 'rgb.txt').write_text(''.join(f'{k / 10:.6f} rgb/{k}.png\n' for k in range(count)))
    (folder / 'depth.txt').write_text('# none\n')
    (folder / 'groundtruth.txt').write_text(''.join(f'{k / 10:.6f} {k % 7} {k} 0 0 0 0 1\n' for k in range(count)))


def make_kitti(folder):
    for name in ('image_0', 'image_1'):
        (folder / name).mkdir(parents=True)
        (folder / name / '000000.png').write_bytes(b'\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x04\xd9\0\0\1\x78')
    (folder / 'times.txt').write_text('0.0\n0.1\n')
    (folder / 'poses.txt').write_text('1 0 0 5 0 1 0 6 0 0 1 7\n1 0 0 8 0 1 0 9 0 0 1 1\n')


def make_photo_world(folder, baseline):
    for name in ('left', 'right', 'depth'):
        (folder / name).mkdir(parents=True)
    (folder / 'left' / '000000.png').write_bytes(b'')
    (folder / 'camera.txt').write_text(f'fx 525\nfy 525\ncx 319.5\ncy 239.5\nwidth 640\nheight 480\nbaseline_m {baseline}\ndepth_scale 5000\nfps 30\n')
    (folder / 'groundtruth.txt').write_text('1000.0 1 2 3 0 0 0 1\n1000.1 1 2 4 0 0 0 1\n')
    for name in ('times.txt', 'calib.txt', 'rgb.txt', 'depth.txt'):
        (folder / name).write_text('')


class InFolder(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name).resolve()


class RecordingsTest(InFolder):
    def test_all_kinds_are_found(self):
        make_tum(self.folder / 'all' / 'a_tum')
        make_kitti(self.folder / 'all' / 'more' / 'b_kitti')
        make_photo_world(self.folder / 'all' / 'c_room', 0.08)
        make_photo_world(self.folder / 'all' / 'd_street', 0.54)
        (self.folder / 'all' / 'e_euroc' / 'mav0' / 'cam0').mkdir(parents=True)
        found = recordings.find_recordings(self.folder)
        self.assertEqual([(r.name, r.kind, r.sensors()) for r in found],
                         [('a_tum', 'TUM', ['rgbd', 'mono']), ('c_room', 'photo world', ['stereo', 'rgbd', 'mono']),
                          ('d_street', 'photo world', ['stereo', 'mono']), ('e_euroc', 'EuRoC', ['mono']), ('b_kitti', 'KITTI', ['stereo', 'mono'])])

    def test_kitti(self):
        make_kitti(self.folder / 'k')
        recording = recordings.open_recording(self.folder / 'k')
        self.assertEqual(recording.truth('mono'), [(0.0, (5.0, 6.0, 7.0)), (0.1, (8.0, 9.0, 1.0))])
        self.assertEqual(recording.arguments('mono', None)[-1], '--set=orb.features=2000')

    def test_photo_worlds_are_laid_out(self):
        make_photo_world(self.folder / 'w', 0.08)
        recording = recordings.open_recording(self.folder / 'w')
        stereo, rgbd = (recording.source(sensor, self.folder) for sensor in ('stereo', 'rgbd'))
        self.assertEqual(recording.source('mono', self.folder), stereo)
        self.assertEqual((stereo / 'image_0').resolve(), self.folder / 'w' / 'left')
        self.assertEqual((stereo / 'groundtruth_tum.txt').read_text().split('\n')[1], '0.100000 1 2 4 0 0 0 1')
        self.assertEqual(recording.truth('mono')[0], (0.0, (1.0, 2.0, 3.0)))
        self.assertIn('depth_scale: 5000\n', (rgbd / 'camera.yaml').read_text())
        self.assertEqual(recording.truth('rgbd')[0], (1000.0, (1.0, 2.0, 3.0)))

    def test_the_body_of_euroc_is_not_its_camera(self):
        base = self.folder / 'e' / 'mav0'
        (base / 'cam0').mkdir(parents=True)
        (base / 'state_groundtruth_estimate0').mkdir()
        (base / 'cam0' / 'sensor.yaml').write_text('T_BS:\n  data: [1, 0, 0, 0.5,\n 0, 1, 0, 0,\n 0, 0, 1, 0, 0, 0, 0, 1]\n')
        (base / 'state_groundtruth_estimate0' / 'data.csv').write_text('#t\n2000000000,1,1,1,0.5,0.5,0.5,0.5,0\n')  # x turned to y
        (stamp, position), = recordings.open_recording(self.folder / 'e').truth('mono')
        self.assertEqual(stamp, 2)
        for found, wanted in zip(position, (1, 1.5, 1)):
            self.assertAlmostEqual(found, wanted)

    def test_cameras(self):
        for name in ('rgbd_7scenes_x', 'own', 'given'):
            make_tum(self.folder / name)
        (self.folder / 'own' / 'camera.yaml').write_text('')
        found = recordings.find_recordings(self.folder)
        recordings.choose_cameras(found, {'given': str(self.folder / 'own' / 'camera.yaml')})
        self.assertEqual([r.camera and r.camera.name for r in found], ['camera.yaml', None, '7scenes.yaml'])
        before = found[0].fingerprint()
        (self.folder / 'own' / 'camera.yaml').write_text('fx: 1')
        self.assertNotEqual(found[0].fingerprint(), before)


class SuiteTest(InFolder):
    def setUp(self):
        super().setUp()
        make_tum(self.folder / 'rec')
        self.covis = self.folder / 'build/apps/covis'
        self.covis.parent.mkdir(parents=True)
        self.covis.write_text(PRETENDER.format(python=sys.executable))
        self.covis.chmod(0o755)

    def command(self, *options):
        return [sys.executable, BENCH / 'suite', self.folder / 'rec', '--covis', self.covis, '--work', self.folder / 'work',
                '--json', self.folder / 'out.json', '--only', 'rgbd', *options]

    def suite(self, *options):
        done = subprocess.run(self.command(*options), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        return done, json.loads((self.folder / 'out.json').read_text()) if (self.folder / 'out.json').exists() else None

    def calls(self):
        return pathlib.Path(f'{self.covis}.calls').read_text().splitlines()

    def test_one_version(self):
        done, found = self.suite('--markdown')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([row['frames'] for row in found['rows']], ['all', 'every 2nd'])
        every, second = (row['versions'][0] for row in found['rows'])
        self.assertEqual((every['runs'], second['runs'], every['tracked'], every['wrong']), (3, 2, 1, 3))  # starts 0, 4, 8; frame 30
        self.assertEqual(every['starts']['4']['wrong_frames'][0][0], 30)
        self.assertIn('| rec | rgbd | every 2nd | 2 | 100 |', done.stdout)
        self.assertFalse(list(self.folder.rglob('map.ply')), 'what nobody needs again is not kept')

    def test_what_was_run_is_not_run_again(self):
        self.suite()
        self.assertEqual(len(self.calls()), 5)
        done, _ = self.suite()
        self.assertEqual(len(self.calls()), 5)
        self.assertIn('(kept)', done.stderr)
        self.suite('--set', 'a=1,b=2', '--starts', '0', '--strides', '1')
        self.assertIn('--set=a=1 --set=b=2', self.calls()[-1])
        self.assertEqual(len(self.calls()), 6)
        self.suite('--realtime', '--strides', '1')
        self.suite('--realtime', '--strides', '1', '--starts', '0')
        self.assertEqual(len(self.calls()), 9, 'real time is another run each time')
        self.suite('--fresh', '--starts', '0', '--strides', '1')
        self.assertEqual(len(self.calls()), 10)

    def test_other_plug_ins_are_another_version(self):
        options = ('--starts', '0', '--strides', '1')
        self.suite(*options)
        sums = [self.suite(*options)[1]['versions'][0]['sha256']]
        self.assertEqual(len(self.calls()), 1)
        for place in ('.', '../lib/covis', '../lib/x86_64-linux-gnu/covis'):
            plug_in = self.covis.parent / place / 'covis_codecs.so'
            plug_in.parent.mkdir(parents=True, exist_ok=True)
            plug_in.write_bytes(place.encode())
            sums.append(self.suite(*options)[1]['versions'][0]['sha256'])
        self.assertEqual(len(self.calls()), 4)
        self.assertEqual(len(set(sums)), 4)

    def test_two_settings(self):
        done, found = self.suite('--set', 'lost=2', '--against-set', '', '--strides', '1')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('rows that track less than the second: 1', done.stdout)
        self.assertIn('median ATE ratio over 1 rows: 1.', done.stdout)
        first, second = found['rows'][0]['versions']
        self.assertLess(first['tracked'], second['tracked'])

    def test_real_time_has_a_row_of_its_own(self):
        _, found = self.suite('--realtime', '--strides', '', '--starts', '0')
        row, = found['rows']
        self.assertEqual((row['frames'], row['versions'][0]['late'], row['versions'][0]['tracked']), ('real time', 1, 39 / 40))

    def test_failures_are_told(self):
        done, found = self.suite('--only', 'mono', '--strides', '1', '--starts', '0')
        self.assertEqual(done.returncode, 1)
        self.assertIn('FAILED (first) rec mono all, start 0: exit code 1: no mono today', done.stdout)
        self.assertEqual(found['rows'][0]['versions'][0]['failed'], 1)

    def interrupted(self, interrupt):
        with subprocess.Popen(self.command('--set', 'slow=1'), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              start_new_session=True) as suite:
            self.assertIn('rec rgbd all, start 0: 100 % tracked', suite.stderr.readline())
            interrupt(suite)
            said, _ = suite.communicate(timeout=60)
        self.assertEqual(suite.returncode, 130)
        self.assertRegex(said, r'rec +rgbd +all +1 +100')
        self.assertNotIn('FAILED', said)

    def test_interrupted(self):
        self.interrupted(lambda suite: suite.terminate())

    def test_interrupted_from_the_keyboard(self):
        self.interrupted(lambda suite: os.killpg(suite.pid, signal.SIGINT))  # the runs are interrupted as well

    def test_bad_arguments(self):
        for options in (['--jobs', '0'], ['--starts', ''], ['--camera', 'x'], ['--against', 'nowhere'], ['--only', '(']):
            self.assertEqual(self.suite(*options)[0].returncode, 2, options)
        self.assertIn('there is nothing to run', self.suite('--only', 'nothing')[0].stderr)


if __name__ == '__main__':
    unittest.main()
