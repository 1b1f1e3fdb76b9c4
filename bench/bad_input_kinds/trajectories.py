# SPDX-License-Identifier: Apache-2.0
"""Trajectories that `covis eval` can't compare."""
from .kinds import Kind, both, change, column, cut, empty, fifo, folder_at, large, line, link, locked, remove, run, write


def kinds():
    return [*one_file('trajectory.txt'), *one_file('truth.txt'), *other_formats(), *pairs()]


def evaluated(*options):
    return ['eval', 'trajectory.txt', 'truth.txt', '--plot', 'out/picture.png', *options]


def kind(name, damage, *says, options=(), **more):
    return Kind('trajectories', name, evaluated(*options), list(says), damage, needs=('out',), **more)


def one_file(path):
    for name, damage, *says in (
            ('is empty', empty(path), 'no pose'), ('has comments alone', write(path, '# t x y z\n' * 9), 'no pose'),
            ('is cut within a row', change(path, lambda data: data[:len(data) // 2 // 10 * 10 - 7]), r':\d+:', 'columns|quaternion|finite'),
            ('is binary', write(path, bytes(range(256)) * 9), ':1:', 'columns'),
            ('is zeros', write(path, bytes(999)), ':1:', 'columns'), ('is a text', write(path, 'hello\n'), ':1:', 'columns'),
            ('has a row of 7 columns', line(path, 4, '1 2 3 4 5 6 7'), ':4:', 'columns|quaternion'),
            ('has a row of 9 columns', line(path, 4, '1 2 3 4 0 0 0 1 1'), ':4:', '9 columns'),
            ('has a stamp that is nan', column(path, 4, 1, 'nan'), ':4:', 'finite'),
            ('has a stamp that is a word', column(path, 4, 1, 'noon'), ':4:', 'finite'),
            ('has a stamp of 1e300', column(path, 4, 1, '1e300'), ':4:', 'finite|stamp'),
            ('has a position that is nan', column(path, 4, 2, 'nan'), ':4:', 'finite'),
            ('has a position that is infinite', column(path, 4, 3, 'inf'), ':4:', 'finite'),
            ('has a position of 1e308', column(path, 4, 3, '1e308'), 'position|metres|finite|large|far|range'),
            ('has a position beyond all numbers', column(path, 4, 3, '1e999'), ':4:', 'finite'),
            ('has a quaternion of zeros', line(path, 4, '0.375 0 0 0 0 0 0 0'), ':4:', 'unit quaternion'),
            ('has a quaternion of length 2', line(path, 4, '0.375 0 0 0 0 0 0 2'), ':4:', 'unit quaternion'),
            ('has a quaternion that is nan', column(path, 4, 8, 'nan'), ':4:', 'finite'),
            ('has numbers with a comma', change(path, lambda data: data.replace(b'.', b',')), ':1:', 'columns|stamp|quaternion|finite'),
            ('has a line of 1,000,000 characters', line(path, 4, 'x' * 1000000), ':4:', 'columns'),
            ('has an escape for the terminal', line(path, 4, '\x1b[2J 1 2 3 0 0 0 1'), ':4:', 'finite'), ('is a folder', folder_at(path), 'folder'),
            ('is a pipe', fifo(path), 'regular file'), ('is /dev/zero', link(path, '/dev/zero'), 'regular file'),
            ('is 2 GiB', large(path, 1 << 31), 'MiB'), ('is gone', remove(path), "can't be opened", 'No such file'),
            ('is a link to itself', link(path, path), "can't be opened")):
        yield kind(f'{path} {name}', damage, path.replace('.', r'\.'), *says)
    yield kind(f'{path} may not be read', locked(path), path, 'Permission denied', as_nobody=True)
    # The order of rows says nothing, and of several poses with one stamp the first counts (docs/evaluation.md).
    for name, damage in (('descends', change(path, lambda data: b'\n'.join(reversed(data.strip().split(b'\n'))))),
                         ('repeats a stamp', change(path, lambda data: data + data.strip().split(b'\n')[-1] + b'\n'))):
        yield kind(f'{path} {name}', damage, r'of them 1\d with truth', passed_over=True)


def other_formats():
    for name, content, *says in (('KITTI, eleven columns', '1 0 0 0 0 1 0 0 0 0 1\n' * 9, ':1:', '11 columns'),
                                 ('KITTI, no rotation', '2 0 0 0 0 1 0 0 0 0 1 0\n' * 9, ':1:', 'orthonormal'),
                                 ('KITTI, a mirror', '-1 0 0 0 0 1 0 0 0 0 1 0\n' * 9, ':1:', 'orthonormal'),
                                 ('KITTI, nan', 'nan 0 0 0 0 1 0 0 0 0 1 0\n' * 9, ':1:', 'finite'),
                                 ('EuRoC, seven columns', '1, 2, 3, 4, 1, 0, 0\n' * 9, ':1:', '7 columns'),
                                 ('EuRoC, no rotation', '1,0,0,0,0,0,0,0\n' * 9, ':1:', 'unit quaternion'),
                                 ('TartanAir, no rotation', '0 0 0 0 0 0 0\n' * 9, ':1:', 'unit quaternion'),
                                 ('formats that change', '0 0 0 0 0 0 0 1\n1 0 0 0 0 1 0 0 0 0 1 0\n' * 5, 'columns|format', ':2:')):
        yield kind(f'a truth of {name}', write('truth.txt', content), r'truth\.txt', *says)
    yield kind('TUM as KITTI', None, 'truth.txt:1', '8 columns', options=('--truth-format', 'kitti'))
    yield kind('TUM as TartanAir', None, 'trajectory.txt:1', '8 columns', options=('--format', 'tartanair'))
    poses = ['eval', 'poses.txt', 'poses.txt', '--stamps', 'times.txt', '--truth-stamps', 'times.txt']
    for name, damage, *says in (('too few stamps', cut('times.txt', 40), 'poses.txt:', 'times.txt has .* stamps; a file with one'),
                                ('a stamp that is nan', line('times.txt', 3, 'nan'), 'times.txt:3', 'seconds'),
                                ('no stamps', remove('times.txt'), 'times.txt', "can't be opened"),
                                ('a folder of stamps', folder_at('times.txt'), 'times.txt', 'folder'),
                                ('stamps as a pipe', fifo('times.txt'), 'times.txt', 'regular file'),
                                ('stamps that are binary', write('times.txt', bytes(range(256))), 'times.txt:1', 'seconds')):
        yield Kind('trajectories', f'KITTI with {name}', poses, says, damage)


def pairs():
    later = change('truth.txt', lambda data: b''.join(b'9' + row + b'\n' for row in data.strip().split(b'\n')))
    yield kind('no overlap', later, 'ground truth at their time', 'trajectory', 'truth')
    yield kind('one pose', change('trajectory.txt', lambda data: data.split(b'\n')[0]), '1 pose', 'at least 3')
    yield kind('two poses', change('trajectory.txt', lambda data: b'\n'.join(data.split(b'\n')[:2])), '2 poses', 'at least 3')
    yield kind('all poses in one place', change('truth.txt',
                                                lambda data: b''.join(row.split(b' ')[0] + b' 0 0 0 0 0 0 1\n' for row in data.strip().split(b'\n'))),
               'truth', 'positions are the same', options=('--align', 'sim3'))
    yield kind('an estimate in one place, with scale', change('trajectory.txt',
                                                              lambda data: b''.join(row.split(b' ')[0] + b' 0 0 0 0 0 0 1\n' for row in data.strip().split(b'\n'))), 'positions are the same', options=('--align', 'sim3'))
    yield Kind('trajectories', 'a map', ['eval', 'office.m', 'truth.txt'], ['office.m:1', 'columns'])
    yield Kind('trajectories', 'a folder of results', ['eval', 'out', 'truth.txt'], ['out', 'folder'])
    yield Kind('trajectories', 'an image', ['eval', 'image/first.png', 'truth.txt'], ['first.png:1', 'columns'])
