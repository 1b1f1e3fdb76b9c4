# SPDX-License-Identifier: Apache-2.0
"""Wrong options: unknown, without a value, out of range, no number, contradictory."""
from .kinds import Kind, run


def kinds():
    return [*words(), *missing_values(), *numbers(), *run_options(), *other_commands(), *map_commands(), *view_options()]


def kind(name, words, *says, **more):
    return Kind('options', name, list(words), list(says), **more)


def words():
    yield kind('no command', [], 'subcommand is required')
    yield kind('an unknown command', ['rnu', 'rgbd'], 'rnu: no such command', 'covis run')
    yield kind('an unknown sub-command of map', ['map', 'inof', 'office.m'], 'inof', 'info')
    yield kind('an unknown sub-command of vocab', ['vocab', 'trian', 'mono'], 'trian', 'train')
    yield kind('map without a sub-command', ['map'], 'subcommand is required')
    yield kind('vocab without a sub-command', ['vocab'], 'subcommand is required')
    for command, *needed in (('run',), ('eval', 'rgbd'), ('check',), ('localize', '--map', 'office.m'),
                             ('calibrate', '--board', '9x6', '--square', '1'),
                             ('synth', '--out', 'made'), ('view',)):
        yield kind(f'an unknown option of {command}', [command, 'rgbd', *needed, '--frobnicate', '3'], '--frobnicate')
    for command, wanted in (('run', 'PATH'), ('eval', 'TRAJECTORY'), ('check', 'PATH'), ('localize', 'PATH'), ('calibrate', 'PATH'),
                            ('synth', 'WORLD'),
                            ('view', 'PATH')):
        yield kind(f'{command} without its argument', [command], wanted)
    for command in ('info', 'check', 'prune', 'split', 'export'):
        yield kind(f'map {command} without a file', ['map', command], 'FILE')
    yield kind('map merge without files', ['map', 'merge', '--out', 'out/office.m'], 'FILES')
    yield kind('map import without a model', ['map', 'import', '--images', 'rgbd/rgb', '--out', 'out/office.m'], 'MODEL')
    yield kind('vocab train without images', ['vocab', 'train', '--out', 'out/words.covis-voc'], 'IMAGES')
    yield kind('vocab info without a file', ['vocab', 'info'], 'FILE')
    yield kind('vocab convert without a target', ['vocab', 'convert', 'words.txt'], 'OUT')
    yield kind('two recordings', run('rgbd', 'mono'), 'mono')
    yield kind('a third trajectory', ['eval', 'trajectory.txt', 'truth.txt', 'poses.txt'], 'poses.txt')
    yield kind('an option of another command', run('rgbd', '--board', '9x6'), '--board')
    yield kind('an option that is cut short', run('rgbd', '--sens', 'mono'), '--sens')
    yield kind('an option with one dash', run('rgbd', '-sensor', 'mono'), '-s')
    yield kind('an option twice', run('rgbd', '--sensor', 'mono', '--sensor', 'rgbd'), '--sensor')
    yield kind('a flag with a value', run('rgbd', '--skip-bad=maybe'), '--skip-bad')


def missing_values():
    for option in ('--sensor', '--kind', '--camera', '--topic', '--first', '--count', '--stride', '--map', '--save-map', '--save-every',
                   '--max-memory',
                   '--vocabulary', '--format', '--features', '--simd', '--config', '--set', '--view-host', '--out'):
        yield kind(f'run {option} at the end, without its value', ['run', 'rgbd', option], f'{option}')
    for option in ('--camera', '--map', '--save-map', '--vocabulary', '--config', '--out', '--sensor', '--format', '--set', '--save-every',
                   '--topic'):
        yield kind(f'run {option} with an empty value', [*run('rgbd'), option, ''] if option != '--out' else ['run', 'rgbd', '--out', ''],
                   f'{option}')
    yield kind('an empty path', run(''), 'PATH|: it does not exist')
    yield kind('map merge --out with an empty value', ['map', 'merge', 'office.m', 'mono.m', '--out', ''], '--out')
    yield kind('eval --plot with an empty value', ['eval', 'trajectory.txt', 'truth.txt', '--plot', ''], '--plot')
    yield kind('localize --map with an empty value', ['localize', 'rgbd', '--map', '', '--out', 'out/found.txt'], '--map')
    yield kind('synth --out with an empty value', ['synth', 'room', '--frames', '2', '--quiet', '--out', ''], '--out')
    yield kind('synth --width with an empty value', ['synth', 'room', '--frames', '2', '--quiet', '--out', 'made', '--width', ''], '--width')


