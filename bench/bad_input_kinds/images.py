# SPDX-License-Identifier: Apache-2.0
"""Images that can't be read, one of a recording; videos and bags."""
import struct
import zlib

from . import formats
from .kinds import (Kind, append, both, change, copy, cut, empty, fifo, files_like, folder_at, large, link, patch, remove, rename, replace, run,
                    write, zero)

IMAGE, DEPTH = 'rgbd/rgb/0.500000000.png', 'rgbd/depth/0.500000000.png'


def kinds():
    return [*one_image(), *other_formats(), *depth(), *all_images(), *videos(), *bags_of_ros2(), *bags_of_ros1()]


def header(**fields):
    """Changes fields of a PNG's header, and mends its checksum."""
    def changed(data):
        names = ('width', 'height', 'depth', 'colour', 'compression', 'filter', 'interlace')
        values = dict(zip(names, struct.unpack('>IIBBBBB', data[16:29])))
        head = struct.pack('>IIBBBBB', *{**values, **fields}.values())
        return data[:8] + formats.png_chunk(b'IHDR', head) + data[33:]
    return lambda path: change(path, changed)


# Lines that decoders write by themselves where only decoding shows that data are wrong.
PNG_NOISE, OPENCV_NOISE, AVI_NOISE = '^libpng (error|warning): ', r"^imdecode_\(''\): |^$", '^Unexpected element'


def one_bad(group, name, path, damage, *says, needs=('image',), recording='rgbd', noise=''):
    return Kind(group, name, run(recording), [path.rsplit('/', 1)[-1].replace('.', r'\.'), *says], damage, needs=needs, passed_over=True,
                unreadable=1, noise=noise)


DAMAGES = (('is empty', empty), ('is cut after 2 bytes', lambda p: cut(p, 2)), ('is cut within its header', lambda p: cut(p, 20)),
           ('is cut at a tenth', lambda p: cut(p, 0.1)), ('is cut in the middle', lambda p: cut(p, 0.5)),
           ('is cut near its end', lambda p: cut(p, 0.97)), ('is all zeros', lambda p: zero(p, 0, 1)),
           ('has zeros in its middle', lambda p: zero(p, 0.4, 0.6)), ('has a wrong beginning', lambda p: patch(p, 0, b'XXXX')),
           ('is a text', lambda p: write(p, 'hello\n' * 100)), ('is a folder', folder_at), ('is a pipe', fifo),
           ('is /dev/zero', lambda p: link(p, '/dev/zero')), ('is 2 GiB of nothing', lambda p: large(p, 1 << 31)))


def one_image():
    for name, damage in DAMAGES:
        yield one_bad('images PNG', f'one image {name}', IMAGE, damage(IMAGE))
    for name, fields in (('width of 0', {'width': 0}), ('width of 2^31 - 1', {'width': 2**31 - 1}),
                         ('30000 x 30000 pixels', {'width': 30000, 'height': 30000}), ('a height that is too great', {'height': 2400}),
                         ('a height that is too small', {'height': 24}),
                         ('a depth of 7 bits', {'depth': 7}), ('an unknown kind of colour', {'colour': 5}),
                         ('an unknown compression', {'compression': 9}), ('an unknown interlacing', {'interlace': 7})):
        yield one_bad('images PNG', f'its header says: {name}', IMAGE, header(**fields)(IMAGE), noise=PNG_NOISE if 'a height' in name else '')
    yield one_bad('images PNG', 'a wrong checksum of its header', IMAGE, patch(IMAGE, 29, b'\0\0\0\0'))
    yield one_bad('images PNG', 'a wrong checksum of its data', IMAGE, change(IMAGE, lambda data: data[:-20] + bytes(4) + data[-16:]),
                  noise=PNG_NOISE)
    yield one_bad('images PNG', 'of another size', IMAGE, copy('image/small.png', IMAGE), '64x48', '320x240')
    yield one_bad('images PNG', 'data that unpack to more than the image', IMAGE, write(IMAGE, bomb()), noise=PNG_NOISE)


def bomb():
    head = struct.pack('>IIBBBBB', 320, 240, 8, 0, 0, 0, 0)
    return b'\x89PNG\r\n\x1a\n' + formats.png_chunk(b'IHDR', head) + formats.png_chunk(b'IDAT',
                                                                                       zlib.compress(bytes(1 << 26))[:-9]) + formats.png_chunk(b'IEND', b'')


