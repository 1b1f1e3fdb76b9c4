# SPDX-License-Identifier: Apache-2.0
"""The report of a site: what was mapped, what was joined, errors where there is truth, and what it cost."""
from __future__ import annotations

import html
import json
import pathlib
import shutil
from typing import Any

from jobs import UNFINISHED, Json, load_result
from plan import Manifest, Plan, write_whole


def longest_chain(plan: Plan, results: dict[str, Json]) -> float:
    """Seconds of the jobs that had to wait for one another."""
    until: dict[str, float] = {}
    for key, node in plan.nodes.items():
        until[key] = max((until[k] for k in node.inputs), default=0.0) + results[key]['cost']['wall_s']
    return until[plan.root]


def why_apart(name: str, results: dict[str, Json]) -> list[str]:
    """Reasons why a recording was not joined with others, of the merges that came nearest to it."""
    pairs = [p for r in results.values() for m in r.get('merges', []) for p in m['pairs']
             if not p['joined'] and any(name in side for side in p['recordings'])]
    pairs.sort(key=lambda p: (-p['claims'], p['recordings']))
    return [f'{" and ".join(", ".join(side) for side in p["recordings"])}: {p["reason"]}' for p in pairs[:2]]


def gather(site: pathlib.Path, manifest: Manifest, plan: Plan) -> Json:
    results = {key: load_result(site, key) for key in plan.nodes}
    root = results[plan.root]
    errors_file = site / 'jobs' / f'{plan.root}-errors' / 'result.json'
    errors = json.loads(errors_file.read_text()) if errors_file.exists() else {}
    path_of = {node.recording.name: results[key].get('path_m') for key, node in plan.nodes.items() if node.recording}
    places: list[Json] = []
    for m, one in enumerate(root['maps']):
        for s, submap in enumerate(one['submaps']):
            error = (errors['maps'][m][s] if errors.get('maps') else None) or {}
            sensors = sorted({one['sensors'][name] for name in submap})
            places.append({'file': published(m), 'submap': s, 'sensor': ', '.join(sensors), 'kind': one['kind'],
                           'recordings': sorted(submap), 'key_frames': sum(submap.values()),
                           'ate_m': error.get('ate_m', {}).get('rmse'), 'with_truth': error.get('associated'),
                           'path_m': sum(path_of[name] or 0 for name in submap)})
    recordings: list[Json] = []
    for key, node in plan.nodes.items():
        if node.recording:
            name, result = node.recording.name, results[key]
            own = [i for i, place in enumerate(places) if name in place['recordings']]
            joined = any(len(places[i]['recordings']) > 1 for i in own)
            recordings.append({k: result.get(k) for k in ('frames', 'frames_tracked', 'seconds', 'ate_m', 'warnings', 'failed')} |
                              {'name': name, 'key': key, 'places': own, 'joined': joined, 'cost': result['cost'],
                               'apart': [] if joined else why_apart(name, results)})
    merges = [{'key': node.key, 'recordings': node.recordings, 'failed': results[node.key].get('failed'),
               'merges': results[node.key].get('merges', []), 'cost': results[node.key]['cost'],
               'bytes_in': results[node.key].get('bytes_in', 0)} for node in plan.nodes.values() if node.inputs]
    costs = [r['cost'] for r in results.values()]
    total = {'cpu_s': sum(c['cpu_s'] for c in costs), 'wall_s': sum(c['wall_s'] for c in costs),
             'memory_mb': max(c['memory_mb'] for c in costs), 'bytes_in': sum(r.get('bytes_in', 0) for r in results.values()),
             'bytes_out': sum(c['bytes_out'] for c in costs), 'longest_chain_s': round(longest_chain(plan, results), 3),
             'video_s': sum(r['seconds'] or 0 for r in recordings)}
    return {'places': places, 'recordings': recordings, 'merges': merges, 'total': total}


def published(index: int) -> str:
    return 'site.m' if index == 0 else f'site-{index + 1}.m'


def row(cells: list[Any], tag: str = 'td') -> str:
    return '<tr>' + ''.join(f'<{tag}>{html.escape(str(cell))}</{tag}>' for cell in cells) + '</tr>\n'


