# SPDX-License-Identifier: Apache-2.0
"""Recordings of each kind whose lists, folders or calibration are wrong."""
from .kinds import (Kind, both, change, column, copy, cut, empty, fifo, files_like, folder_at, large, line, link, locked, patch, remove, rename,
                    replace, run, write)
from .material import FRAMES, ORIGIN

# Nine lists, each of nine times the one before: 387 million numbers.
BOMB = ('a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n' + ''.join(f'{name}: &{name} [{", ".join(["*" + before] * 9)}]\n' for before,
                                                        name in zip('abcdefgh', 'bcdefghi'))).encode()


def kinds():
    return [*folders(), *tum(), *icl(), *openloris(), *kitti(), *euroc(), *tartanair(), *open3d(), *image_folders()]


def kind(group, recording, name, damage, *says, words=(), **more):
    return Kind(group, name, run(recording, *words), list(says), damage, **more)


def folders():
    for name, damage, *says in (('an empty folder', both(remove('rgbd'), folder_at('rgbd')), 'rgbd: it is no recording', 'It is empty'),
                                ('a folder of texts', both(remove('rgbd'), write('rgbd/notes.txt', 'x')), 'rgbd: it is no recording', 'notes.txt'),
                                ('the folder above', both(rename('rgbd', 'a'), folder_at('rgbd'), rename('a', 'rgbd/one')),
                                 'rgbd: it is no recording', 'rgbd/one looks like a recording'),
                                ('a link to nothing', both(remove('rgbd'), link('rgbd', 'gone')), 'rgbd: it does not exist'),
                                ('a link to itself', both(remove('rgbd'), link('rgbd', 'rgbd')), 'rgbd', 'does not exist|symbolic links'),
                                ('a pipe', fifo('rgbd'), 'rgbd', 'regular file'), ('/dev/zero', link('rgbd', '/dev/zero'), 'rgbd', 'regular file'),
                                ('an empty file', both(remove('rgbd'), empty('rgbd')), 'rgbd', 'video|empty'),
                                ('a text file', both(remove('rgbd'), write('rgbd', 'hello\n' * 50)), 'rgbd', 'video')):
        yield kind('folders', 'rgbd', name, damage, *says)
    yield kind('folders', 'rgbd', 'a folder that may not be read', locked('rgbd'), 'rgbd', 'Permission denied', as_nobody=True)
    yield kind('folders', 'rgbd', 'a list that may not be read', locked('rgbd/associations.txt'), 'associations.txt', 'Permission denied',
               as_nobody=True)
    yield kind('folders', 'rgbd', 'images that may not be read', files_like('rgbd/rgb/*', locked), 'no frame could be read', 'Permission denied',
               as_nobody=True)
    yield kind('folders', 'image/first.png', 'a single image, which is a video of one frame', None, 'first.png', 'no frame was tracked',
               words=('--camera', 'mono.yaml'), changes=('out',))
    yield kind('folders', 'office.m', 'a map', None, 'office.m', 'video', words=('--camera', 'mono.yaml'))


