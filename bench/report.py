# SPDX-License-Identifier: Apache-2.0
"""Shared by bench/table and bench/suite: tables as text and as Markdown, and which command on which machine was measured."""
import os
import pathlib
import subprocess


def markdown(head, rows):
    lines = ['| ' + ' | '.join(head) + ' |', '| ' + ' | '.join('---' for _ in head) + ' |']
    return lines + ['| ' + ' | '.join(row) + ' |' for row in rows]


def columns(head, rows):
    """The same table for a terminal: the first three columns to the left, figures to the right."""
    widths = [max(map(len, column)) for column in zip(head, *rows)]
    return ['  '.join(cell.ljust(width) if k < 3 else cell.rjust(width) for k, (cell, width) in enumerate(zip(row, widths))).rstrip()
            for row in (head, *rows)]


def version_of(covis):
    return subprocess.run([covis, '--version'], stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def machine():
    for line in pathlib.Path('/proc/cpuinfo').read_text().splitlines():
        if line.startswith('model name'):
            return f'{os.cpu_count()} cores, ' + line.partition(':')[2].strip()
    return f'{os.cpu_count()} cores, unknown processor'
