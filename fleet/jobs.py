# SPDX-License-Identifier: Apache-2.0
"""The jobs of a site: map a recording, merge two nodes of the tree, measure the site's map.

What a job makes is a folder, jobs/KEY, that appears whole or not at all; its record is result.json. A job whose folder is
there is done. Two that make the same at once (one of them on a node that was believed dead) do no harm: the first one's
folder stays.
"""
from __future__ import annotations

import json
import os
import pathlib
import resource
import shutil
import subprocess
import time
from typing import Any, Callable

from plan import Node, Recording, hash_of, write_whole

Json = dict[str, Any]
UNFINISHED = '.unfinished-'


class JobError(Exception):
    """Covis did not do it; the message is its own."""


class Job:
    """One run of a job, with the covis it uses and what that cost."""

    def __init__(self, site: pathlib.Path, covis: pathlib.Path, key: str) -> None:
        self.covis = str(covis)
        self.jobs = site / 'jobs'
        self.key = key
        self.folder = self.jobs / f'{key}{UNFINISHED}{os.uname().nodename}-{os.getpid()}'
        self.warnings: list[str] = []

    def make(self, work: Callable[[Job], Json], last_attempt: bool) -> Json:
        """Does the work, unless it is done. What fails on the last attempt is recorded as failed, so that others go on."""
        done = self.jobs / self.key
        if not (done / 'result.json').exists():
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir(parents=True)
            begin = time.monotonic()
            try:
                result = work(self)
            except JobError as error:
                if not last_attempt:
                    shutil.rmtree(self.folder, ignore_errors=True)
                    raise
                result = {'failed': str(error), 'maps': []}
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            result['cost'] = {
                'wall_s': round(time.monotonic() - begin, 3), 'cpu_s': round(used.ru_utime + used.ru_stime, 3),
                'memory_mb': round(used.ru_maxrss / 1024, 1), 'node': os.environ.get('SLURMD_NODENAME', os.uname().nodename),
                'bytes_out': sum(p.stat().st_size for p in self.folder.rglob('*') if p.is_file() and p.stat().st_nlink == 1)}
            write_whole(self.folder / 'result.json', json.dumps(result, indent=1) + '\n')
            try:
                self.folder.rename(done)
            except OSError:
                shutil.rmtree(self.folder)  # another one was first
        return load_result(done.parent.parent, self.key)

    def call(self, *words: str) -> Json:
        """Runs covis; its JSON, or {} where it prints none. All it says is kept in log.txt."""
        command = [self.covis, *words]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors='replace', check=False)
        with open(self.folder / 'log.txt', 'a', encoding='utf-8') as log:
            log.write('$ ' + ' '.join(command) + '\n' + done.stderr)
        self.warnings += [line.removeprefix('warning: ') for line in done.stderr.splitlines() if line.startswith('warning: ')]
        if done.returncode != 0:
            if done.returncode < 0:
                raise JobError(f'covis {words[0]} was ended by signal {-done.returncode}')
            errors = [line.removeprefix('error: ') for line in done.stderr.splitlines() if line.startswith('error: ')]
            raise JobError(' '.join(errors) or f'covis {words[0]} ended with code {done.returncode}; see log.txt')
        return json.loads(done.stdout) if '--json' in words else {}


def load_result(site: pathlib.Path, key: str) -> Json:
    return json.loads((site / 'jobs' / key / 'result.json').read_text())


def map_recording(job: Job, recording: Recording, options: list[str]) -> Json:
    """Maps a recording by itself. Its map is of one kind, that of its features."""
    out, file = job.folder / 'run', job.folder / 'map.m'
    job.call('run', recording.path, '--out', str(out), '--save-map', str(file), '--quiet', *options, *recording.options)
    summary = json.loads((out / 'summary.json').read_text())
    result: Json = {'recording': recording.name, 'maps': [], 'bytes_in': recording.bytes, 'warnings': job.warnings,
                    'frames': summary['frames'], 'frames_tracked': summary['frames_tracked'],
                    'ate_m': summary.get('ate_m'), 'path_m': summary.get('truth_path_m'), 'sensor': summary['sensor']}
    if not file.exists():
        return result | {'failed': 'nothing of it was mapped'}
    info = job.call('map', 'info', str(file), '--json')
    kind = hash_of(info['pyramid']['factor'])[:8]
    submaps = [{recording.name: m['keyframes']} for m in summary['maps']]
    result['seconds'] = info['seconds']
    result['maps'] = [{'file': file.name, 'kind': kind, 'sensors': {recording.name: info['sensor']}, 'submaps': submaps}]
    return result