def wrong_lists(group, recording, name, first, stamp_column=1, file_column=2):
    """What can be wrong with a list of stamps and files. first: the number of its first row."""
    path = f'{recording}/{name}'
    row = first + 3
    for what, damage, *says in (
            ('it is gone', remove(path), name.replace('.', r'\.')), ('it is empty', empty(path), 'no file is listed'),
            ('comments alone', write(path, '# stamp file\n' * 3), 'no file is listed'),
            ('a row of one column', line(path, row, '0.375'), f':{row}:', 'stamp and file name'),
            ('a row of seven columns', line(path, row, '1 2 3 4 5 6 7'), f':{row}:', 'stamp and file name'),
            ('a stamp that is nan', column(path, row, stamp_column, 'nan'), f':{row}:', 'nan', 'stamp in seconds'),
            ('a stamp that is a word', column(path, row, stamp_column, 'noon'), f':{row}:', 'noon', 'stamp in seconds'),
            ('a stamp that is infinite', column(path, row, stamp_column, '1e999'), f':{row}:', '1e999', 'stamp in seconds'),
            ('a stamp beyond 64 bits', column(path, row, stamp_column, '1e300'), f':{row}:', '1e300', 'stamp in seconds'),
            ('a stamp like a date', column(path, row, stamp_column, '2026-11-25'), f':{row}:', 'stamp in seconds'),
            ('binary', write(path, bytes(range(256)) * 20), ':1:|no file is listed', 'stamp|listed'),
            ('zeros', write(path, bytes(1000)), ':1:', 'stamp'),
            ('a line of 1,000,000 characters', line(path, row, 'x' * 1000000), f':{row}:', 'stamp and file name'),
            ('a stamp of 100,000 digits', column(path, row, stamp_column, 'x' * 100000), f':{row}:', 'stamp in seconds'),
            ('an escape for the terminal', column(path, row, stamp_column, '\x1b[2J'), f':{row}:', 'stamp in seconds'),
            ('a folder', folder_at(path), 'folder', 'file is expected'), ('a pipe', fifo(path), 'pipe', 'regular file'),
            ('/dev/zero', link(path, '/dev/zero'), 'device', 'regular file'),
            ('2 GiB', large(path, 1 << 31), 'MiB')):
        if what != 'it is gone':  # the folder is another kind of recording then
            yield kind(group, recording, f'{name}: {what}', damage, recording, *says)
    for what, file, *says in (('a folder', '.', 'folder|regular'), ('a file that is gone', 'gone.png', 'gone.png', 'missing'),
                              ('an absolute path that is gone', '/gone/x.png', '/gone/x.png', 'missing')):
        if what != 'a folder':
            yield kind(group, recording, f'{name}: names {what}', column(path, row, file_column, file), *says, '--skip-bad')
            yield kind(group, recording, f'{name}: names {what}, --skip-bad', column(path, row, file_column, file), *says[:1], '1 of 12',
                       words=('--skip-bad',), passed_over=True,
                       unreadable=0)
    for what, file, *says in (('a folder', '.', 'folder|regular'), ('a pipe', 'pipe.png', 'regular file'), ('/dev/zero', '/dev/zero', 'regular file'),
                              ('a device out of the folder', '../../../../../../dev/zero', 'regular file'), ('a text', name, 'image|decode'),
                              ('/etc/passwd', '/etc/passwd', 'image|decode'),
                              ('a name of 300 characters', 'x' * 300, 'too long')):
        damage = both(fifo(f'{recording}/pipe.png'), column(path, row, file_column, file))
        if 'too long' in says:
            yield kind(group, recording, f'{name}: names {what}', damage, *says)
        else:
            yield kind(group, recording, f'{name}: names {what}', damage, *says, passed_over=True, unreadable=1)


def wrong_stamps(group, recording, damage_of, **more):
    """Stamps that are numbers, but not those of a recording. damage_of(row, stamp): row counts from 0."""
    for what, row, stamp, *says in (('one that repeats', 4, 3, 'later than', '--skip-bad'), ('one that goes back', 6, 1, 'later than', '--skip-bad'),
                                    ('one far away', 11, 1e13, 'stamp', 'far|seconds|in 64')):
        yield kind(group, recording, f'stamps: {what}', damage_of(row, stamp), *says, **more)
    yield kind(group, recording, 'stamps: one that goes back, --skip-bad', damage_of(6, 1), '1 of 12', 'left out',
               words=(*more.get('words', ()), '--skip-bad'), passed_over=True, unreadable=0)


