#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The fleet's workflow on a cluster of four nodes on this machine, against the same on the machine alone.

  tests/fleet/cluster_test.py COVIS WORK [--sensors rgbd,stereo,mono]

Twelve rendered recordings of two rooms: eleven are mapped first, of which a copy broke off, beside one without any image.
A node is killed while its job runs. The twelfth is added afterwards. Fails unless every recording is in the right place,
none was joined wrongly, both site maps have the same bytes, each place's error is below 0.1 % of the path of its recordings
(one camera: 0.3 %), and the twelfth cost its own map and one merge.

Wants Debian's snakemake, slurm-wlm and munge (exit code 77 without), and some minutes. Everything is written below WORK.
"""
from __future__ import annotations

import argparse
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
FLEET = HERE.parent.parent / 'fleet'
sys.path.insert(0, str(HERE))
import recordings  # noqa: E402
from cluster import Cluster  # noqa: E402

CUT_OFF, EMPTY, LATER = 2, 'empty', 11  # of the recordings' numbers, and a name
failures: list[str] = []


def check(right: bool, what: str) -> None:
    print(f'{"right" if right else "WRONG"}: {what}', flush=True)
    if not right:
        failures.append(what)


class Site:
    """A site's folder and how it is mapped."""

    def __init__(self, folder: pathlib.Path, covis: pathlib.Path, profile: str, environment: dict[str, str]) -> None:
        self.folder, self.covis, self.profile, self.environment = folder, covis, profile, environment

    def add(self, *paths: pathlib.Path) -> None:
        subprocess.run([FLEET / 'fleet.py', 'add', self.folder, *paths], check=True, stdout=subprocess.DEVNULL)
        manifest = self.folder / 'manifest.json'
        manifest.write_text(manifest.read_text().replace('"one_truth_frame": false', '"one_truth_frame": true'))

    def start(self) -> subprocess.Popen[bytes]:
        with open(self.folder / 'log.txt', 'ab') as log:
            return subprocess.Popen(['snakemake', '-s', FLEET / 'Snakefile', '--directory', self.folder, '--profile',
                                     FLEET / 'profiles' / self.profile, '--config', f'covis={self.covis}'],
                                    stdout=log, stderr=log, env=self.environment)

    def run(self) -> float:
        begin = time.monotonic()
        self.ended(self.start())
        return time.monotonic() - begin

    def ended(self, process: subprocess.Popen[bytes]) -> None:
        check(process.wait() == 0, f'{self.profile}: the workflow ends well')

    def report(self) -> dict:
        return json.loads((self.folder / 'report/report.json').read_text())

    def maps(self) -> dict[str, str]:
        return {file.name: hashlib.sha256(file.read_bytes()).hexdigest()[:16] for file in sorted((self.folder / 'report').glob('*.m'))}

    def done(self) -> dict[str, int]:
        """Jobs that are done, and when."""
        return {p.parent.name: p.stat().st_mtime_ns for p in self.folder.glob('jobs/*/result.json') if '.' not in p.parent.name}


def check_places(report: dict, truth: dict[str, str]) -> None:
    """Each recording is in one place, with all others of its room and camera and nothing else."""
    right, wrong_joins = 0, 0
    for name, group in truth.items():
        places = [set(place['recordings']) for place in report['places'] if name in place['recordings']]
        want = {other for other in truth if truth[other] == group}
        wrong_joins += sum(len(place - want) for place in places)
        right += any(place == want for place in places)
        if not any(place == want for place in places):
            print(f'  {name}: {[sorted(place) for place in places]}')
    check(right == len(truth), f'{right} of {len(truth)} recordings in the right place')
    check(wrong_joins == 0, f'{wrong_joins} wrong joins')
    for place in report['places']:
        print(f'  {place["file"]} {place["submap"]}: {", ".join(place["recordings"])}; {place["key_frames"]} key frames, '
              f'ATE {place["ate_m"]} m over {place["with_truth"]}, path {place["path_m"]} m')
        bar = 0.003 if place['sensor'] == 'mono' else 0.001
        if place['ate_m'] is None:
            check(False, f'{place["file"]} {place["submap"]}: its key frames have a truth')
            continue
        check(place['ate_m'] < bar * place['path_m'],
              f'{place["file"]} {place["submap"]}: ATE {100 * place["ate_m"] / place["path_m"]:.3f} % of the path, below {100 * bar:g} %')