def merge_nodes(job: Job, site: pathlib.Path, node: Node, options: list[str]) -> Json:
    """Merges the maps of two nodes, those of one kind with each other: a node has a map for each kind of features."""
    maps: list[Json] = []
    result: Json = {'inputs': list(node.inputs), 'maps': maps, 'bytes_in': 0, 'merges': []}
    for key in node.inputs:
        for other in load_result(site, key)['maps']:
            source = site / 'jobs' / key / other['file']
            same = next((m for m in maps if m['kind'] == other['kind']), None)
            target = job.folder / f'map-{len(maps)}.m'
            if same is None:
                os.link(source, target)
                maps.append(other | {'file': target.name})
                continue
            merged = job.folder / 'merged.m'
            before = job.folder / same['file']
            result['bytes_in'] += before.stat().st_size + source.stat().st_size
            try:
                report = job.call('map', 'merge', str(before), str(source), '--out', str(merged), '--json', *options)
            except JobError as error:
                raise JobError(f'merging {members(same)} with {members(other)}: {error}') from error
            merged.replace(before)
            result['merges'].append(summary_of(report, same, other))
            same['submaps'] = submaps_after(report, [same, other])
            same['sensors'] |= other['sensors']
    return result


def keep_apart(job: Job, site: pathlib.Path, node: Node, why: str) -> Json:
    """The result of a merge that can't be done: the maps of both nodes, side by side."""
    result: Json = {'inputs': list(node.inputs), 'maps': [], 'failed': why}
    for key in node.inputs:
        for other in load_result(site, key)['maps']:
            target = job.folder / f'map-{len(result["maps"])}.m'
            target.unlink(missing_ok=True)
            os.link(site / 'jobs' / key / other['file'], target)
            result['maps'].append(other | {'file': target.name})
    return result


def members(one: Json) -> str:
    return ', '.join(sorted({name for submap in one['submaps'] for name in submap}))


def submaps_after(report: Json, inputs: list[Json]) -> list[dict[str, int]]:
    """The recordings in each submap of a merged map, with their key frames."""
    submaps: list[dict[str, int]] = [{} for _ in report['maps']]
    for moved, came in zip(report['inputs'], inputs):
        for target, submap in zip(moved['maps'], came['submaps']):
            for name, key_frames in submap.items():
                submaps[target][name] = submaps[target].get(name, 0) + key_frames
    return submaps


def summary_of(report: Json, first: Json, second: Json) -> Json:
    """What a merge says about pairs of submaps of its two inputs."""
    files = {report['inputs'][0]['file']: first, report['inputs'][1]['file']: second}
    pairs = []
    for pair in report['pairs']:
        if pair['maps'][0] == pair['maps'][1]:
            continue
        named = [sorted(files[file]['submaps'][i]) for file, i in zip(pair['maps'], pair['submaps'])]
        pairs.append({'recordings': named, 'joined': pair['joined'], 'claims': pair['claims'], 'contrary': pair['contrary'],
                      'reason': ': '.join(filter(None, (pair.get('reason'), pair.get('refusal'))))})
    return {'key_frames': [i['key_frames'] for i in report['inputs']],
            'ms': [round(report[f'{part}_ms']) for part in ('search', 'join', 'adjust')], 'pairs': pairs}


def evaluate(job: Job, site: pathlib.Path, root: str, recordings: list[Recording]) -> Json:
    """Errors of the site's maps: key frames of each submap against the truths of its recordings, which share a world."""
    paths = {recording.name: pathlib.Path(recording.path) for recording in recordings}
    result: Json = {'maps': []}
    for one in load_result(site, root)['maps']:
        poses = job.folder / 'poses.txt'
        job.call('map', 'export', str(site / 'jobs' / root / one['file']), '--to', 'tum', '--out', str(poses))
        # Exports begin with the submap of the most key frames, files of maps with the oldest.
        by_size = sorted(range(len(one['submaps'])), key=lambda i: -sum(one['submaps'][i].values()))
        errors: list[Json | None] = []
        for i, submap in enumerate(one['submaps']):
            rank = by_size.index(i)
            of_submap = poses.with_stem(f'poses_map{rank}') if rank else poses
            if len(of_submap.read_text().splitlines()) != sum(submap.values()):
                raise JobError(f'{of_submap}: {sum(submap.values())} key frames are expected')
            rows: dict[str, str] = {}
            for name in submap:
                truth = paths[name] / 'groundtruth.txt'
                if truth.exists():
                    rows |= {line.split()[0]: line for line in truth.read_text().splitlines() if line[:1].isdigit()}
            if not rows:
                errors.append(None)
                continue
            truths = job.folder / 'truth.txt'
            truths.write_text('\n'.join(rows[stamp] for stamp in sorted(rows, key=float)) + '\n')
            align = 'sim3' if {one['sensors'][name] for name in submap} == {'mono'} else 'se3'
            try:
                errors.append(job.call('eval', str(of_submap), str(truths), '--align', align, '--json'))
            except JobError as error:  # too few poses have a truth
                errors.append({'failed': str(error)})
        result['maps'].append(errors)
    return result