def tum():
    yield from wrong_lists('TUM', 'rgbd', 'associations.txt', 2)
    rows = [(k / 8, f'rgb/{k / 8:.9f}.png {k / 8:.9f} depth/{k / 8:.9f}.png') for k in range(FRAMES)]

    def listed(stamps):
        return write('rgbd/associations.txt', ''.join(f'{stamp:.9f} {rest}\n' for stamp, (_, rest) in zip(stamps, rows)))

    def with_stamp(row, stamp):
        stamps = [t for t, _ in rows]
        stamps[row] = stamp if stamp > 100 else stamps[stamp]
        return listed(stamps)
    yield from wrong_stamps('TUM', 'rgbd', with_stamp)
    yield kind('TUM', 'rgbd', 'stamps: all the same', listed([1.0] * FRAMES), 'later than', '11 of 12', '--skip-bad')
    yield kind('TUM', 'rgbd', 'stamps: all descending', listed([10 - k for k in range(FRAMES)]), 'later than', '11 of 12', '--skip-bad')
    without = remove('rgbd/associations.txt')
    yield kind('TUM', 'rgbd', 'depth.txt is gone', both(without, remove('rgbd/depth.txt')), 'depth.txt|depth', words=('--sensor', 'rgbd'))
    yield kind('TUM', 'rgbd', 'depth.txt is empty', both(without, empty('rgbd/depth.txt')), 'depth.txt', 'no file is listed')
    yield kind('TUM', 'rgbd', 'rgb.txt is empty', both(without, empty('rgbd/rgb.txt')), 'rgb.txt', 'no file is listed')
    yield kind('TUM', 'rgbd', 'depth.txt of another time', both(without, change('rgbd/depth.txt',
                                                                                lambda data: data.replace(b'\n0.', b'\n77.').replace(b'\n1.', b'\n78.'))),
               'depth.txt', 'stamp|20 ms|pair')
    yield kind('TUM', 'rgbd', 'the folder of images is gone', remove('rgbd/rgb'), 'rgbd/rgb/0.000000000.png', '12 of 12')
    yield kind('TUM', 'rgbd', 'the folder of depth is gone', remove('rgbd/depth'), 'rgbd/depth/0.000000000.png', '12 of 12')
    yield kind('TUM', 'rgbd', 'one image is gone', remove('rgbd/rgb/0.250000000.png'), 'rgb/0.250000000.png', 'missing', '1 of 12', '--skip-bad')
    yield kind('TUM', 'rgbd', 'one depth image is gone', remove('rgbd/depth/0.250000000.png'), 'depth/0.250000000.png', 'missing', '1 of 12',
               '--skip-bad')
    yield kind('TUM', 'rgbd', 'one depth image is gone, --skip-bad', remove('rgbd/depth/0.250000000.png'), '1 of 12', words=('--skip-bad',),
               passed_over=True, unreadable=0)
    yield kind('TUM', 'rgbd', 'an image is a link to itself', link('rgbd/rgb/0.250000000.png', '0.250000000.png'), '0.250000000.png',
               'missing|symbolic')
    yield kind('TUM', 'rgbd', 'images and depth are swapped', both(rename('rgbd/rgb', 'rgbd/x'), rename('rgbd/depth', 'rgbd/rgb'),
                                                                   rename('rgbd/x', 'rgbd/depth')), 'no frame could be read', 'depth', '16 bits')
    yield kind('TUM', 'rgbd', 'the truth is binary', write('rgbd/groundtruth.txt', bytes(range(256))), 'groundtruth.txt', passed_over=True)
    yield kind('TUM', 'rgbd', 'the truth is a pipe', fifo('rgbd/groundtruth.txt'), 'groundtruth.txt', 'regular file', passed_over=True)
    yield kind('TUM', 'rgbd', 'the truth has a wrong row', line('rgbd/groundtruth.txt', 3, '0.25 1 2 3'), 'groundtruth.txt:3', '4 columns',
               passed_over=True)
    for index, command in enumerate((['check', 'rgbd', '--out', 'out/picture.png'],
                                     ['localize', 'rgbd', '--map', 'office.m', '--out', 'out/found.txt'])):
        yield Kind('TUM', f'a wrong row, {command[0]}', command, ['associations.txt:5:', 'stamp'], line('rgbd/associations.txt', 5, 'x y z u'),
                   needs=('out',))
        yield Kind('TUM', f'no list, {command[0]}', command, ['rgbd'],
                   both(*(remove(f'rgbd/{name}.txt') for name in ('associations', 'rgb', 'depth')), remove('rgbd/rgb')), needs=('out',))


def icl():
    for what, damage, *says in (('a stamp that repeats', line('icl/associations.txt', 4, '2 depth/3.png 2 rgb/3.png'), 'later than'),
                                ('depth missing', remove('icl/depth/3.png'), 'depth/3.png', 'missing'),
                                ('a row of three columns', line('icl/associations.txt', 4, '3 depth/3.png 3'), ':4:', 'stamp and file name'),
                                ('negative numbers', change('icl/associations.txt', lambda data: data.replace(b'\n', b'\n-')), ':13:|later'),
                                ('huge numbers', column('icl/associations.txt', 12, 3, '99999999999999999999999'), ':12:', 'stamp'),
                                ('no camera file, so that 640x480 is assumed', remove('icl/camera.yaml'), '320x240', '640x480')):
        yield kind('ICL-NUIM', 'icl', what, damage, *says)
    for what, damage, *says in (('a truth of five columns', line('icl/room.gt.freiburg', 2, '1 2 3 4 5'), 'room.gt.freiburg:2', '5 columns'),
                                ('an empty truth', empty('icl/room.gt.freiburg'), 'no pose'),
                                ('two truths', copy('icl/room.gt.freiburg', 'icl/other.gt.freiburg'), '2 files end in .gt.freiburg')):
        yield kind('ICL-NUIM', 'icl', what, damage, *says, passed_over=True)


