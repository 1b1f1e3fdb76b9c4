#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of fleet/: manifests and plans, and whole sites by a covis that only pretends; with Snakemake if --workflow is given.

A pretended recording is a folder with files `world` and `sensor`; a pretended map lists its submaps as [world, key frames],
and merging joins those of one world.
"""
from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

sys.dont_write_bytecode = True
FLEET = pathlib.Path(__file__).resolve().parents[2] / 'fleet'
sys.path.insert(0, str(FLEET))
import fleet  # noqa: E402
import jobs  # noqa: E402
import plan  # noqa: E402
import report  # noqa: E402


class Pretender:
    """Stands in for Job.call."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def __call__(self, job: jobs.Job, *words: str) -> jobs.Json:
        self.calls.append(' '.join(words[:2] if words[0] == 'map' else words[:1]))
        match words:
            case ['run', path, '--out', out, '--save-map', file, *_]:
                recording = pathlib.Path(path)
                if not (recording / 'world').exists():
                    raise jobs.JobError(f'{path}: it has 0 frames')
                pathlib.Path(out).mkdir()
                (pathlib.Path(out) / 'summary.json').write_text(json.dumps(
                    {'frames': 10, 'frames_tracked': 9, 'sensor': 'x', 'truth_path_m': 8, 'maps': [{'keyframes': 5}]}))
                pathlib.Path(file).write_text(json.dumps(
                    {'sensor': (recording / 'sensor').read_text(), 'maps': [[(recording / 'world').read_text(), 5]]}))
                return {}
            case ['map', 'info', file, '--json']:
                return {'sensor': json.loads(pathlib.Path(file).read_text())['sensor'], 'camera': {}, 'pyramid': {'factor': 1.2}, 'seconds': 1}
            case ['map', 'merge', one, two, '--out', out, '--json']:
                inputs = [json.loads(pathlib.Path(file).read_text()) for file in (one, two)]
                submaps = inputs[0]['maps'] + inputs[1]['maps']
                if any(world == 'broken' for world, _ in submaps):
                    raise jobs.JobError('the map is broken')
                worlds = list(dict.fromkeys(world for world, _ in submaps))
                made = [[world, sum(k for w, k in submaps if w == world)] for world in worlds]
                pathlib.Path(out).write_text(json.dumps({'sensor': inputs[0]['sensor'], 'maps': made}))
                pairs = [{'maps': [one, two], 'submaps': [i, k], 'joined': a[0] == b[0], 'claims': 3, 'contrary': 0, 'reason': 'other'}
                         for i, a in enumerate(inputs[0]['maps']) for k, b in enumerate(inputs[1]['maps'])]
                return {'maps': made, 'pairs': pairs, 'search_ms': 1, 'join_ms': 1, 'adjust_ms': 1, 'inputs': [
                    {'file': file, 'key_frames': 5, 'maps': [worlds.index(w) for w, _ in i['maps']]}
                    for file, i in zip((one, two), inputs)]}
        raise AssertionError(words)


