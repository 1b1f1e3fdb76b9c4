# SPDX-License-Identifier: Apache-2.0
"""Rendered recordings for a test of the fleet: overlapping pieces of walks through two rooms, as folders of their own.

Each is rendered for itself at another rate, with noise and changes of brightness, and begins at another frame: no pose and no
stamp is in two of them.
"""
from __future__ import annotations

import os
import pathlib
import shutil
import subprocess

FRAMES, PIECE = 160, 60
WIDTH, HEIGHT = 640, 480


def lines_of(file: pathlib.Path) -> list[str]:
    return [line for line in file.read_text().splitlines() if not line.startswith('#')]


def render(covis: pathlib.Path, folder: pathlib.Path, sensor: str, seed: int, frames: int, fps: float) -> None:
    if not (folder / 'groundtruth.txt').exists():
        subprocess.run([covis, 'synth', 'room', '--sensor', sensor, '--seed', str(seed), '--frames', str(frames), '--fps', f'{fps:.2f}',
                        '--width', str(WIDTH), '--height', str(HEIGHT), '--noise', '2', '--exposure', '0.1', '--quiet', '--overwrite',
                        '--out', folder], check=True)


def piece(walk: pathlib.Path, first: int, count: int, out: pathlib.Path) -> None:
    """Some frames of a rendered walk as a recording of their own, with the stamps they had."""
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    for name in ('camera.yaml', 'calib.txt'):
        if (walk / name).exists():
            shutil.copy(walk / name, out)
    for name in ('rgb.txt', 'depth.txt', 'associations.txt', 'times.txt', 'poses.txt', 'groundtruth.txt'):
        if (walk / name).exists():
            (out / name).write_text('\n'.join(lines_of(walk / name)[first:first + count]) + '\n')
    for folder in ('rgb', 'depth', 'images', 'image_0', 'image_1'):
        if (walk / folder).exists():
            (out / folder).mkdir()
            files = sorted((walk / folder).iterdir(), key=lambda p: float(p.stem))[first:first + count]
            for i, file in enumerate(files):
                os.link(file, out / folder / (file.name if folder in ('rgb', 'depth') else f'{i:06d}.png'))


def cut_off(recording: pathlib.Path, after: int) -> None:
    """Leaves what a copy that broke off leaves: no image after one that is cut short."""
    folder = next(recording / name for name in ('rgb', 'images', 'image_0') if (recording / name).exists())
    files = sorted(folder.iterdir(), key=lambda p: float(p.stem))
    start = files[after].read_bytes()[:2000]
    files[after].unlink()  # it is a link to the walk's own
    files[after].write_bytes(start)
    for file in files[after + 1:]:
        file.unlink()


def make(covis: pathlib.Path, work: pathlib.Path, sensors: list[str], each: int = 6) -> list[tuple[str, str]]:
    """`each` recordings of each of two rooms, the sensors in turns: (folder's name, what it should be joined with)."""
    made: list[tuple[str, str]] = []
    for i in range(each):
        for k, (seed, site) in enumerate(((1, 'north'), (4, 'south'))):
            sensor = sensors[i % len(sensors)]
            turn, turns = i // len(sensors), each // len(sensors)
            first = round(turn * (FRAMES - PIECE) / max(turns - 1, 1) / (3 if turns == 2 else 1))
            first += 1 + i  # frame 0 has one stamp and one pose whatever the rate
            name = f'{site}-{sensor}-{turn}'
            render(covis, work / 'walks' / name, sensor, seed, first + PIECE, 8 + 0.07 * (2 * i + k))
            piece(work / 'walks' / name, first, PIECE, work / 'recordings' / name)
            made.append((name, site))
    return made