def openloris():
    yield from wrong_lists('OpenLORIS', 'lounge', 'color.txt', 1)
    for what, damage, *says in (('aligned_depth.txt is empty', empty('lounge/aligned_depth.txt'), 'aligned_depth.txt', 'no file is listed'),
                                ('aligned_depth.txt is of another time', change('lounge/aligned_depth.txt',
                                                                                lambda data: data.replace(b'\n15', b'\n16').replace(b'15', b'16', 1)),
                                 'aligned_depth.txt', 'stamp|20 ms|pair|missing'),
                                ('sensors.yaml is gone', remove('lounge/sensors.yaml'), 'sensors.yaml', '--camera'),
                                ('sensors.yaml is empty', empty('lounge/sensors.yaml'), 'sensors.yaml', 'd400_color'),
                                ('sensors.yaml is a list', write('lounge/sensors.yaml', '- 3\n'), 'sensors.yaml', 'd400_color'),
                                ('sensors.yaml is no YAML', write('lounge/sensors.yaml', 'a: [\n'), 'sensors.yaml:', 'not YAML'),
                                ('a camera of itself', write('lounge/sensors.yaml',
                                                             'd400_color: &a\n  width: 320\n  height: 240\n  intrinsics: &b [*b]\n'), 'sensors.yaml',
                                 'intrinsics|itself'),
                                ('no width', replace('lounge/sensors.yaml', '  width: 320\n', ''), 'sensors.yaml', 'width'),
                                ('a width that is nan', replace('lounge/sensors.yaml', '320', 'nan'), 'sensors.yaml:', 'width', 'finite'),
                                ('a width of 1e9', replace('lounge/sensors.yaml', '320', '1e9'), 'sensors.yaml', 'width'),
                                ('a width of 320.5', replace('lounge/sensors.yaml', '320', '320.5'), 'sensors.yaml', 'width|320x240'),
                                ('two intrinsics', replace('lounge/sensors.yaml', '[250, 159.5, 250, 119.5]', '[250, 159.5]'), 'sensors.yaml:',
                                 'intrinsics', '4'),
                                ('negative focal lengths', replace('lounge/sensors.yaml', '[250, 159.5, 250, 119.5]', '[-250, 159.5, -250, 119.5]'),
                                 'sensors.yaml', 'focal'),
                                ('an unknown lens', both(replace('lounge/sensors.yaml', 'none', 'fov'),
                                                         replace('lounge/sensors.yaml', '[0, 0, 0', '[1, 0, 0')), 'sensors.yaml', 'fov', '--camera'),
                                ('the fisheye pair', None, 'fisheye', '--sensor')):
        yield kind('OpenLORIS', 'lounge', what, damage, 'lounge', *says, words=('--sensor', 'stereo') if damage is None else ())