def other_formats():
    """One image of an image folder in another format, damaged."""
    for ending, kinds_of_damage in (('jpg', range(len(DAMAGES))), ('tif', range(len(DAMAGES))), ('pgm', (0, 1, 2, 3, 4, 5, 6, 8, 9)),
                                    ('bmp', (0, 1, 2, 3, 4, 6, 8, 9))):
        path = f'mono/images/000004.{ending}'
        for index in kinds_of_damage:
            name, damage = DAMAGES[index]
            if name == 'has zeros in its middle' and ending == 'tif':
                continue  # these are pixels like others
            if name in ('is a folder', 'is a pipe', 'is /dev/zero'):  # it is no image of the folder then
                yield Kind(f'images {ending.upper()}', f'one image {name}', run('mono'), ['times.txt', 'stamps for 11 images'],
                           both(first_as(path), damage(path)), needs=('image',))
            else:
                yield one_bad(f'images {ending.upper()}', f'one image {name}', path, both(first_as(path), damage(path)), recording='mono')
    path = 'mono/images/000004.pgm'
    for name, text in (('without a size', b'P5\n'), ('with words for its size', b'P5\nwide high\n255\n'),
                       ('with a negative size', b'P5\n-320 240\n255\n'), ('of 99999999 columns', b'P5\n99999999 99999999\n255\n'),
                       ('with a greatest value of 0', b'P5\n320 240\n0\n' + bytes(76800)),
                       ('with a greatest value of 99999', b'P5\n320 240\n99999\n' + bytes(76800)),
                       ('in words that end early', b'P2\n320 240\n255\n1 2 3'),
                       ('in words that are none', b'P2\n320 240\n255\n' + b'x ' * 76800)):
        yield one_bad('images PGM', name, path, both(remove('mono/images/000004.png'), write(path, text)), recording='mono',
                      noise=OPENCV_NOISE if 'that are none' in name else '')
    for offset, value, name in ((4, b'\xff\xff\xff\xff', 'its directory far away'), (0, b'MM', 'its bytes in the other order'),
                                (2, b'\x63', 'an unknown version')):
        path = 'mono/images/000004.tif'
        yield one_bad('images TIF', f'with {name}', path, both(first_as(path), patch(path, offset, value)), recording='mono')
    for name, old, new in (('with a width of 0', b'\0\1\3\0\1\0\0\0\x40\1', b'\0\1\3\0\1\0\0\0\0\0'),
                           ('with a width of 65535', b'\0\1\3\0\1\0\0\0\x40\1', b'\0\1\3\0\1\0\0\0\xff\xff'),
                           ('with 3 bits a pixel', b'\2\1\3\0\1\0\0\0\x08', b'\2\1\3\0\1\0\0\0\x03'),
                           ('with an unknown compression', b'\3\1\3\0\1\0\0\0\1', b'\3\1\3\0\1\0\0\0\x63'),
                           ('with its pixels far away', b'\x11\1\4\0\1\0\0\0\x08\0\0\0', b'\x11\1\4\0\1\0\0\0\xff\xff\xff\x7f')):
        yield one_bad('images TIF', name, 'mono/images/000004.tif', both(first_as('mono/images/000004.tif'),
                                                                         replace('mono/images/000004.tif', old, new)), recording='mono')
    path = 'mono/images/000004.jpg'
    for name, old, new in (('of 65535 x 65535 pixels', b'\x08\0\xf0\x01\x40', b'\x08\xff\xff\xff\xff'),
                           ('of 0 columns', b'\x08\0\xf0\x01\x40', b'\x08\0\xf0\0\0'), ('of 12 bits', b'\x0b\x08\0\xf0', b'\x0b\x0c\0\xf0'),
                           ('of a kind that is not read', b'\xff\xc0', b'\xff\xc3'), ('without its end', b'\xff\xd9', b'')):
        yield one_bad('images JPG', name, path, both(first_as(path), replace(path, old, new)), recording='mono')
    yield one_bad('images JPG', 'a PNG by its name that is cut JPEG', IMAGE, both(copy('image/first.jpg', IMAGE), cut(IMAGE, 0.5)))


def first_as(path):
    return both(remove('mono/images/000004.png'), copy('image/first.' + path.rsplit('.', 1)[-1], path))