def table(heads: list[str], rows: list[list[Any]]) -> str:
    return '<table>\n' + row(heads, 'th') + ''.join(row(cells) for cells in rows) + '</table>\n'


def metres(value: float | None) -> str:
    return '' if value is None else f'{value:.4f}'


def of_the_path(place: Json) -> str:
    """The error of a place as a share of the path of its recordings."""
    return f'{100 * place["ate_m"] / place["path_m"]:.3f} %' if place['ate_m'] is not None and place['path_m'] else ''


def page(data: Json) -> str:
    total = data['total']
    places = [[i, p['file'], p['submap'], p['sensor'], ', '.join(p['recordings']), p['key_frames'], metres(p['ate_m']), of_the_path(p)]
              for i, p in enumerate(data['places'])]
    recordings = []
    for r in data['recordings']:
        coverage = f'{100 * r["frames_tracked"] / r["frames"]:.0f} %' if r['frames'] else ''
        remarks = ([r['failed']] if r['failed'] else []) + (r['warnings'] or []) + (['not joined: ' + a for a in r['apart']])
        recordings.append([r['name'], 'failed' if r['failed'] else 'joined' if r['joined'] else 'by itself',
                           ', '.join(map(str, r['places'])), r['frames'] or '', coverage, metres(r['ate_m']),
                           f'{r["cost"]["wall_s"]:.1f}', f'{r["cost"]["cpu_s"]:.1f}', f'{r["cost"]["memory_mb"]:.0f}',
                           r['cost']['node'], '; '.join(remarks)])
    merges = [[m['key'][:8], m['recordings'], ' + '.join(str(k) for one in m['merges'] for k in one['key_frames']),
               f'{m["cost"]["wall_s"]:.1f}', f'{m["cost"]["cpu_s"]:.1f}', f'{m["cost"]["memory_mb"]:.0f}', m['cost']['node'],
               m['failed'] or ''] for m in data['merges']]
    mapped = sum(not r['failed'] for r in data['recordings'])
    text = (f'{len(data["recordings"])} recordings, {mapped} mapped, {sum(r["joined"] for r in data["recordings"])} joined with '
            f'others; {len(data["places"])} places. {total["cpu_s"]:.0f} CPU seconds, {total["longest_chain_s"]:.0f} s of jobs that wait '
            f'for one another, at most {total["memory_mb"]:.0f} MB, {total["bytes_in"] / 1e6:.0f} MB read, '
            f'{total["bytes_out"] / 1e6:.0f} MB written.')
    return ('<!doctype html><meta charset="utf-8"><title>Site</title>\n<style>body{font:14px sans-serif;margin:2em}'
            'td,th{padding:2px 8px;text-align:left;border-bottom:1px solid #ddd;vertical-align:top}</style>\n'
            f'<h1>Site</h1><p>{html.escape(text)}</p>\n<h2>Places</h2>\n<p>A place is a submap: recordings that were joined.</p>\n' +
            table(['place', 'file', 'submap', 'sensor', 'recordings', 'key frames', 'ATE, m', 'of the path'], places) + '<h2>Recordings</h2>\n' +
            table(['recording', 'state', 'places', 'frames', 'tracked', 'ATE alone, m', 's', 'CPU s', 'MB', 'node', 'remarks'],
                  recordings) + '<h2>Merges</h2>\n' +
            table(['job', 'recordings', 'key frames', 's', 'CPU s', 'MB', 'node', 'remarks'], merges))


def publish(site: pathlib.Path, manifest: Manifest, plan: Plan) -> Json:
    """Writes report/ anew: the report and the site's maps."""
    data = gather(site, manifest, plan)
    report = site / 'report'
    shutil.rmtree(report, ignore_errors=True)
    report.mkdir()
    for i, one in enumerate(load_result(site, plan.root)['maps']):
        (report / published(i)).hardlink_to(site / 'jobs' / plan.root / one['file'])
    write_whole(report / 'report.json', json.dumps(data, indent=1) + '\n')
    write_whole(report / 'report.html', page(data))
    for left in (site / 'jobs').glob(f'*{UNFINISHED}*'):  # of jobs that were killed
        shutil.rmtree(left, ignore_errors=True)
    return data