def kitti():
    for what, damage, *says in (
            ('image_0 is empty', both(remove('stereo/image_0'), folder_at('stereo/image_0')), 'image_0', 'no image'),
            ('image_1 is empty', both(remove('stereo/image_1'), folder_at('stereo/image_1')), 'image_1', '12 of 12|no image'),
            ('image_0 is a file', both(remove('stereo/image_0'), write('stereo/image_0', 'x')), 'stereo: it is no recording|image_0'),
            ('one right image is gone', remove('stereo/image_1/000003.png'), 'image_1/000003.png', 'missing', '--skip-bad'),
            ('calib.txt is gone', remove('stereo/calib.txt'), 'stereo', 'calib.txt', '--camera'),
            ('calib.txt is empty', empty('stereo/calib.txt'), 'calib.txt', "'P0:' is missing"),
            ('calib.txt without P1', line('stereo/calib.txt', 2, None), 'calib.txt', "'P1:' is missing"),
            ('calib.txt, eleven numbers', line('stereo/calib.txt', 1, 'P0: 250 0 159.5 0 0 250 119.5 0 0 0 1'), 'calib.txt:1', 'P0', '12'),
            ('calib.txt, nan', line('stereo/calib.txt', 1, 'P0: nan 0 159.5 0 0 250 119.5 0 0 0 1 0'), 'calib.txt:1', 'nan', 'finite'),
            ('calib.txt, fx of 0', line('stereo/calib.txt', 1, 'P0: 0 0 159.5 0 0 250 119.5 0 0 0 1 0'), 'calib.txt:1', 'focal', 'positive'),
            ('calib.txt, fx of 1e308', line('stereo/calib.txt', 1, 'P0: 1e308 0 159.5 0 0 250 119.5 0 0 0 1 0'), 'calib.txt', 'fx|focal|P0'),
            ('calib.txt, cameras the wrong way round', change('stereo/calib.txt', lambda data: data.replace(b'-2.75', b'2.75')), 'calib.txt',
             'right of'),
            ('calib.txt, two different cameras', line('stereo/calib.txt', 2, 'P1: 300 0 159.5 -27.5 0 300 119.5 0 0 0 1 0'), 'calib.txt',
             'P0 and P1'),
            ('calib.txt, a skew', line('stereo/calib.txt', 2, 'P1: 250 50 159.5 -27.5 0 250 119.5 0 0 0 1 0'), 'calib.txt:2', 'P1', 'rectified'),
            ('calib.txt, a third row', line('stereo/calib.txt', 2, 'P1: 250 0 159.5 -27.5 0 250 119.5 0 0 0 2 0'), 'calib.txt:2', 'number 11'),
            ('calib.txt, a vertical offset', line('stereo/calib.txt', 2, 'P1: 250 0 159.5 -27.5 0 250 119.5 40 0 0 1 0'), 'calib.txt', 'P1', 'side by side'),
            ('calib.txt in UTF-16', change('stereo/calib.txt', lambda data: data.decode().encode('utf-16')), 'calib.txt', 'UTF-16'),
            ('calib.txt, binary', write('stereo/calib.txt', bytes(range(256))), 'calib.txt', 'P0'),
            ('calib.txt, a pipe', fifo('stereo/calib.txt'), 'calib.txt', 'regular file'),
            ('times.txt, too few', cut('stereo/times.txt', 40), 'times.txt', 'stamps for 12 images'),
            ('times.txt, nan', line('stereo/times.txt', 3, 'nan'), 'times.txt:3', 'nan', 'seconds'),
            ('times.txt, a word', line('stereo/times.txt', 3, 'noon'), 'times.txt:3', 'noon', 'seconds'),
            ('times.txt, empty', empty('stereo/times.txt'), 'times.txt', '0 stamps for 12'),
            ('times.txt, a folder', folder_at('stereo/times.txt'), 'times.txt', 'folder'),
            ('times.txt, descending', change('stereo/times.txt', lambda data: b'\n'.join(reversed(data.split()))), 'later than', '--skip-bad'),
            ('times.txt, repeated', line('stereo/times.txt', 3, '0.125'), 'later than', '--skip-bad'),
            ('times.txt, 1e300', line('stereo/times.txt', 3, '1e300'), 'times.txt:3', 'stamp'),
            ('right images of another size', files_like('stereo/image_1/*', lambda path: copy('image/small.png', path)), 'no frame could be read',
             '64x48', '320x240'),
            ('left images of another size', files_like('stereo/image_0/*', lambda path: copy('image/small.png', path)), '64x48')):
        yield kind('KITTI', 'stereo', what, damage, *says, needs=('image',))
    yield kind('KITTI', 'stereo', 'one right image of another size', copy('image/small.png', 'stereo/image_1/000003.png'), 'frames_unreadable',
               needs=('image',), passed_over=True, unreadable=1)
    yield kind('KITTI', 'stereo', 'no folder of right images', remove('stereo/image_1'), 'image_1', '--sensor mono', words=('--sensor', 'stereo'))
    yield kind('KITTI', 'stereo', 'depth is wanted', None, 'stereo', 'no depth', '--sensor', words=('--sensor', 'rgbd'))
    yield kind('KITTI', 'stereo', 'poses.txt with a wrong row', line('stereo/poses.txt', 2, '1 2 3'), 'poses.txt:2', '3 columns', passed_over=True)