def depth():
    for name, damage in DAMAGES:
        yield one_bad('images depth', f'one depth image {name}', DEPTH, damage(DEPTH))
    for name, damage, *says in (('is in colour', copy('image/colour.png', DEPTH), '16 bits'),
                                ('has 8 bits', copy('image/first.png', DEPTH), '16 bits'),
                                ('has another size', copy('image/small.png', DEPTH), '64x48|16 bits'),
                                ('is a JPEG', copy('image/first.jpg', DEPTH), '16 bits'),
                                ('is 16 bits of another size', write(DEPTH, formats.png(64, 48, [bytes(128)] * 48, 16)), '64x48', '320x240')):
        yield one_bad('images depth', f'one {name}', DEPTH, damage, *says)
    yield Kind('images depth', 'all are in colour', run('rgbd'), ['no frame could be read', '16 bits'],
               files_like('rgbd/depth/*', lambda path: copy('image/colour.png', path)), needs=('image',))
    yield Kind('images depth', 'all depth images are black', run('rgbd'), ['rgbd: no frame was tracked', 'depth'],
               files_like('rgbd/depth/*', lambda path: write(path, formats.png(320, 240, [bytes(640)] * 240, 16))), changes=('out',))


def all_images():
    for name, damage in (('are empty', empty), ('are cut', lambda path: cut(path, 0.5)), ('are texts', lambda path: write(path, 'hello'))):
        yield Kind('images all', f'all images {name}', run('mono'), ['mono', 'no frame could be read', 'images/000000.png'],
                   files_like('mono/images/*', damage))
        yield Kind('images all', f'all images {name}, check', ['check', 'mono', '--out', 'out/picture.png'], ['images/000000.png'],
                   files_like('mono/images/*', damage), needs=('out',), on_stdout=True)
        yield Kind('images all', f'all images {name}, localize', ['localize', 'mono', '--map', 'mono.m', '--out', 'out/found.txt'],
                   ['images/000000.png'], files_like('mono/images/*', damage), needs=('out',))
        yield Kind('images all', f'all images {name}, vocab train', ['vocab', 'train', 'mono/images', '--quiet', '--overwrite', '--out',
                                                                     'out/words.covis-voc'], ['mono/images'], files_like('mono/images/*', damage),
                   needs=('out',))
        yield Kind('images all', f'all images {name}, calibrate', ['calibrate', 'mono/images', '--board', '9x6', '--square', '1', '--out',
                                                                   'out/camera.yaml'], ['mono/images'], files_like('mono/images/*', damage),
                   needs=('out',))
    yield Kind('images all', 'all images are white', run('mono'), ['mono: no frame was tracked', 'features'],
               files_like('mono/images/*', lambda path: write(path, formats.png(320, 240, [b'\xff' * 320] * 240))), changes=('out',))
    yield Kind('images all', 'every second image is cut', run('rgbd'), ['frames_unreadable'],
               files_like('rgbd/rgb/*', lambda path: cut(path, 0.5), 2), passed_over=True, unreadable=6)
    yield Kind('images all', 'the first image is cut', run('mono'), ['frames_unreadable'], cut('mono/images/000000.png', 0.5), passed_over=True,
               unreadable=1)
    yield Kind('images all', 'one image is cut, check', ['check', 'rgbd', '--out', 'out/picture.png'], ['0.500000000.png'], cut(IMAGE, 0.5),
               needs=('out',), on_stdout=True, changes=('out/picture.png',))
    yield Kind('images all', 'one image is cut, localize', ['localize', 'rgbd', '--map', 'office.m', '--out', 'out/found.txt'], ['0.500000000.png'],
               cut(IMAGE, 0.5), needs=('out',), passed_over=True)
    yield Kind('images all', 'vocab train from nothing', ['vocab', 'train', 'gone', '--quiet', '--out', 'new.covis-voc'],
               ['gone', 'no such file or folder'])
    yield Kind('images all', 'vocab train from a folder without images', ['vocab', 'train', 'texts', '--quiet', '--out', 'new.covis-voc'],
               ['texts', 'no images'], write('texts/a.txt', 'x'))
    yield Kind('images all', 'vocab train from a pipe', ['vocab', 'train', 'pipe', '--quiet', '--out', 'new.covis-voc'], ['pipe'], fifo('pipe'))
    yield Kind('images all', 'vocab train from white images', ['vocab', 'train', 'white', '--quiet', '--out', 'new.covis-voc'],
               ['descriptors|features'], write('white/a.png', formats.png(320, 240, [b'\xff' * 320] * 240)))


