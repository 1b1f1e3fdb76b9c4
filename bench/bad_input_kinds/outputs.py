# SPDX-License-Identifier: Apache-2.0
"""Places that results can't go to: no folder, no rights, something else in the way, a full disk."""
from .kinds import Kind, both, empty, fifo, folder_at, link, locked, run, write

# Commands that write one file, by the option that names it.
FILES = {'run --save-map': (lambda out: run('rgbd', '--save-map',
                                            out), 'm'), 'localize': (lambda out: ['localize', 'rgbd', '--map', 'office.m', '--out', out], 'txt'),
         'map merge': (lambda out: ['map', 'merge', 'office.m', 'mono.m', '--out', out], 'm'),
         'map prune': (lambda out: ['map', 'prune', 'office.m', '--key-frames', '2', '--out', out], 'm'),
         'map import': (lambda out: ['map', 'import', 'colmap/sparse/0', '--images', 'colmap/images', '--out', out], 'm'),
         'map export ply': (lambda out: ['map', 'export', 'office.m', '--to', 'ply', '--out', out], 'ply'),
         'map export tum': (lambda out: ['map', 'export', 'office.m', '--to', 'tum', '--out', out], 'txt'),
         'map info --picture': (lambda out: ['map', 'info', 'office.m', '--picture', out], 'png'),
         'eval --plot': (lambda out: ['eval', 'trajectory.txt', 'truth.txt', '--plot', out], 'png'),
         'vocab train': (lambda out: ['vocab', 'train', 'mono/images', '--branching', '4', '--depth', '3', '--quiet', '--overwrite', '--out', out],
                         'covis-voc'), 'vocab convert': (lambda out: ['vocab', 'convert', 'words.txt', out, '--overwrite'], 'covis-voc'),
         'map export geojson': (lambda out: ['map', 'export', 'office.m', '--to', 'geojson', '--origin', '48', '11', '--out', out], 'geojson'),
         'check': (lambda out: ['check', 'rgbd', '--out', out], 'png'),
         'check --import-camera': (lambda out: ['check', '--import-camera', 'colmap/sparse/0/cameras.txt', '--out', out], 'yaml')}
FOLDERS = {'run': lambda out: run('rgbd', out=out), 'map split': lambda out: ['map', 'split', 'office.m', '--around', '0,0,0,100', '--out', out],
           'map export colmap': lambda out: ['map', 'export', 'office.m', '--to', 'colmap', '--out', out],
           'synth': lambda out: ['synth', 'room', '--frames', '2', '--quiet', '--overwrite', '--out', out]}
# The first bytes of a file that the command replaces, where no good input is one.
OLDER = {'txt': '1.000000000' + ' 0.000000000' * 6 + ' 1.000000000\n', 'ply': 'ply\n', 'covis-voc': 'COVISVOC', 'yaml': 'width: 640\n',
         'geojson': '{\n "features": [\n',
         'png': b'\x89PNG\r\n\x1a\n' + bytes(25) + b'\0\0\0\x0etEXtSoftware\0Covis\xf9\x0b\x3b\xc4'}
# An input of each command, or a file of another kind, in the place of its output.
GIVEN = {'localize': ('office.m', 'rgbd/groundtruth.txt', 'rgbd/camera.yaml'), 'map export ply': ('office.m', 'camera.yaml'),
         'map export tum': ('office.m', 'camera.yaml'), 'map export geojson': ('office.m', 'camera.yaml'), 'map info --picture': ('office.m', 'image/first.png'),
         'map merge': ('office.m', 'mono.m'), 'map prune': ('office.m',), 'map import': ('colmap/sparse/0/images.txt',),
         'eval --plot': ('truth.txt', 'trajectory.txt', 'image/first.png'), 'vocab train': ('office.m', 'image/first.png'),
         'vocab convert': ('words.txt', 'office.m'), 'check': ('rgbd/camera.yaml', 'office.m', 'image/first.png'),
         'check --import-camera': ('colmap/sparse/0/cameras.txt', 'office.m', 'truth.txt')}
MAPS = ('run --save-map', 'map merge', 'map prune', 'map import')


def kinds():
    return [*files(), *in_place_of_others(), *folders(), *full_disks()]


def in_place_of_others():
    for name, places in GIVEN.items():
        for place in places:
            yield Kind('outputs', f'{name}: over {place}', FILES[name][0](place), [place.rsplit('/', maxsplit=1)[-1].replace('.', r'\.'),
                                                                                   'left as they are|it is there and is not'],
                       needs=(place.split('/', maxsplit=1)[0],))
    for name in ('trajectory.txt', 'map.ply', 'summary.json', 'stats.jsonl', 'report.html', 'keyframes.txt', 'scene.bin', 'trajectory.png'):
        yield Kind('outputs', f'run: my notes in the place of {name}', run('rgbd', out='mine'), [name.replace('.', r'\.'), 'it is there and is not'],
                   write(f'mine/{name}', 'my notes\n'))
    yield Kind('outputs', 'run: the map in the place of a result', run('rgbd', '--save-map', 'new/trajectory.txt', out='new'),
               [r'trajectory\.txt', 'left as they are'], changes=('new',))
    yield Kind('outputs', 'check: another picture has the name that is not given', ['check', 'rgbd'], [r'check\.png', 'it is there and is not'],
               write('check.png', b'\x89PNG\r\n\x1a\n' + bytes(50)))
    for kind in ('colmap', 'nerfstudio', 'bundler'):
        yield Kind('outputs', f'map export {kind}: into a folder of images', ['map', 'export', 'office.m', '--to', kind, '--out', 'things'],
                   ['things', 'other things'], write('things/images/000000.png', 'x'))