def euroc():
    sensor, rows = 'euroc/mav0/cam0/sensor.yaml', 'euroc/mav0/cam0/data.csv'
    for what, damage, *says in (
            ('cam0 is gone', remove('euroc/mav0/cam0'), 'cam0'), ('cam1 without sensor.yaml', remove('euroc/mav0/cam1/sensor.yaml'),
                                                                  'cam1/sensor.yaml', "can't be opened"),
            ('sensor.yaml is gone', remove(sensor), 'sensor.yaml', '--camera'),
            ('sensor.yaml is empty', empty(sensor), sensor, 'T_BS'), ('sensor.yaml is a list', write(sensor, '- 1\n'), sensor, 'T_BS'),
            ('sensor.yaml is no YAML', write(sensor, 'T_BS: {\n'), sensor + ':', 'not YAML'),
            ('T_BS is gone', replace(sensor, 'T_BS:', 'T_XX:'), sensor, 'T_BS', '16'),
            ('T_BS of 15 numbers', replace(sensor, '[1, 0,', '[0,'), sensor + ':', 'T_BS', '16'),
            ('T_BS with nan', replace(sensor, '[1, 0,', '[nan, 0,'), sensor + ':', 'T_BS', 'finite'),
            ('T_BS is no rotation', replace(sensor, '[1, 0,', '[2, 0,'), sensor, 'T_BS', 'rotation'),
            ('T_BS is a mirror', replace(sensor, '[1, 0,', '[-1, 0,'), sensor, 'T_BS', 'rotation'),
            ('intrinsics that are an anchor bomb', both(replace(sensor, '[250, 250, 159.5, 119.5]', '*i'), change(sensor, lambda data: BOMB + data)),
             sensor + ':', 'intrinsics', 'numbers'), ('T_BS of itself', replace(sensor, 'data: [1, ', 'data: &a [*a, '), sensor, 'T_BS|itself'),
            ('cameras in one place', replace('euroc/mav0/cam1/sensor.yaml', '0.11', '0'), 'sensor.yaml', 'to the right'),
            ('cameras a kilometre apart', replace('euroc/mav0/cam1/sensor.yaml', '0.11', '1e9'), 'sensor.yaml', 'baseline|apart'),
            ('cameras back to back', replace('euroc/mav0/cam1/sensor.yaml', '[1, 0, 0, 0.11, 0, 1, 0, 0, 0, 0, 1, 0',
                                             '[-1, 0, 0, 0.11, 0, 1, 0, 0, 0, 0, -1, 0'), 'sensor.yaml', 'rectif|direction|rotat|turn'),
            ('a resolution of 0', replace(sensor, '[320, 240]', '[0, 240]'), sensor + ':', 'resolution', 'whole numbers'),
            ('a resolution of 1e9', replace(sensor, '[320, 240]', '[1e9, 240]'), sensor + ':', 'resolution', 'whole numbers'),
            ('a resolution of one number', replace(sensor, '[320, 240]', '[320]'), sensor + ':', 'resolution', '2'),
            ('intrinsics with nan', replace(sensor, '[250, 250,', '[nan, 250,'), sensor + ':', 'intrinsics', 'finite'),
            ('three intrinsics', replace(sensor, '[250, 250,', '[250,'), sensor + ':', 'intrinsics', '4'),
            ('a negative focal length', replace(sensor, '[250, 250,', '[-250, 250,'), sensor, 'fx|focal'),
            ('intrinsics of 1e308', replace(sensor, '[250, 250,', '[1e308, 250,'), sensor, 'fx|focal'),
            ('an unknown lens', replace(sensor, 'radial-tangential', 'fov'), sensor, 'fov', 'equidistant'),
            ('two coefficients', replace(sensor, '[0.0, 0.0, 0.0, 0.0]', '[0.0, 0.0]'), sensor + ':', 'distortion_coefficients', '4'),
            ('coefficients of 1e308', replace(sensor, '[0.0, 0.0, 0.0, 0.0]', '[1e308, 0, 0, 0]'), sensor, 'distortion|coefficient|lens'),
            ('data.csv is empty', empty(rows), rows, 'no image is listed'), ('data.csv is binary', write(rows, bytes(range(256))), rows + ':1',
                                                                             'stamp'),
            ('data.csv with a stamp that is nan', line(rows, 4, 'nan,x.png'), rows + ':4', 'stamp'),
            ('data.csv with a row of one column', line(rows, 4, str(ORIGIN)), rows + ':4', 'file name'),
            ('data.csv with a huge stamp', line(rows, 4, '9' * 30 + ',x.png'), rows + ':4', 'stamp'),
            ('data.csv that repeats a stamp', line(rows, 4, f'{ORIGIN},{ORIGIN}.png'), rows + ':4', 'later', '--skip-bad'),
            ('data.csv is a folder', folder_at(rows), rows, 'folder'), ('data.csv is a pipe', fifo(rows), rows, 'regular file'),
            ('neither data.csv nor images', both(remove(rows), remove('euroc/mav0/cam0/data')), 'cam0', 'neither data.csv'),
            ('none of the images is there', remove('euroc/mav0/cam0/data'), 'cam0', 'none of the images'),
            ('right images of another time', change('euroc/mav0/cam1/data.csv', lambda data: data.replace(b'150', b'160')), 'mav0', 'same stamp'),
            ('all right images gone', remove('euroc/mav0/cam1/data'), 'cam1/data', '12 of 12')):
        yield kind('EuRoC', 'euroc', what, damage, *says)
    yield kind('EuRoC', 'euroc', 'one image is gone', remove(f'euroc/mav0/cam0/data/{ORIGIN + 10**9 // 8}.png'), '1 of 12 images', 'missing',
               passed_over=True)
    yield kind('EuRoC', 'euroc', 'depth is wanted', None, 'no depth', '--sensor', words=('--sensor', 'rgbd'))
    yield kind('EuRoC', 'euroc', 'no right camera', remove('euroc/mav0/cam1'), 'cam1', '--sensor mono', words=('--sensor', 'stereo'))