def numbers():
    """Numbers that are none, or lie out of range."""
    for option, values, wanted in (
            ('--first', ('-1', '1.5', 'nan', 'x', '99999999999999999999'), 'whole number from 0'),
            ('--count', ('0', '-5', '1.5', 'inf', '99999999999999999999'), 'whole number from 1'),
            ('--stride', ('0', '-1', '0x2', 'nan', '99999999999'), 'whole number from 1'),
            ('--features', ('1', '40000', 'nan', '100.5', '-1000'), '50 to 30000|50 - 30000|--features'),
            ('--max-memory', ('0', '-1', '2000000', 'nan', '1e3'), '1 to 1000000|--max-memory'),
            ('--view', ('70000', '-1', 'x', 'nan'), '0 to 65535|--view')):
        for value in values:
            yield kind(f'run {option}={value}', run('rgbd', f'{option}={value}'), option, wanted)
    for option, values in (('--delta', ('0', '-1', 'nan', 'inf', '1e999', 'one')), ('--max-difference', ('0', '-0.02', 'nan', '1e-999'))):
        for value in values:
            yield kind(f'eval {option}={value}', ['eval', 'trajectory.txt', 'truth.txt', f'{option}={value}'], option, 'positive number')


def run_options():
    for option, value, *says in (
            ('--sensor', 'sonar', 'sonar', 'mono,rgbd,stereo'), ('--sensor', 'stereo', 'rgbd', '--sensor'),
            ('--sensor', 'RGBD', 'RGBD', 'mono,rgbd,stereo'),
            ('--kind', 'disk', 'disk', 'kitti'), ('--kind', 'kitti', 'rgbd', 'image_0'), ('--kind', 'euroc', 'rgbd', 'sensor.yaml|cam0'),
            ('--kind', 'tartanair', 'rgbd', 'image_left'), ('--kind', 'openloris', 'color.txt'), ('--kind', 'bag', 'rgbd', 'metadata.yaml'),
            ('--kind', 'video', 'rgbd', 'folder|video'), ('--kind', 'camera', 'rgbd', 'number'), ('--format', 'csv', 'csv', 'euroc,kitti,tum'),
            ('--simd', 'abacus', 'abacus', 'scalar'), ('--first', '12', 'rgbd', '12 frames', 'from frame 12'),
            ('--first', '9223372036854775807', 'rgbd', '12 frames'),
            ('--save-every', 'x', '--save-every', '120s'), ('--save-every', '-1', '--save-every', '120s'),
            ('--save-every', '5m', '--save-every', '120s'),
            ('--save-every', 'nans', '--save-every', '120s'), ('--save-every', '1e99s', '--save-every', '120s'),
            ('--save-every', '99999999999999999999', '--save-every', '120s'),
            ('--max-memory', '1', '--max-memory', 'at least'), ('--topic', '/camera', 'topic', 'bag'), ('--right-topic', '/camera', 'topic', 'bag'),
            ('--vocabulary', 'gone.covis-voc', 'gone.covis-voc', "can't be opened|does not exist|there is no"),
            ('--map', 'gone.m', 'gone.m', "can't be opened|does not exist"),
            ('--config', 'gone.yaml', 'gone.yaml', "can't be opened|does not exist"),
            ('--camera', 'gone.yaml', 'gone.yaml', "can't be opened|does not exist"),
            ('--view-host', '0.0.0.0', '--view-host', '--view')):
        yield kind(f'run {option} {value}', run('rgbd', option, value), *says)
    yield kind('run --localize without a map', run('rgbd', '--localize'), '--localize', '--map')
    yield kind('run --keep-images without a map to save', run('rgbd', '--keep-images'), '--keep-images', '--save-map')
    yield kind('run --view-close without --view', run('rgbd', '--view-close'), '--view-close', '--view')
    yield kind('run on a camera that is not there', run('97', '--camera', 'camera.yaml'), '97', 'camera|open|exist')
    yield kind('run on a camera without a camera file', run('97'), '97')
    yield kind('run on a camera with a number beyond all', run('99999999999999999999', '--camera', 'camera.yaml'), '99999999999999999999')
    yield kind('run without a recording', ['run', '--quiet', '--out', 'out'], 'PATH is missing', 'folder')
    yield kind('run on a folder that is not there', run('gone'), 'gone: it does not exist', 'folder')
    yield kind('run, a name of 300 characters', run('x' * 300), 'too long|does not exist')
    yield kind('run, a name with a line break and an escape', run('go\n\x1b[31mne'), 'does not exist')
    yield kind('--sandbox without a folder', ['--sandbox'], '--sandbox')
    yield kind('--sandbox with a file', ['--sandbox', 'camera.yaml', *run('rgbd')], '--sandbox', 'camera.yaml')
    yield kind('--sandbox behind the command', [*run('rgbd'), '--sandbox', 'out'], '--sandbox')
    yield kind('a sandbox without the folder for results', ['--sandbox', 'box', *run('rgbd')], 'out', needs=('out',), changes=('box',))