def after_the_run(name):
    """What may change: the results of a run are written though its map can't be, when that shows at the end alone."""
    return ('out',) if name == 'run --save-map' else ()


def files():
    for name, (words, ending) in FILES.items():
        yield Kind('outputs', f'{name}: a folder that is not there', words(f'gone/new.{ending}'), ['gone'])
        yield Kind('outputs', f'{name}: a file where the folder should be', words(f'camera.yaml/new.{ending}'), ['camera.yaml'],
                   needs=('camera.yaml',))
        yield Kind('outputs', f'{name}: a folder in the way', words(f'new.{ending}'),
                   [f'new.{ending}'.replace('.', r'\.'), 'folder|directory|regular|map'],
                   both(folder_at(f'new.{ending}'), write(f'new.{ending}/a', 'x')))
        yield Kind('outputs', f'{name}: a folder without the right to write', words(f'locked/new.{ending}'), ['locked', 'Permission denied'],
                   both(folder_at('locked'), locked('locked', 0o555)), as_nobody=True,
                   changes=after_the_run(name))
        yield Kind('outputs', f'{name}: a name of 300 characters', words('x' * 300 + f'.{ending}'), ['too long'])
        yield Kind('outputs', f'{name}: /dev/full', words(f'new.{ending}'), [f'new.{ending}'.replace('.', r'\.'), 'No space left|map'],
                   link(f'new.{ending}', '/dev/full'), changes=after_the_run(name))
    for name in MAPS:
        words, _ = FILES[name]
        for what, damage in (('a text', write('new.m', 'my notes\n')), ('an image', write('new.m', b'\x89PNG\r\n\x1a\n')),
                             ('a vocabulary', write('new.m', b'COVISVOC' + bytes(99))), ('a pipe', fifo('new.m'))):
            yield Kind('outputs', f'{name}: {what} in the way', words('new.m'), [r'new\.m', 'map|regular|pipe that nobody reads'], damage,
                       changes=after_the_run(name) if what == 'a pipe' else ())


def folders():
    for name, words in FOLDERS.items():
        yield Kind('outputs', f'{name}: a file where the folder should be', words('camera.yaml'), ['camera.yaml'])
        yield Kind('outputs', f'{name}: a file on the way to the folder', words('camera.yaml/new'), ['camera.yaml'])
        yield Kind('outputs', f'{name}: no right to make the folder', words('locked/new'), ['locked', 'Permission denied'],
                   both(folder_at('locked'), locked('locked', 0o555)), as_nobody=True)
        yield Kind('outputs', f'{name}: no right to write into the folder', words('locked'), ['locked', 'Permission denied'],
                   both(folder_at('locked'), locked('locked', 0o555)), as_nobody=True)
        yield Kind('outputs', f'{name}: a name of 300 characters', words('x' * 300), ['too long'])
        yield Kind('outputs', f'{name}: a link to nothing on the way', words('way/new'), ['way'], link('way', 'gone/there'))
    yield Kind('outputs', 'run --save-map: the kept images would go into a folder of other things',
               run('rgbd', '--save-map', 'new.m', '--keep-images'), ['new.m.images', 'other things'], write('new.m.images/letter.txt', 'x'))
    yield Kind('outputs', 'synth over a folder of other things', ['synth', 'room', '--frames', '2', '--quiet', '--out', 'things'],
               ['things', 'not empty'], write('things/letter.txt', 'x'))
    for name in ('trajectory.txt', 'map.ply', 'summary.json', 'stats.jsonl', 'report.html', 'keyframes.txt', 'scene.bin'):
        yield Kind('outputs', f'run: a folder in the place of {name}', run('rgbd'), [name.replace('.', r'\.'), 'folder|directory'],
                   both(folder_at(f'out/{name}'), write(f'out/{name}/a', 'x')), needs=('out',), changes=('out',))


def full_disks():
    """A limit on the size of files, which writing meets as it meets a full disk."""
    for name, (words, ending) in FILES.items():
        for limit in (1, 60):
            out = f'out/new.{ending}'
            yield Kind('outputs', f'{name}: room for {limit} bytes', words(out), ['too large|too big|no space|written'], file_limit=limit,
                       needs=('out',), changes=after_the_run(name))
        yield Kind('outputs', f'{name}: room for 60 bytes, an older one there', words(f'older.{ending}'), ['too large|too big|no space|written'],
                   _older(name, ending), needs=('office.m', 'out'), file_limit=60, changes=after_the_run(name))
    yield Kind('outputs', 'run: room for 1000 bytes', run('rgbd'), ['too large|too big|no space|written'], file_limit=1000, needs=('out',),
               changes=('out',))
    yield Kind('outputs', 'synth: room for 1000 bytes', ['synth', 'room', '--frames', '2', '--quiet', '--out', 'new'],
               ['new', 'too large|too big|no space|written'], file_limit=1000, changes=('new',))


def _older(name, ending):
    if name not in MAPS:
        return write(f'older.{ending}', OLDER[ending])

    def do(folder):
        (folder / 'older.m').write_bytes((folder / 'office.m').read_bytes())
    return do