def tartanair():
    depth = 'tartan/depth_left/000003_left_depth.npy'
    for what, damage, *says in (
            ('image_left is empty', both(remove('tartan/image_left'), folder_at('tartan/image_left')), 'image_left', 'no image'),
            ('a name without a number', rename('tartan/image_left/000003_left.png', 'tartan/image_left/x_left.png'), 'x_left.png', "'_left'"),
            ('a name with a huge number', rename('tartan/image_left/000003_left.png', 'tartan/image_left/99999999999999999999_left.png'), '_left.png',
             'number'), ('one depth file is gone', remove(depth), '000003_left_depth.npy', 'missing', '--skip-bad'),
            ('all depth files are gone', both(remove('tartan/depth_left'), folder_at('tartan/depth_left')), 'depth_left', '12 of 12'),
            ('two names with one number', copy('tartan/image_left/000003_left.png', 'tartan/image_left/0003_left.png'),
             'later than|missing|twice|same')):
        yield kind('TartanAir', 'tartan', what, damage, *says)
    yield kind('TartanAir', 'tartan', 'no folder of depth', remove('tartan/depth_left'), 'depth_left', '--sensor', words=('--sensor', 'rgbd'))
    yield kind('TartanAir', 'tartan', 'no folder of right images', None, 'image_right', '--sensor', words=('--sensor', 'stereo'))
    yield kind('TartanAir', 'tartan', 'a truth with a wrong row', line('tartan/pose_left.txt', 3, '1 2 3'), 'pose_left.txt:3', '3 columns',
               passed_over=True)
    for what, damage, *says in (
            ('is empty', empty(depth), 'NumPy'), ('is cut short', cut(depth, 0.5), 'cut short'),
            ('is cut within its header', cut(depth, 40), 'header'), ('has one byte more', change(depth, lambda data: data + b'x'), 'bytes of data'),
            ('is a text', write(depth, 'hello'), 'NumPy'),
            ('has doubles', replace(depth, '<f4', '<f8'), 'descr', '<f4'), ('is big-endian', replace(depth, '<f4', '>f4'), 'descr', '<f4'),
            ('has objects', replace(depth, "'<f4'", "'|O' "), 'descr', '<f4'), ('is in the order of Fortran', replace(depth, 'False', 'True '),
                                                                                'fortran_order', 'False'),
            ('has another shape', replace(depth, '(240, 320)', '(320, 240)'), '240x320', '320x240'),
            ('has three dimensions', replace(depth, '(240, 320)', '(2, 3, 4) '), 'shape', 'rows'),
            ('has a negative shape', replace(depth, '(240, 320)', '(-240, 32)'), 'shape', 'rows'),
            ('has a huge shape', replace(depth, '(240, 320)', '(99999, 9)'), 'shape', 'at most'),
            ('is of version 9', patch(depth, 6, b'\x09'), 'version'), ('has a header of 65535 bytes', patch(depth, 8, b'\xff\xff'), 'header'),
            ('is a folder', folder_at(depth), 'folder'),
            ('is a pipe', fifo(depth), 'regular file')):
        yield kind('TartanAir', 'tartan', f'one depth file {what}', damage, *says, passed_over=True, unreadable=1)