class FleetTest(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.site = self.folder / 'site'
        self.covis = self.folder / 'covis'
        self.covis.write_text('not run')

    def record(self, name: str, world: str | None = 'north', sensor: str = 'rgbd') -> str:
        path = self.folder / name
        path.mkdir()
        (path / 'name').write_text(name)
        (path / 'sensor').write_text(sensor)
        if world:
            (path / 'world').write_text(world)
        return str(path)

    def plan(self) -> plan.Plan:
        return plan.plan_of(plan.Manifest.load(self.site), plan.identity_of(self.covis))

    def run_site(self, pretender: Pretender) -> jobs.Json:
        """Does all jobs in order, each as its last attempt, and reports."""
        with mock.patch.object(jobs.Job, 'call', lambda job, *words: pretender(job, *words)):
            made = self.plan()
            for key in made.nodes:
                fleet.run_job(self.site, self.covis, key, True)
        return report.publish(self.site, plan.Manifest.load(self.site), made)


class PlanTest(FleetTest):
    def test_a_batch_is_a_balanced_tree(self) -> None:
        plan.add(self.site, [self.record(f'r{i}') for i in range(11)], [])
        made = self.plan()
        self.assertEqual([len(made.of_kind(merges)) for merges in (False, True)], [11, 10])
        depth: dict[str, int] = {}
        for key, node in made.nodes.items():
            depth[key] = 1 + max((depth[k] for k in node.inputs), default=0)
        self.assertEqual(depth[made.root], 5)
        self.assertEqual(made.nodes[made.root].recordings, 11)

    def test_a_later_recording_costs_itself_and_one_merge(self) -> None:
        plan.add(self.site, [self.record(f'r{i}') for i in range(11)], [])
        before = self.plan()
        plan.add(self.site, [self.record('later')], [])
        after = self.plan()
        new = [after.nodes[key] for key in after.nodes.keys() - before.nodes.keys()]
        self.assertEqual(sorted(len(node.inputs) for node in new), [0, 2])
        self.assertEqual(after.nodes[after.root].inputs[0], before.root)

    def test_keys_are_of_content(self) -> None:
        camera = self.folder / 'camera.yaml'
        camera.write_text('fx: 1')
        plan.add(self.site, [self.record('a')], [])
        plan.add(self.site, [self.record('b')], ['--camera', str(camera)])
        before = self.plan()
        (self.folder / 'a').rename(self.folder / 'elsewhere')
        self.assertEqual(self.plan().root, before.root, 'where a recording is does not matter')
        camera.write_text('fx: 2')
        self.assertEqual(len(self.plan().nodes.keys() - before.nodes.keys()), 2, 'its camera does')
        self.covis.write_text('another one')
        self.assertFalse(self.plan().nodes.keys() & before.nodes.keys(), 'and so does the command')

    def test_a_file_behind_an_equals_sign_is_a_file(self) -> None:
        camera = self.folder / 'camera.yaml'
        camera.write_text('fx: 1')
        options = ['--camera=' + os.path.relpath(camera), '--set=a.b=1', '--skip-bad']
        plan.add(self.site, [self.record('a')], options)
        recording = plan.Manifest.load(self.site).recordings()[0]
        self.assertEqual(recording.options, (f'--camera={camera.absolute()}', '--set=a.b=1', '--skip-bad'))
        before = self.plan()
        self.assertEqual(self.plan().root, before.root)
        camera.write_text('fx: 2')
        self.assertNotEqual(self.plan().root, before.root, 'the content counts')

    def test_what_is_added_twice(self) -> None:
        path = self.record('a')
        plan.add(self.site, [path], [])
        self.assertIn('same bytes as a', plan.add(self.site, [path], [])[0])
        (self.folder / 'a' / 'world').write_text('changed')
        with self.assertRaisesRegex(plan.SiteError, 'another recording of the name a'):
            plan.add(self.site, [self.record('b'), path], [])
        self.assertEqual([r.name for r in plan.Manifest.load(self.site).recordings()], ['a'])
        with self.assertRaisesRegex(plan.SiteError, 'nowhere'):
            plan.add(self.site, [str(self.folder / 'nowhere')], [])


class SiteTest(FleetTest):
    def test_two_sites_two_sensors_and_one_bad_recording(self) -> None:
        paths = [self.record(f'{w[0]}{s}{i}', w, s) for i in range(2) for w in ('north', 'south') for s in ('rgbd', 'mono')]
        plan.add(self.site, [*paths, self.record('empty', None)], [])
        pretender = Pretender()
        data = self.run_site(pretender)
        self.assertEqual([(p['file'], p['sensor'], p['recordings'], p['key_frames']) for p in data['places']], [
            ('site.m', 'mono, rgbd', ['nmono0', 'nmono1', 'nrgbd0', 'nrgbd1'], 20),
            ('site.m', 'mono, rgbd', ['smono0', 'smono1', 'srgbd0', 'srgbd1'], 20)])
        self.assertEqual([p['path_m'] for p in data['places']], [32, 32])  # four recordings, 8 m each
        self.assertEqual(report.of_the_path(data['places'][0]), '')  # they have no truth
        self.assertEqual(report.of_the_path(data['places'][0] | {'ate_m': 0.016}), '0.050 %')
        bad = data['recordings'][-1]
        self.assertEqual((bad['name'], bad['failed'][-8:], bad['joined']), ('empty', '0 frames', False))
        self.assertTrue((self.site / 'report/site.m').exists())
        self.assertIn('0 frames', (self.site / 'report/report.html').read_text())

        done = len(pretender.calls)
        self.run_site(pretender)
        self.assertEqual(len(pretender.calls), done, 'what is done is not done again')
        plan.add(self.site, [self.record('later', 'north')], [])
        self.run_site(pretender)
        self.assertEqual(pretender.calls[done:], ['run', 'map info', 'map merge'])

    def test_why_a_recording_is_by_itself(self) -> None:
        plan.add(self.site, [self.record('a'), self.record('b'), self.record('c', 'elsewhere')], [])
        recordings = self.run_site(Pretender())['recordings']
        self.assertEqual([r['joined'] for r in recordings], [True, True, False])
        self.assertEqual(recordings[2]['apart'], ['a, b and c: other'])

    def test_maps_that_cannot_be_merged_stay_side_by_side(self) -> None:
        plan.add(self.site, [self.record('a'), self.record('b', 'broken')], [])
        data = self.run_site(Pretender())
        self.assertEqual([p['recordings'] for p in data['places']], [['a'], ['b']])
        self.assertIn('merging a with b: the map is broken', data['merges'][0]['failed'])

    def test_failed_jobs_are_tried_again_when_asked(self) -> None:
        plan.add(self.site, [self.record('a'), self.record('b', None)], [])
        self.run_site(Pretender())
        self.assertEqual(len(fleet.retry(self.site)), 2, 'the recording and the merge that did without it')
        self.assertEqual(len(list((self.site / 'jobs').iterdir())), 1)

    def test_a_failure_before_the_last_attempt_leaves_nothing(self) -> None:
        plan.add(self.site, [self.record('a', None)], [])
        with mock.patch.object(jobs.Job, 'call', lambda job, *words: Pretender()(job, *words)):
            with self.assertRaisesRegex(jobs.JobError, '0 frames'):
                fleet.run_job(self.site, self.covis, self.plan().root, False)
        self.assertEqual(list((self.site / 'jobs').iterdir()), [])

    def test_two_that_do_the_same_job_at_once(self) -> None:
        job = jobs.Job(self.site, self.covis, 'k')

        def slow(slower: jobs.Job) -> jobs.Json:
            other = jobs.Job(self.site, self.covis, 'k')
            other.folder = other.folder.with_name(other.folder.name + '-other')
            other.make(lambda _: {'by': 'the other'}, True)
            return {'by': 'this'}

        self.assertEqual(job.make(slow, True)['by'], 'the other')
        self.assertEqual([p.name for p in (self.site / 'jobs').iterdir()], ['k'])

    def test_what_covis_says_when_it_fails(self) -> None:
        for script, message in (('echo "error: no such thing" >&2; exit 1', '^no such thing$'), ('kill -9 $$', 'signal 9')):
            self.covis.write_text(f'#!/bin/sh\n{script}\n')
            self.covis.chmod(0o755)
            job = jobs.Job(self.site, self.covis, 'k')
            job.folder.mkdir(parents=True, exist_ok=True)
            with self.assertRaisesRegex(jobs.JobError, message):
                job.call('run', 'x')


class WorkflowTest(FleetTest):
    def test_snakemake_sees_the_jobs_of_the_plan(self) -> None:
        plan.add(self.site, [self.record(f'r{i}') for i in range(3)], [])
        done = subprocess.run(['snakemake', '-s', FLEET / 'Snakefile', '--directory', self.site, '--profile', FLEET / 'profiles/local',
                               '--config', f'covis={self.covis}', '--dry-run', '--quiet'], capture_output=True, text=True,
                              env=os.environ | {'HOME': str(self.folder)}, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout + done.stderr, r'map +3\b[^$]*merge +2\b[^$]*site +1\b')


if __name__ == '__main__':
    if '--workflow' in sys.argv:
        if not shutil.which('snakemake'):
            sys.exit(77)
        unittest.main(argv=sys.argv[:1], defaultTest='WorkflowTest')
    unittest.main(defaultTest=['PlanTest', 'SiteTest'])