def kill_a_node(cluster: Cluster, site: Site, workflow: subprocess.Popen[bytes]) -> str:
    """Kills the node of a job that is at work on a recording; the job."""
    while workflow.poll() is None:
        for _, name, node in cluster.jobs():
            if name.startswith('map-') and any((site.folder / 'jobs').glob(f'{name[4:]}.unfinished-*')):
                time.sleep(0.5)  # within the three seconds that covis works on it
                if name[4:] not in site.done():
                    cluster.kill_node(node)
                    print(f'killed {node} while it did {name}', flush=True)
                    return name[4:]
        time.sleep(0.1)
    raise RuntimeError('the workflow ended before a node could be killed')


def costs(report: dict) -> str:
    total = report['total']
    return (f'{total["cpu_s"]:.1f} CPU s for {total["video_s"]:.0f} s of video, longest chain {total["longest_chain_s"]:.1f} s, '
            f'{total["memory_mb"]:.0f} MB at most, {total["bytes_in"] / 1e6:.1f} MB read, {total["bytes_out"] / 1e6:.1f} MB written')


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('covis', type=pathlib.Path)
    parser.add_argument('work', type=pathlib.Path)
    parser.add_argument('--sensors', default='rgbd,stereo,mono', help='in turns; default: all three')
    a = parser.parse_args()
    if not all(shutil.which(name) for name in ('snakemake', 'sbatch')) or not os.path.exists('/usr/sbin/slurmctld'):
        print('skipped: snakemake or Slurm is not installed')
        return 77
    covis, work = a.covis.resolve(), a.work.resolve()
    for name in ('local', 'slurm', 'cluster'):
        shutil.rmtree(work / name, ignore_errors=True)

    made = recordings.make(covis, work, a.sensors.split(','))
    truth = dict(made)
    paths = [work / 'recordings' / name for name, _ in made]
    recordings.cut_off(paths[CUT_OFF], 45)
    empty = work / 'recordings' / EMPTY
    recordings.piece(work / 'walks' / made[0][0], 0, 20, empty)
    for image in empty.glob('*/*.png'):
        image.unlink()
    first = [*paths[:LATER], empty]

    local = Site(work / 'local', covis, 'local', dict(os.environ))
    local.add(*first)
    print(f'local: {local.run():.0f} s')
    print('local: ' + costs(local.report()))

    cluster = Cluster(work / 'cluster')
    cluster.start()
    try:
        slurm = Site(work / 'slurm', covis, 'slurm', cluster.environment)
        slurm.add(*first)
        begin = time.monotonic()
        workflow = slurm.start()
        killed = kill_a_node(cluster, slurm, workflow)
        slurm.ended(workflow)
        print(f'slurm: {time.monotonic() - begin:.0f} s, a node lost meanwhile: {cluster.states()}')
        print('slurm: ' + costs(slurm.report()))
        check(killed in slurm.done(), 'the job of the killed node was done by another')
        report = slurm.report()
        bad = [r['name'] for r in report['recordings'] if r['failed']]
        check(bad == [EMPTY], f'of the recordings that are bad, {bad} is reported as not mapped: '
              f'{[r["failed"] for r in report["recordings"] if r["failed"]]}')
        cut = next(r for r in report['recordings'] if r['name'] == made[CUT_OFF][0])
        check(bool(cut['warnings']), f'the recording that was cut off is mapped as far as it reaches, and says so: {cut["warnings"]}')
        check_places(report, dict(made[:LATER]))
        check(slurm.maps() == local.maps(), f'the same bytes locally and on Slurm: {slurm.maps()}, {local.maps()}')

        before = slurm.done()
        again = slurm.run()
        check(slurm.done() == before, f'what is done is not done again ({again:.0f} s)')

        for site in (local, slurm):
            before = site.done()
            site.add(paths[LATER])
            took = site.run()
            new = set(site.done()) - set(before)
            check(all(site.done()[key] == at for key, at in before.items()), f'{site.profile}: nothing was done again')
            jobs = {key: json.loads((site.folder / 'jobs' / key / 'result.json').read_text()) for key in new}
            kinds = sorted('errors' if '-' in key else 'merge' if 'inputs' in job else 'map' for key, job in jobs.items())
            check(kinds == ['errors', 'map', 'merge'], f'{site.profile}: adding one is one map and one merge: {kinds}')
            print(f'{site.profile}: adding one took {took:.0f} s: ' + ', '.join(
                f'{job["cost"]["wall_s"]} s' + (' (errors)' if '-' in key else '') for key, job in sorted(jobs.items())))
        check_places(slurm.report(), truth)
        check(slurm.maps() == local.maps(), f'the same bytes locally and on Slurm: {slurm.maps()}, {local.maps()}')
        print('all: ' + costs(slurm.report()))
    finally:
        cluster.stop()
    print(f'{len(failures)} failures')
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