def open3d():
    camera = 'open3d/camera_intrinsic.json'
    for what, damage, *says in (
            ('no calibration', remove(camera), 'camera_intrinsic.json', '--camera'), ('calibration is empty', empty(camera), camera, 'JSON'),
            ('calibration is a list', write(camera, '[]'), camera, 'JSON|object'), ('calibration is cut', cut(camera, 0.5), camera, 'JSON'),
            ('calibration of other images', replace(camera, '320', '640'), '320x240', '640x240'),
            ('a width that is a word', replace(camera, '320', '"wide"'), camera, 'width', 'pixels'),
            ('a width of 1e9', replace(camera, '320', '1000000000'), camera, 'width', 'pixels'),
            ('a matrix of eight', replace(camera, '[250, 0', '[250'), camera, 'intrinsic_matrix', 'nine'),
            ('a matrix of words', replace(camera, '[250, 0', '["a", 0'), camera, 'intrinsic_matrix', 'nine'),
            ('a matrix by rows', replace(camera, '0, 0, 0, 250, 0, 159.5, 119.5, 1', '0, 159.5, 0, 250, 119.5, 0, 0, 1'), camera, 'intrinsic_matrix',
             'columns'),
            ('a focal length of 0', replace(camera, '[250, 0', '[0, 0'), camera, 'intrinsic_matrix', 'focal'),
            ('calibration nested 100,000 deep', write(camera, '[' * 100000), camera, 'JSON'),
            ('calibration is a folder', folder_at(camera), camera, 'folder'),
            ('depth has other names', files_like('open3d/depth/*', lambda path: rename(path, path.replace('depth/', 'depth/d'))), 'open3d/depth',
             'name of an image'),
            ('stamps for half of the images', write('open3d/times.txt', '1\n2\n3\n'), 'times.txt', '3 stamps for 12 images')):
        yield kind('Open3D', 'open3d', what, damage, *says)
    yield kind('Open3D', 'open3d', 'one depth image is gone', remove('open3d/depth/000003.png'), '1 of 12 images', passed_over=True)
    yield kind('Open3D', 'open3d', 'no depth image', remove('open3d/depth'), 'color', 'depth', words=('--sensor', 'rgbd'))
    yield kind('Open3D', 'open3d', 'a pair is wanted', None, 'no stereo', '--sensor', words=('--sensor', 'stereo'))


def image_folders():
    times = 'mono/times.txt'
    for what, damage, *says in (
            ('no image', remove('mono/images'), 'mono'), ('an empty folder of images', both(remove('mono/images'), folder_at('mono/images')),
                                                          'mono: it is no recording', 'images'),
            ('too few stamps', line(times, 2, None), 'times.txt', 'stamps for 12 images'),
            ('too many stamps', change(times, lambda data: data + b'99\n'), 'times.txt', '13 stamps for 12'),
            ('no stamps', empty(times), 'times.txt', 'stamps'), ('a stamp that is nan', line(times, 3, 'nan'), 'times.txt:3', 'nan', 'seconds'),
            ('a stamp that is a word', line(times, 3, '12:30'), 'times.txt:3', '12:30', 'seconds'),
            ('stamps that descend', change(times, lambda data: b'\n'.join(reversed(data.split()))), 'later than', '11 of 12'),
            ('stamps that are equal', write(times, '5\n' * 12), 'later than', '11 of 12'),
            ('a stamp of 1e300', line(times, 3, '1e300'), 'times.txt:3', 'seconds'),
            ('stamps are binary', write(times, bytes(range(256))), 'times.txt:1', 'seconds'),
            ('stamps are a folder', folder_at(times), 'times.txt', 'folder'),
            ('stamps are a pipe', fifo(times), 'times.txt', 'regular file'), ('all images of another size',
                                                                              files_like('mono/images/*', lambda path: copy('image/small.png', path)),
                                                                              '64x48', '320x240')):
        yield kind('images', 'mono', what, damage, *says, needs=('image',))
    yield kind('images', 'mono', 'a pair is wanted', None, '--sensor mono', words=('--sensor', 'stereo'))
    yield kind('images', 'mono', 'depth is wanted', None, '--sensor mono', words=('--sensor', 'rgbd'))