def other_commands():
    yield kind('eval --align affine', ['eval', 'trajectory.txt', 'truth.txt', '--align', 'affine'], 'affine', 'se3')
    yield kind('eval --delta-unit miles', ['eval', 'trajectory.txt', 'truth.txt', '--delta-unit', 'miles'], 'miles', 'frames')
    yield kind('eval --format csv', ['eval', 'trajectory.txt', 'truth.txt', '--format', 'csv'], 'csv', 'tum')
    yield kind('eval --plot errors.jpg', ['eval', 'trajectory.txt', 'truth.txt', '--plot', 'errors.jpg'], 'errors.jpg', r'\.png', r'\.html')
    yield kind('check with two inputs', ['check', 'rgbd', '--import-camera', 'camera.yaml'], '--import-camera')
    yield kind('check --import-camera as JSON', ['check', '--import-camera', 'camera.yaml', '--json'], '--json')
    yield kind('localize without a map', ['localize', 'rgbd', '--out', 'out/found.txt'], '--map is required')
    yield kind('localize --set without a name', ['localize', 'rgbd', '--map', 'office.m', '--set', '=3', '--out', 'out/found.txt'],
               'setting|NAME=VALUE')
    for name, options, *says in (('9by6', ['--board', '9by6'], '--board', 'COLUMNSxROWS'), ('2x2', ['--board', '2x2'], '--board', '3 to 100'),
                                 ('-9x6', ['--board=-9x6'], '--board', '3 to 100'), ('1000x3', ['--board', '1000x3'], '--board', '3 to 100'),
                                 ('99999999999x6', ['--board', '99999999999x6'], '--board', '3 to 100'),
                                 ('9x6x5', ['--board', '9x6x5'], '--board', 'COLUMNSxROWS')):
        yield kind(f'calibrate --board {name}', ['calibrate', 'board', *options, '--square', '0.03', '--out', 'out/camera.yaml'], *says)
    for value in ('0', '-1', 'nan', 'inf', 'x'):
        yield kind(f'calibrate --square={value}', ['calibrate', 'board', '--board', '9x6', f'--square={value}', '--out', 'out/camera.yaml'],
                   '--square', 'positive')
    calibrate = ['calibrate', 'board', '--board', '9x6', '--square', '0.03', '--out', 'out/camera.yaml']
    yield kind('calibrate without --board', ['calibrate', 'board', '--square', '0.03'], '--board is required')
    yield kind('calibrate without --square', ['calibrate', 'board', '--board', '9x6'], '--square is required')
    yield kind('calibrate --marker on a checkerboard', [*calibrate, '--marker', '0.02'], '--marker', '--charuco')
    yield kind('calibrate --charuco without --marker', [*calibrate, '--charuco'], '--marker')
    yield kind('calibrate --marker larger than a square', [*calibrate, '--charuco', '--marker', '0.04'], '--marker', 'less')
    yield kind('calibrate --marker nan', [*calibrate, '--charuco', '--marker', 'nan'], '--marker')
    yield kind('calibrate with an unknown dictionary', [*calibrate, '--charuco', '--marker', '0.02', '--dictionary', '9X9_1'], '--dictionary', '4X4')
    yield kind('calibrate with a dictionary that is too small', [*calibrate[:2], '--board', '90x60', '--square', '0.03', '--charuco', '--marker',
                                                                 '0.02'],
               '--board', 'markers')
    yield kind('calibrate --stride 0', [*calibrate, '--stride', '0'], '--stride', '1')
    yield kind('calibrate a board that is not in the images', ['calibrate', 'board', '--board', '8x8', '--square', '0.03', '--out',
                                                               'out/camera.yaml'], 'board')
    yield kind('calibrate too few views', calibrate, 'board|views')
    yield kind('calibrate a folder without images', ['calibrate', 'colmap', *calibrate[2:]], 'colmap', 'no images')
    yield kind('calibrate a map as a video', ['calibrate', 'office.m', *calibrate[2:]], 'office.m', 'video')
    train = ['vocab', 'train', 'mono/images', '--quiet', '--overwrite', '--out', 'out/words.covis-voc']
    for option, values in (('branching', ('1', '0', 'nan', '100000')), ('depth', ('0', '100', '2.5')), ('threads', ('-1', '5000')),
                           ('memory', ('0', '-5', 'x')),
                           ('iterations', ('0', '1001')), ('features', ('1', '99999')), ('seed', ('-1', '1e9'))):
        for value in values:
            yield kind(f'vocab train --{option}={value}', [*train, f'--{option}={value}'], option, 'whole number', 'from')
    yield kind('vocab train without --out', ['vocab', 'train', 'mono/images'], '--out is required')
    yield kind('vocab train over a file', [word for word in train if word != '--overwrite'], 'words.covis-voc', '--overwrite')
    yield kind('vocab convert over a file', ['vocab', 'convert', 'words.txt', 'out/words.covis-voc'], 'words.covis-voc', '--overwrite')
    synth = ['synth', 'room', '--quiet', '--out', 'made']
    for option, values in (('frames', ('-1', '1e9', '2000000')), ('width', ('10', '100000', '320.5')), ('height', ('0', '-240')),
                           ('fps', ('-1', 'nan', '1e9')),
                           ('seed', ('-1', '2147483648')), ('focal', ('-1', 'inf')), ('noise', ('-1', '51')), ('baseline', ('-1', '11')),
                           ('depth-noise', ('-1', 'x')),
                           ('exposure', ('-1', '0.95')), ('blur', ('-1', '101')), ('distortion', ('-1', '2')), ('right-gain', ('0', '11')),
                           ('right-offset', ('201',)),
                           ('way', ('-1', '1e9')), ('light', ('-1', '0.5'))):
        for value in values:
            yield kind(f'synth --{option}={value}', [*synth, f'--{option}={value}'], option.replace('-', '[-_]'), 'must be', 'from')
    yield kind('synth an unknown world', ['synth', 'mars', *synth[2:]], 'mars', 'room')
    yield kind('synth an unknown sensor', [*synth, '--sensor', 'sonar'], 'sonar', 'mono')
    yield kind('synth a distorted pair', [*synth, '--sensor', 'stereo', '--distortion', '1'], 'distortion', 'stereo')
    yield kind('synth a longer way round the room', [*synth, '--way', '500'], 'way', 'street')
    yield kind('synth without --out', ['synth', 'room'], '--out is required')
    yield kind('synth into a folder that holds things', [*synth[:-1], 'out'], 'out', 'not empty', '--overwrite')