def videos():
    words = ('--camera', 'mono.yaml')
    for name, damage, *says in (('empty', empty('walk.avi'), 'video|empty'), ('cut within its header', cut('walk.avi', 60), 'video'),
                                ('zeros', zero('walk.avi', 0, 1), 'video'), ('a text', write('walk.avi', 'hello\n' * 200), 'video'),
                                ('gone', remove('walk.avi'), 'does not exist'), ('a pipe', fifo('walk.avi'), 'regular file'),
                                ('/dev/zero', link('walk.avi', '/dev/zero'), 'regular file'),
                                ('a playlist that names other files', write('walk.avi', '#EXTM3U\n#EXTINF:1,\n/etc/passwd\n'), 'video'),
                                ('a concat script', write('walk.avi', "ffconcat version 1.0\nfile '/etc/passwd'\n"), 'video'),
                                ('a map', copy('office.m', 'walk.avi'), 'video'), ('binary', write('walk.avi', bytes(range(256)) * 400), 'video')):
        yield Kind('videos', name, run('walk.avi', *words), ['walk.avi', *says], damage, needs=('office.m',), noise=AVI_NOISE)
    yield Kind('videos', 'of another size than the camera file', run('walk.avi', '--camera', 'camera.yaml'), ['walk.avi', '320x240', '640x480'],
               write('camera.yaml', 'width: 640\nheight: 480\nfx: 500\nfy: 500\ncx: 320\ncy: 240\n'))
    yield Kind('videos', 'no camera, and too short to find it', run('walk.avi'), ['walk.avi', 'no camera is given'])
    yield Kind('videos', 'a pair is wanted', run('walk.avi', *words, '--sensor', 'stereo'), ['walk.avi', '--sensor'])
    yield Kind('videos', 'stamps beyond its end', run('walk.avi', *words, '--first', '1000'), ['walk.avi', '1000|no frame'])
    yield Kind('videos', 'cut in the middle, check', ['check', 'walk.avi', *words, '--out', 'out/picture.png'], ['6', '12', 'decoded'], cut('walk.avi', 0.5),
               needs=('out',), on_stdout=True, changes=('out/picture.png',), noise=AVI_NOISE + r'|^\[mjpeg @')


def bags_of_ros2():
    bag, sql = 'office.db3', formats.sql
    for name, damage, *says in (
            ('empty', empty(bag), 'bag'), ('cut within its header', cut(bag, 50), 'bag'), ('cut in the middle', cut(bag, 0.5), 'bag', 'recover'),
            ('zeros behind its header', zero(bag, 0.01, 0.3), 'bag'), ('a text', write(bag, 'hello'), 'bag', 'SQLite'),
            ('gone', remove(bag), 'does not exist'),
            ('a folder without a bag', folder_at(bag), 'bag|recording'), ('a pipe', fifo(bag), 'regular file|bag'),
            ('/dev/zero', link(bag, '/dev/zero'), 'regular file|bag'), ('MCAP', write(bag, b'\x89MCAP0\r\n' + bytes(100)), 'MCAP', 'convert'),
            ('compressed', write(bag, b'\x28\xb5\x2f\xfd' + bytes(100)), 'zstd', 'convert'),
            ('without the table of messages', sql(bag, 'DROP TABLE messages'), 'bag', 'messages'),
            ('without the table of topics', sql(bag, 'DROP TABLE topics'), 'bag', 'topics'),
            ('without a message', sql(bag, 'DELETE FROM messages'), 'message|image|no frame'),
            ('without an image topic', sql(bag, 'DELETE FROM topics WHERE id = 2'), 'image'),
            ('an unknown serialisation', sql(bag, "UPDATE topics SET serialization_format = 'json'"), 'cdr'),
            ('topics of another type', sql(bag, "UPDATE topics SET type = 'std_msgs/msg/String'"), 'image'),
            ('a camera without a message', sql(bag, 'DELETE FROM messages WHERE topic_id = 1'), 'camera_info|--camera'),
            ('a camera that is cut', sql(bag, 'UPDATE messages SET data = substr(data, 1, 60) WHERE topic_id = 1'), 'camera_info'),
            ('a camera of zeros', sql(bag, 'UPDATE messages SET data = zeroblob(400) WHERE topic_id = 1'), 'camera_info'),
            ('an empty camera', sql(bag, "UPDATE messages SET data = x'' WHERE topic_id = 1"), 'camera_info'),
            ('all images cut', sql(bag, 'UPDATE messages SET data = substr(data, 1, 500) WHERE topic_id = 2'), 'image_raw'),
            ('all images empty', sql(bag, "UPDATE messages SET data = x'' WHERE topic_id = 2"), 'image_raw'),
            ('all images of an unknown encoding', sql(bag, "UPDATE messages SET data = replace(data, 'mono8', 'mono9') WHERE topic_id = 2"),
             'image_raw|mono9')):
        yield Kind('bags ROS 2', name, run(bag), [r'office\.db3', *says], damage)
    for name, damage in (('one image is cut', sql(bag, 'UPDATE messages SET data = substr(data, 1, 5000) WHERE id = 6')),
                         ('one image is empty', sql(bag, "UPDATE messages SET data = x'' WHERE id = 6")),
                         ('one image is zeros', sql(bag, 'UPDATE messages SET data = zeroblob(1000) WHERE id = 6')),
                         ('one image has bytes after it', sql(bag, 'UPDATE messages SET data = data || zeroblob(99) WHERE id = 6'))):
        yield Kind('bags ROS 2', name, run(bag), ['frames_unreadable|left out'], damage, passed_over=True)
    for option, topic, *says in (('--topic', '/gone', '/gone', '/camera/image_raw'), ('--topic', '', '--topic|topic'),
                                 ('--right-topic', '/gone', '/gone'), ('--depth-topic', '/gone', '/gone'),
                                 ('--topic', '/camera/camera_info', 'camera_info', '/camera/image_raw')):
        yield Kind('bags ROS 2', f'{option} {topic or "empty"}', run(bag, option, topic), says)
    yield Kind('bags ROS 2', 'depth is wanted', run(bag, '--sensor', 'rgbd'), [r'office\.db3', 'depth'])
    for name, content, *says in (('metadata.yaml is no YAML', 'rosbag2_bagfile_information: [\n', 'metadata.yaml', 'not YAML'),
                                 ('metadata.yaml lists nothing', 'rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n',
                                  'relative_file_paths'),
                                 ('metadata.yaml of an unknown storage', 'rosbag2_bagfile_information:\n  storage_identifier: paper\n',
                                  'metadata.yaml', 'paper', 'sqlite3'), ('metadata.yaml of something else', 'a: 3\n', 'metadata.yaml',
                                                                         'rosbag2_bagfile_information'),
                                 ('metadata.yaml lists a file that is gone',
                                  'rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n  relative_file_paths: [gone.db3]\n', 'gone.db3',
                                  'missing'),
                                 ('metadata.yaml lists a file out of the folder',
                                  'rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n  relative_file_paths: [../camera.yaml]\n',
                                  'camera.yaml', 'bag'),
                                 ('metadata.yaml of a list in a list',
                                  'rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n  relative_file_paths: [[a]]\n', 'metadata.yaml:3',
                                  '.db3')):
        yield Kind('bags ROS 2', name, run('bag'), says, both(lambda folder: (folder / 'bag').mkdir(), rename(bag, 'bag/office.db3'),
                                                              write('bag/metadata.yaml', content)), needs=(bag, 'camera.yaml'))


