#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Golden sums: a change that is meant to leave results alone leaves every byte of them alone.

  tests/golden/golden.py COVIS [--work DIR] [--sums FILE] [--update] [--only NAME,…]

Renders small recordings, runs COVIS (the command's file) on them as RUNS says, and compares the MD5 sums of all
trajectories, maps and saved maps, and of what was found for each frame, with those kept in sums.json beside this file.

Rounding of the C library's functions depends on the processor (fused multiply-add or not) and on its version, so that
sums are kept for each platform; on one without sums the runs are made and must succeed, and the test counts as skipped
(exit code 77). --update writes the sums of this platform: do it only in a commit that says which results changed, and why.
"""
import argparse
import hashlib
import json
import pathlib
import platform
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
SIZE = ['--width', '320', '--height', '240', '--fps', '8']

# name: arguments of `covis synth`
RECORDINGS = {
    'room_rgbd': ['room', '--sensor', 'rgbd', '--seed', '2', '--noise', '2'],
    'room_stereo': ['room', '--sensor', 'stereo', '--noise', '2'],
    'room_mono': ['room', '--sensor', 'mono', '--noise', '2'],
    'desk_rgbd': ['desk', '--sensor', 'rgbd', '--frames', '60', '--noise', '3', '--depth-noise', '1', '--exposure', '0.2',
                  '--blur', '8', '--distortion', '1'],
    'desk_mono': ['desk', '--sensor', 'mono', '--frames', '60'],
    'corridor_mono': ['corridor', '--sensor', 'mono', '--frames', '150'],
    'street_stereo': ['street', '--sensor', 'stereo', '--frames', '80'],
    'posters_rgbd': ['posters', '--sensor', 'rgbd', '--frames', '120'],
}
# name: recording it is cut from, the frames (first, end) it is put together of, backwards where first > end, and, if
# other than 1, the factor by which its camera.yaml has the focal length wrong
CUTS = {
    'posters_cut': ('posters_rgbd', [(0, 30), (70, 110)]),
    'room_cut_mono': ('room_mono', [(0, 45), (85, 115), (30, 60)]),
    'room_cut_rgbd': ('room_rgbd', [(0, 30), (50, 60), (20, 40)]),
    'room_back_rgbd': ('room_rgbd', [(0, 50), (110, 20)]),
    'posters_claimed': ('posters_rgbd', [(0, 120)], 1.02),
}
# name: recording and arguments of `covis run`. MAP:NAME is the map that an earlier run saved.
RUNS = {
    'room_rgbd': ('room_rgbd', []),
    'room_stereo': ('room_stereo', ['--count', '60']),
    'room_stereo_loop': ('room_stereo', []),
    'room_mono': ('room_mono', []),
    'desk_rgbd': ('desk_rgbd', []),
    'desk_mono': ('desk_mono', []),
    'corridor_mono': ('corridor_mono', []),
    'corridor_mono_plain': ('corridor_mono', ['--vocabulary', 'none', '--set', 'mapper.refine_focal=false', '--set', 'mapper.refine_distortion=false']),
    'street_stereo': ('street_stereo', []),
    'room_stereo_stride': ('room_stereo', ['--count', '20', '--stride', '3']),
    'posters_cut': ('posters_cut', []),
    'posters_refined': ('posters_claimed', []),  # the focal length
    'room_cut_mono': ('room_cut_mono', []),
    'room_cut_rgbd': ('room_cut_rgbd', []),
    'room_back_rgbd': ('room_back_rgbd', []),
    'room_rgbd_culled': ('room_rgbd', ['--set', 'mapper.cull_redundancy=0.5']),  # ten key frames go
    'room_rgbd_begun': ('room_rgbd', ['--count', '25']),
    'room_rgbd_left': ('room_rgbd', ['--map', 'MAP:room_rgbd_begun', '--localize']),
    'room_rgbd_continued': ('room_cut_rgbd', ['--map', 'MAP:room_rgbd', '--first', '20']),
    'room_rgbd_localized': ('room_cut_rgbd', ['--map', 'MAP:room_rgbd', '--localize']),
    'room_mono_localized': ('room_cut_mono', ['--map', 'MAP:room_mono', '--localize', '--first', '10']),
}
# What is summed up of each frame: what was found, not how long it took.
FRAME_FIELDS = ('frame', 'state', 'features', 'matches', 'local_points', 'in_view', 'inliers', 'key_frame')


def platform_key():
    """What the C library's rounding depends on."""
    machine = platform.machine()
    fma = machine != 'x86_64'
    if not fma:
        for line in pathlib.Path('/proc/cpuinfo').read_text().splitlines():
            if line.startswith('flags'):
                fma = ' fma ' in line + ' '
                break
    return f"{machine}{'-fma' if fma else ''} {' '.join(platform.libc_ver())}"


def md5(data):
    return hashlib.md5(data).hexdigest()


def cut(source, target, pieces, focal_factor=1):
    """A recording of pieces of another: lists of files alone, with stamps that rise."""
    target.mkdir()
    folders = [d for d in source.iterdir() if d.is_dir()]
    for folder in folders:
        (target / folder.name).mkdir()
    camera = (source / 'camera.yaml').read_text()
    if focal_factor != 1:
        camera = re.sub(r'^(f[xy]): (\S+)$', lambda m: f'{m[1]}: {float(m[2]) * focal_factor:.6f}', camera, flags=re.M)
    (target / 'camera.yaml').write_text(camera)
    wanted = [i for first, end in pieces
              for i in range(first, end, 1 if first < end else -1)]
    lines = {}
    for folder in folders:
        files = sorted(folder.iterdir(), key=lambda file: float(file.stem))
        for step, i in enumerate(wanted):
            name = f'{folder.name}/{step / 8:.6f}{files[i].suffix}'
            (target / name).symlink_to(files[i].resolve())
            lines.setdefault(folder.name, []).append(f'{step / 8:.6f} {name}\n')
    if 'rgb' in lines:
        (target / 'rgb.txt').write_text(''.join(lines['rgb']))
        (target / 'depth.txt').write_text(''.join(lines['depth']))
    else:
        (target / 'times.txt').write_text(''.join(f'{step / 8:.6f}\n' for step in range(len(wanted))))


def sums_of(out, saved):
    """The sums of one run's results, by file."""
    files = [f for f in sorted(out.iterdir()) if f.name.endswith('.ply') or f.name.endswith('.txt')]
    sums = {f.name: md5(f.read_bytes()) for f in files}
    frames = [json.loads(line) for line in (out / 'stats.jsonl').read_text().splitlines()]
    sums['frames'] = md5(json.dumps([[f.get(k) for k in FRAME_FIELDS] for f in frames]).encode())
    if saved.exists():
        sums['map'] = md5(saved.read_bytes())
    return sums


def run_all(covis, work, only):
    results = {}
    if work.exists():
        shutil.rmtree(work)
    work.mkdir(parents=True)
    wanted = [name for name in RUNS if not only or name in only]
    needed = {RUNS[name][0] for name in wanted}
    for name in wanted:
        needed |= {RUNS[a[4:]][0] for a in RUNS[name][1] if a.startswith('MAP:')}
    needed |= {CUTS[name][0] for name in needed if name in CUTS}
    for name, arguments in RECORDINGS.items():
        if name in needed:
            subprocess.run([covis, 'synth', *arguments, *SIZE, '--quiet', '--out', work / name], check=True)
    for name, (source, *how) in CUTS.items():
        if name in needed:
            cut(work / source, work / name, *how)
    for name in wanted:
        recording, arguments = RUNS[name]
        arguments = [str(work / f'{a[4:]}.m') if a.startswith('MAP:') else a for a in arguments]
        saved = work / f'{name}.m'
        save = [] if '--localize' in arguments else ['--save-map', saved]
        out = work / f'out_{name}'
        subprocess.run([covis, 'run', work / recording, '--quiet', '--out', out, *save, *arguments], check=True)
        results[name] = sums_of(out, saved)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('covis', type=pathlib.Path)
    parser.add_argument('--work', type=pathlib.Path, default=pathlib.Path('golden-out'))
    parser.add_argument('--sums', type=pathlib.Path, default=HERE / 'sums.json')
    parser.add_argument('--update', action='store_true')
    parser.add_argument('--only', default='')
    args = parser.parse_args()
    only = [name for name in args.only.split(',') if name]
    if unknown := sorted(set(only) - set(RUNS)):
        parser.error(f"--only: there is no run {', '.join(unknown)}; there are {', '.join(RUNS)}")
    results = run_all(args.covis.resolve(), args.work.resolve(), only)
    known = json.loads(args.sums.read_text()) if args.sums.exists() else {}
    key = platform_key()
    if args.update:
        known.setdefault(key, {}).update(results)
        args.sums.write_text(json.dumps(known, indent=1, sort_keys=True) + '\n')
        print(f'{len(results)} runs: sums of {key} written to {args.sums}')
        return 0
    if key not in known:
        print(f'{len(results)} runs made; there are no sums of {key} to compare with (there are: {", ".join(known)})')
        return SKIPPED
    wrong = 0
    for name, sums in results.items():
        kept = known[key].get(name, {})
        different = sorted(f for f in sums.keys() | kept.keys() if sums.get(f) != kept.get(f))
        if different:
            wrong += 1
            print(f'{name}: not as kept: {", ".join(different)}')
    print(f'{len(results)} runs, {wrong} with other bytes than those kept for {key}')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