def map_commands():
    prune = ['map', 'prune', 'office.m', '--out', 'out/office.m']
    yield kind('map prune without a budget', prune, 'key-frames', 'points')
    for value in ('0', '-3', 'nan', '2.5', '9999999999999'):
        yield kind(f'map prune --key-frames={value}', [*prune, f'--key-frames={value}'], '--key-frames', '1')
        yield kind(f'map prune --points={value}', [*prune, f'--points={value}'], '--points', '1')
    split = ['map', 'split', 'office.m', '--out', 'out']
    for value in ('1,2,3', '1,2,3,4,5', 'a,b,c,d', '1,2,3,nan', '0,0,0,-1', '0,0,0,0', '0,0,0,inf', '0;0;0;1'):
        yield kind(f'map split --around {value}', [*split, '--around', value], '--around', 'number|radius|greater|positive')
    for value in ('1,2,3', '0,0,0,1,1', '0,0,0,1,1,nan', ''):
        yield kind(f'map split --box {value}', [*split, '--box', value], '--box')
    yield kind('map split where nothing is', [*split, '--around', '1000,1000,1000,1'], 'area 0|area0', 'no key frame|nothing|empty')
    yield kind('map merge of one file', ['map', 'merge', 'office.m', '--out', 'out/office.m'], 'office.m|FILES', 'two|2|several')
    yield kind('map merge of a file twice', ['map', 'merge', 'office.m', 'office.m', '--out', 'out/office.m'], 'office.m: given twice')
    yield kind('map merge over its input', ['map', 'merge', 'office.m', 'mono.m', '--out', 'mono.m'], 'mono.m', '--out')
    yield kind('map merge with an unknown setting', ['map', 'merge', 'office.m', 'mono.m', '--out', 'out/office.m', '--set', 'loop.min_fuond=3'],
               'min_fuond', 'min_found')
    yield kind('map merge with a setting of tracking', ['map', 'merge', 'office.m', 'mono.m', '--out', 'out/office.m', '--set',
                                                        'tracker.min_inliers=30'], 'tracker.min_inliers')
    yield kind('map merge without --out', ['map', 'merge', 'office.m', 'mono.m'], '--out is required')
    yield kind('map prune over its input', ['map', 'prune', 'office.m', '--key-frames', '2', '--out', 'office.m'], 'office.m', '--out')
    export = ['map', 'export', 'office.m', '--out', 'out/exported']
    yield kind('map export without --to', export, '--to is required')
    yield kind('map export to an unknown format', [*export, '--to', 'obj'], 'obj', 'colmap')
    yield kind('map export to GeoJSON without its origin', [*export, '--to', 'geojson'], '--origin', 'LATITUDE')
    for value in (['91', '0'], ['nan', '0'], ['0', '181'], ['x', '0'], ['0']):
        yield kind(f'map export --origin {" ".join(value)}', [*export, '--to', 'geojson', '--origin', *value], '--origin')
    yield kind('map export --heading 400', [*export, '--to', 'geojson', '--origin', '50', '8', '--heading', '400'], '--heading', '360')
    yield kind('map export --heading nan', [*export, '--to', 'geojson', '--origin', '50', '8', '--heading', 'nan'], '--heading')
    yield kind('map export --scale 0', [*export, '--to', 'geojson', '--origin', '50', '8', '--scale', '0'], '--scale')
    yield kind('map export --scale nan', [*export, '--to', 'geojson', '--origin', '50', '8', '--scale', 'nan'], '--scale')
    yield kind('map export to nerfstudio without images', [*export, '--to', 'nerfstudio'], 'office.m.images', 'images')
    yield kind('map export with images that are not there', [*export, '--to', 'colmap', '--images', 'gone'], 'gone')
    yield kind('map import without --images', ['map', 'import', 'colmap/sparse/0', '--out', 'out/office.m'], '--images is required')
    for value in ('10', '40000', 'x'):
        yield kind(f'map import --features {value}', ['map', 'import', 'colmap/sparse/0', '--images', 'rgbd/rgb', '--out', 'out/office.m',
                                                      '--features', value], '--features')
    yield kind('map info --picture in a folder that is not there', ['map', 'info', 'office.m', '--picture', 'gone/picture.png'], 'gone')


def view_options():
    yield kind('view of nothing', ['view', 'gone'], 'gone', 'result folder|map')
    yield kind('view of a folder without a result', ['view', 'rgbd'], 'rgbd', 'covis run')
    yield kind('view of a text', ['view', 'truth.txt'], 'truth.txt')
    for value in ('70000', '-1', 'x'):
        yield kind(f'view --port={value}', ['view', 'office.m', f'--port={value}'], '--port', '65535')
    for value in ('999.1.1.1', 'no.such.host.invalid', '', '203.0.113.7'):
        yield kind(f'view --host {value}', ['view', 'office.m', '--port', '0', '--host', value], value or '--host')
    yield kind('run --view-host 999.1.1.1', run('rgbd', '--view=0', '--view-host', '999.1.1.1'), '999.1.1.1')
