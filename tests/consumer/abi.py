#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the binary interface of a minor version: a program compiled against an earlier build must run with this one.

  tests/consumer/abi.py VERSION LAYOUT SYMBOLS RECORD [--update]

LAYOUT is what abi_layout.cpp printed, SYMBOLS the output of `nm --dynamic --defined-only --demangle` of libcovis, RECORD the
file that is kept. Within a minor version no line of the record may go; new symbols, structs and values are added to it by
--update. With another minor version it is written anew.
"""
import pathlib
import sys


def lines_of(layout, symbols):
    exported = sorted({line.split(' ', 2)[2] for line in symbols.splitlines() if ' covis::' in line and line.split()[1] in 'TDRB'})
    return [line.rstrip() for line in layout.splitlines()] + ['symbol ' + name for name in exported]


def main():
    version, layout, symbols, record = sys.argv[1], *(pathlib.Path(p) for p in sys.argv[2:5])
    minor = '.'.join(version.split('.')[:2])
    now = lines_of(layout.read_text(), symbols.read_text())
    kept = record.read_text().splitlines() if record.exists() else ['']
    same_version = kept[0] == f'version {minor}'
    gone = [line for line in kept[1:] if line not in now] if same_version else []
    for line in gone:
        print(f'gone or changed since version {minor}: {line.strip()}')
    if gone:
        print(f'programs compiled before would break: keep it, or begin version {minor.split(".")[0]}.{int(minor.split(".")[1]) + 1}')
        return 1
    if '--update' in sys.argv:
        record.write_text('\n'.join([f'version {minor}'] + now) + '\n')
        return 0
    new = [line for line in now if line not in kept]
    for line in new:
        print(f'not recorded: {line.strip()}')
    if new or not same_version:
        print(f'record it: {" ".join(sys.argv)} --update')
        return 1
    print(f'{len(now)} lines of the binary interface of version {minor} hold')
    return 0


if __name__ == '__main__':
    sys.exit(main())