def bags_of_ros1():
    bag = 'office.bag'
    for name, damage, *says in (('empty', empty(bag), 'bag'), ('cut within its first line', cut(bag, 8), 'bag'),
                                ('cut within its header', cut(bag, 100), 'bag'), ('cut behind its header', cut(bag, 4200), 'bag|index'),
                                ('cut in the middle', cut(bag, 0.5), 'bag|index'),
                                ('cut before its end', cut(bag, 0.999), 'bag|index'), ('of version 1.2', replace(bag, 'V2.0', 'V1.2'), 'version|bag'),
                                ('zeros behind its header', zero(bag, 0.01, 0.5), 'bag|record'), ('a text', write(bag, 'hello\n' * 99), 'ROSBAG'),
                                ('a pipe', fifo(bag), 'regular file|bag'),
                                ('/dev/zero', link(bag, '/dev/zero'), 'regular file|bag'),
                                ('an index that lies elsewhere', change(bag,
                                                                        lambda data: data.replace(b'index_pos=', b'index_pos=\xff\xff\xff',
                                                                                                  1)[:len(data)]), 'bag|index|record'),
                                ('a record of 4 GB', patch(bag, 4109, b'\xff\xff\xff\xff'), 'bag|record'),
                                ('no index, as after a crash', change(bag,
                                                                      lambda data: data.replace(b'index_pos=' + data[data.find(b'index_pos=') + 10:][:8], b'index_pos=' + bytes(8))), 'bag|index'),
                                ('an unknown compression', replace(bag, 'compression=none', 'compression=zipp'), 'bag|compress'),
                                ('no image topic', change(bag, lambda data: data.replace(b'sensor_msgs/Image', b'sensor_msgs/Joyst')), 'image')):
        yield Kind('bags ROS 1', name, run(bag, '--camera', 'mono.yaml'), [r'office\.bag', *says], damage)
    yield Kind('bags ROS 1', 'no camera', run(bag), ['camera'])
    yield Kind('bags ROS 1', 'images of a wrong size', run(bag, '--camera', 'camera.yaml'), ['320x240', '640x480'],
               write('camera.yaml', 'width: 640\nheight: 480\nfx: 500\nfy: 500\ncx: 320\ncy: 240\n'))
