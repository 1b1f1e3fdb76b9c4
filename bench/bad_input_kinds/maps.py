# SPDX-License-Identifier: Apache-2.0
"""Maps, vocabularies and models of COLMAP that are damaged or are something else."""
import ctypes
import ctypes.util
import struct
import zlib

from .kinds import Kind, both, change, column, copy, cut, empty, fifo, folder_at, large, line, link, locked, patch, remove, rename, replace, run, write, zero


def kinds():
    return [*damaged_files(), *sections(), *values(), *uses(), *vocabularies(), *colmap()]


# ---- The container of a map (docs/map-format.md) ----------------------------------------------------------------------

def zstd():
    library = ctypes.CDLL(ctypes.util.find_library('zstd') or 'libzstd.so.1')
    for name in ('ZSTD_compress', 'ZSTD_decompress', 'ZSTD_compressBound'):
        getattr(library, name).restype = ctypes.c_size_t
    return library


def unpack(data):
    """{id: bytes} of a map's sections."""
    count = struct.unpack_from('<I', data, 12)[0]
    at, found = 32 + 24 * count, {}
    for k in range(count):
        number, _, stored, size = struct.unpack_from('<IIQQ', data, 32 + 24 * k)
        raw = ctypes.create_string_buffer(size or 1)
        zstd().ZSTD_decompress(raw, ctypes.c_size_t(size), data[at:at + stored], ctypes.c_size_t(stored))
        found[number] = raw.raw[:size]
        at += stored
    return found


def pack(parts, major=1, minor=2, sizes=None):
    """A map of {id: bytes} with right checksums. sizes: announced instead of the true ones."""
    table, stored_bytes = b'', b''
    for number, raw in parts.items():
        room = zstd().ZSTD_compressBound(ctypes.c_size_t(len(raw)))
        buffer = ctypes.create_string_buffer(room)
        size = zstd().ZSTD_compress(buffer, ctypes.c_size_t(room), raw, ctypes.c_size_t(len(raw)), 1)
        stored = buffer.raw[:size]
        table += struct.pack('<IIQQ', number, zlib.crc32(stored), len(stored), (sizes or {}).get(number, len(raw)))
        stored_bytes += stored
    head = struct.pack('<8sHHIQI', b'COVISMAP', major, minor, len(parts), 32 + len(table) + len(stored_bytes), 0)
    return head + struct.pack('<I', zlib.crc32(head + table)) + table + stored_bytes


def parts_changed(function, **more):
    """A damage: changes the sections of office.m, and mends all checksums."""
    def changed(data):
        parts = unpack(data)
        made = function(parts)
        return pack(parts if made is None else made, **more)
    return change('office.m', changed)


def put(section, offset, form, *new):
    def do(parts):
        raw = bytearray(parts[section])
        struct.pack_into('<' + form, raw, offset if offset >= 0 else len(raw) + offset, *new)
        parts[section] = bytes(raw)
    return parts_changed(do)


def map_kind(name, damage, *says, words=('map', 'check', 'office.m'), needs=(), **more):
    return Kind('maps', name, list(words), ['office.m', *says], damage, needs=needs, **more)


def damaged_files():
    for share in (1, 7, 20, 31, 33, 100, 175, 177):
        yield map_kind(f'cut after {share} bytes', cut('office.m', share) if share > 1 else change('office.m', lambda data: data[:1]),
                       'not a map|cut off|damaged')
    for share in (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99):
        yield map_kind(f'cut at {share:.0%}', cut('office.m', share), 'damaged', 'bytes')
    yield map_kind('cut by its last byte', change('office.m', lambda data: data[:-1]), 'damaged', 'bytes')
    yield map_kind('a byte more', change('office.m', lambda data: data + b'x'), 'damaged', 'bytes')
    yield map_kind('twice', change('office.m', lambda data: data + data), 'damaged', 'bytes')
    for offset, name in ((0, 'magic'), (12, 'number of sections'), (16, 'size'), (24, 'reserve'), (28, 'checksum'), (32, "first section's id"),
                         (36, "first section's checksum"), (40, "first section's length"), (48, "first section's size")):
        yield map_kind(f'a bit of its {name}', change('office.m', lambda data, at=offset: data[:at] + bytes([data[at] ^ 4]) + data[at + 1:]),
                       'not a map|damaged')
    for k in range(1, 7):
        def flip(data, k=k):
            count, at = struct.unpack_from('<I', data, 12)[0], 0
            at = 32 + 24 * count + sum(struct.unpack_from('<Q', data, 40 + 24 * j)[0] for j in range(k - 1)) + 5
            return data[:at] + bytes([data[at] ^ 1]) + data[at + 1:]
        yield map_kind(f'a bit of section {k}', change('office.m', flip), 'damaged', 'checksum')
    for name, damage, *says in (('empty', empty('office.m'), 'empty'), ('zeros', zero('office.m', 0, 1), 'not a map'),
                                ('a text', write('office.m', 'hello'), 'not a map'), ('an image', copy('image/first.png', 'office.m'), 'not a map'),
                                ('a vocabulary', copy('words.covis-voc', 'office.m'), 'not a map'),
                                ('version 2.0', parts_changed(lambda parts: None, major=2, minor=0), 'version 2.0', '1'),
                                ('version 0.9', parts_changed(lambda parts: None, major=0, minor=9), 'version 0.9'),
                                ('a folder', folder_at('office.m'), 'folder'), ('a pipe', fifo('office.m'), 'device|pipe|regular'),
                                ('/dev/zero', link('office.m', '/dev/zero'), 'device'), ('/dev/null', link('office.m', '/dev/null'), 'device'),
                                ('gone', remove('office.m'), "can't be opened"),
                                ('a link to itself', link('office.m', 'office.m'), "can't be opened|symbolic"),
                                ('10 GiB of nothing', large('office.m', 10 << 30), 'not a map')):
        yield map_kind(name, damage, *says, needs=('image', 'words.covis-voc'))
        if name not in ('version 0.9', '/dev/null'):
            yield map_kind(f'{name}, map info', damage, *says, words=('map', 'info', 'office.m', '--picture', 'out/picture.png'),
                           needs=('image', 'words.covis-voc', 'out'))
    yield map_kind('not readable', locked('office.m'), 'Permission denied', as_nobody=True)


def sections():
    for number, name in ((1, 'about'), (2, 'key frames'), (3, 'features'), (4, 'observations'), (5, 'points')):
        yield map_kind(f'without section {number}', parts_changed(lambda parts, n=number: {k: v for k, v in parts.items() if k != n}), 'no section',
                       name)
        yield map_kind(f'section {number} empty', parts_changed(lambda parts, n=number: {**parts, n: b''}), name.split()[0] + '|length|damaged')
        yield map_kind(f'section {number} a byte shorter', parts_changed(lambda parts, n=number: {**parts, n: parts[n][:-1]}), 'length|damaged')
        yield map_kind(f'section {number} a byte longer', parts_changed(lambda parts, n=number: {**parts, n: parts[n] + b'x'}), 'length|damaged')
        yield map_kind(f'section {number} all 0xff', parts_changed(lambda parts, n=number: {**parts, n: b'\xff' * len(parts[n])}), SAID)
        yield map_kind(f'section {number} announced too large', parts_changed(lambda parts: None, sizes={number: 1 << 40}), name,
                       'times|grow|damaged')
        yield map_kind(f'section {number} announced too small', parts_changed(lambda parts: None, sizes={number: 3}), 'damaged|unpack|section')
    yield map_kind('section 1 twice', change('office.m', twice), 'damaged|twice')
    yield map_kind('no section at all', parts_changed(lambda parts: {}), 'no section|damaged')
    yield map_kind('a section of 64 MB of zeros', parts_changed(lambda parts: {**parts, 9: bytes(64 << 20)}), 'times|grow')
    yield map_kind('4 billion sections', patch('office.m', 12, b'\xff\xff\xff\xff'), 'damaged')


def twice(data):
    parts = unpack(data)
    once = pack({1: parts[1]})
    whole = pack(parts)
    stored = once[56:]
    table = whole[32:32 + 24 * len(parts)] + once[32:56]
    head = struct.pack('<8sHHIQI', b'COVISMAP', 1, 2, len(parts) + 1, 32 + len(table) + len(whole) - 32 - 24 * len(parts) + len(stored), 0)
    return head + struct.pack('<I', zlib.crc32(head + table)) + table + whole[32 + 24 * len(parts):] + stored


NAN, INF = float('nan'), float('inf')
ABOUT = (('width of 0', 0, 'i', 0), ('width of -1', 0, 'i', -1), ('width of 2^31 - 1', 0, 'i', 2**31 - 1), ('height of 0', 4, 'i', 0),
         ('fx of nan', 8, 'd', NAN), ('fx of 0', 8, 'd', 0.0), ('fy of -1', 16, 'd', -1.0), ('cx infinite', 24, 'd', INF),
         ('bf of -1', 40, 'd', -1.0), ('lens 9', 48, 'i', 9),
         ('a coefficient of nan', 52, 'd', NAN), ('sensor 7', 92, 'i', 7), ('levels of 0', 96, 'i', 0), ('levels of 99', 96, 'i', 99),
         ('a factor of nan', 100, 'f', NAN), ('a factor of 9', 100, 'f', 9.0), ('a vocabulary of 4 GB', 104, 'I', 0xffffffff))
KEY_FRAME = (('a serial of 2^32 - 1', 0, 'I', 0xffffffff), ('a stamp of 2^63 - 1', 12, 'q', 2**63 - 1), ('a stamp of -2^63', 12, 'q', -2**63),
             ('a rotation of nan', 20, 'd', NAN), ('a rotation of 2', 20, 'd', 2.0), ('a translation of nan', 92, 'd', NAN),
             ('a translation of 1e300', 92, 'd', 1e300),
             ('a parent that is not there', 116, 'I', 77), ('a parent that is itself', 116, 'I', 0), ('4 billion features', 120, 'I', 0xffffffff),
             ('no features', 120, 'I', 0), ('fx of nan', 124, 'd', NAN), ('bounds of nan', 164, 'f', NAN), ('levels of 0', 180, 'i', 0),
             ('4 billion loop edges', 188, 'I', 0xffffffff))
POINT = (('a position of nan', 0, 'd', NAN), ('a position of 1e300', 8, 'd', 1e300), ('a normal of nan', 24, 'd', NAN),
         ('a normal of length 9', 24, 'd', 9.0), ('a least distance of nan', 80, 'f', NAN), ('a greatest distance of -1', 84, 'f', -1.0),
         ('a reference that is not there', 88, 'I', 99), ('seen 2^32 - 1 times', 96, 'I', 0xffffffff),
         ('found 2^32 - 1 times', 100, 'I', 0xffffffff))
FEATURE = (('x of nan', 0, 'f', NAN), ('x of 1e30', 0, 'f', 1e30))
SAID = 'valid|damaged|sound|length|range|contents|right|finite|not|no |unknown|outside'


def values():
    """Values out of their ranges, with right checksums."""
    for section, name, fields in ((1, 'about', ABOUT), (2, 'first key frame', KEY_FRAME), (3, 'first feature', FEATURE), (5, 'first point', POINT)):
        for what, offset, form, value in fields:
            yield map_kind(f'{name}: {what}', put(section, offset, form, value), SAID)
    for what, offset, form, value in (('more key frames', -40, 'I', 1000), ('more points', -36, 'I', 10**9),
                                      ('a root that is not there', -32, 'I', 9), ('no root', -32, 'I', 0xffffffff),
                                      ('a next serial of 0', -28, 'I', 0), ('2^63 features', -16, 'Q', 2**63), ('2^63 observations', -8, 'Q', 2**63)):
        yield map_kind(f'about: {what}', put(1, offset, form, value), SAID)
    for what, value in (('a point that is not there', 10**6), ('none at all', 0xffffffff)):
        yield map_kind(f'observations: {what}', parts_changed(lambda parts, v=value: {**parts, 4: struct.pack('<I', v) * (len(parts[4]) // 4)}), SAID)
    yield map_kind('observations: one point again and again', parts_changed(lambda parts: {**parts, 4: bytes(len(parts[4]))}), SAID)
    for what, pair in (('nan', (NAN, 0.1)), ('negative', (-1.0, 0.1)), ('infinite', (0.1, INF))):
        yield map_kind(f'noise of depth: {what}', put(6, 0, 'dd', *pair), 'noise')


def uses():
    """A damaged map in each command that reads one, and good maps where they do not fit."""
    damages = (('cut', cut('office.m', 0.5)), ('with a wrong value', put(5, 0, 'd', NAN)), ('a text', write('office.m', 'hello')),
               ('a folder', folder_at('office.m')), ('a pipe', fifo('office.m')))
    for name, damage in damages:
        for words in (run('rgbd', '--map', 'office.m', '--save-map', 'out/words.m'), run('rgbd', '--map', 'office.m', '--localize'),
                      ['localize', 'rgbd', '--map', 'office.m', '--out', 'out/found.txt'],
                      ['map', 'merge', 'mono.m', 'office.m', '--out', 'out/office.m'],
                      ['map', 'prune', 'office.m', '--key-frames', '2', '--out', 'out/office.m'], ['map', 'split', 'office.m', '--out', 'out'],
                      ['map', 'export', 'office.m', '--to', 'ply', '--out', 'out/map.ply'], ['view', 'office.m', '--port', '0']):
            title = ' '.join(word for word in words[:2] if '.' not in word) + (' --localize' if '--localize' in words else '')
            yield map_kind(f'{name}: {title}', damage, words=words)
    for name, words, *says in (('a map of RGB-D for one camera, to continue', run('mono', '--map', 'office.m'), 'office.m',
                                'rgbd|RGB-D|sensor|monocular'), ('a map of one camera for RGB-D', run('rgbd', '--map', 'mono.m'), 'mono.m',
                                                                 'sensor|monocular|mono'),
                               ('other factor', run('rgbd', '--map', 'office.m', '--set', 'orb.scale_factor=1.3'), 'office.m', 'orb.scale_factor')):
        yield Kind('maps', f'a good map that does not fit: {name}', words, says)


def vocabularies():
    voc, text = 'words.covis-voc', 'words.txt'

    def kind(name, path, damage, *says, words=None, **more):
        return Kind('vocabularies', name, words or ['vocab', 'info', path], [path.replace('.', r'\.'), *says], damage, **more)
    for share in (1, 7, 30, 63, 65, 500):
        yield kind(f'cut after {share} bytes', voc, change(voc, lambda data, n=share: data[:n]), 'cut short|text format|line 1|bytes')
    for share in (0.5, 0.9, 0.999):
        yield kind(f'cut at {share:.1%}', voc, cut(voc, share), 'cut short')
    for offset, name in ((8, 'version'), (12, 'branching'), (16, 'depth'), (20, 'number of nodes'), (24, 'number of words'), (32, 'size'),
                         (40, 'checksum'), (56, "header's checksum"), (70, 'first descriptor'), (2000, 'descriptors'), (3300, 'tree'),
                         (3700, 'weights')):
        yield kind(f'a bit of its {name}', voc, change(voc, lambda data, at=offset: data[:at] + bytes([data[at] ^ 4]) + data[at + 1:]),
                   'damaged|checksum|version|cut short|follows')
    for name, damage, *says in (('empty', empty(voc), 'empty'), ('zeros', zero(voc, 0, 1), 'damaged|text format|line'),
                                ('a map', copy('office.m', voc), 'line 1|text format|vocabulary'),
                                ('an image', copy('image/first.png', voc), 'line 1|text format|vocabulary'),
                                ('a folder', folder_at(voc), 'folder|regular'), ('a pipe', fifo(voc), 'regular'),
                                ('/dev/zero', link(voc, '/dev/zero'), 'regular|device'), ('gone', remove(voc), "can't be opened|no such"),
                                ('bytes after its end', change(voc, lambda data: data + b'x'), 'follows its end')):
        yield kind(name, voc, damage, *says, needs=('office.m', 'image'))
        yield kind(f'{name}, run', voc, damage, words=run('rgbd', '--vocabulary', voc), needs=('office.m', 'image'))
    for name, damage, *says in (
            ('empty', empty(text), 'empty'), ('its first line is gone', line(text, 1, None), 'first line'),
            ('a branching of 1', line(text, 1, '1 3 0 0'), 'branching', '2 to'),
            ('a branching of 1000', line(text, 1, '1000 3 0 0'), 'branching', '2 to'), ('a depth of 0', line(text, 1, '4 0 0 0'), 'depth'),
            ('a depth of 99', line(text, 1, '4 99 0 0'), 'depth'),
            ('another scoring', line(text, 1, '4 3 2 0'), 'line 1', 'scoring'), ('another weighting', line(text, 1, '4 3 0 1'), 'line 1',
                                                                                 'weighting'), ('three numbers', line(text, 1, '4 3 0'),
                                                                                                'first line'), ('words', line(text, 1, 'four three zero zero'), 'first line'), ('a node that is cut', line(text, 5, '0 0 1 2 3'), 'line 5'),
            ('a byte of 256', column(text, 5, 3, '256'), 'line 5'), ('a byte of -1', column(text, 5, 3, '-1'), 'line 5'),
            ('a weight of nan', column(text, 6, 35, 'nan'), 'line 6|node|weight'), ('a weight of -1', column(text, 6, 35, '-1'), 'weight'),
            ('a parent that comes later', column(text, 5, 1, '70'), 'line 5', 'parent'),
            ('a parent of 1e9', column(text, 5, 1, '1000000000'), 'line 5', 'parent'),
            ('a negative parent', column(text, 5, 1, '-1'), 'line 5'), ('a word with children', column(text, 2, 2, '1'), 'line', 'parent'),
            ('a kind of 2', column(text, 5, 2, '2'), 'line 5'), ('too many children', change(text, lambda data: data + data.split(b'\n')[1] + b'\n'),
                                                                 'children|parent'), ('cut in the middle', cut(text, 0.5), 'line|words|node'),
            ('binary', write(text, bytes(range(256))), 'first line'), ('a line of 1,000,000 characters', line(text, 5, '9' * 1000000), 'line 5'),
            ('an announced size alone', write(text, '10 6 0 0\n'), 'no nodes')):
        yield kind(f'text: {name}', text, damage, *says)
        yield kind(f'text: {name}, convert', text, damage, words=['vocab', 'convert', text, 'out/words.covis-voc', '--overwrite'], needs=('out',))


def colmap():
    words = ['map', 'import', 'colmap/sparse/0', '--images', 'colmap/images', '--out', 'out/office.m']
    cameras, images = 'colmap/sparse/0/cameras.txt', 'colmap/sparse/0/images.txt'
    for name, damage, *says in (
            ('cameras.txt is gone', remove(cameras), 'cameras.txt', 'no such file'),
            ('images.txt is gone', remove(images), 'images.txt', 'no such file'),
            ('the folder is gone', remove('colmap'), 'cameras.txt|sparse/0', 'no such'),
            ('cameras.txt is empty', empty(cameras), 'cameras.txt', 'no camera'),
            ('images.txt is empty', empty(images), 'images.txt', 'two images'), ('cameras.txt is binary', write(cameras, bytes(range(256))),
                                                                                 'cameras.txt:1', 'PINHOLE'),
            ('images.txt is binary', write(images, bytes(range(256)) * 9), 'images.txt:1', 'quaternion'),
            ('the images of a binary model are gone', rename(cameras, 'colmap/sparse/0/cameras.bin'), 'images.bin', 'no such file'),
            ('an unknown lens', replace(cameras, 'PINHOLE', 'FOV'), 'cameras.txt:2', 'FOV', 'PINHOLE'),
            ('a width of 10', replace(cameras, '320 240', '10 240'), 'cameras.txt:2', '64'),
            ('a width of 1e6', replace(cameras, '320 240', '1000000 240'), 'cameras.txt:2', '32768'),
            ('a focal length of nan', replace(cameras, '250 250', 'nan 250'), 'cameras.txt:2', 'focal'),
            ('a negative focal length', replace(cameras, '250 250', '-250 250'), 'cameras.txt:2', 'focal'),
            ('too few figures', replace(cameras, '250 250', '250'), 'cameras.txt:2', 'PINHOLE'),
            ('two cameras', change(cameras, lambda data: data + data.split(b'\n')[1] + b'\n'), 'cameras.txt:3', 'second camera'),
            ('the size of other images', replace(cameras, '320 240', '640 480'), '320x240', '640x480'),
            ('a quaternion of zeros', column(images, 3, 2, '0'), 'images.txt:3', 'quaternion'),
            ('a translation of nan', column(images, 3, 6, 'nan'), 'images.txt:3', 'translation'),
            ('a translation of 1e300', column(images, 3, 6, '1e300'), 'images.txt:3', 'translation'),
            ('an image of another camera', column(images, 3, 9, '7'), 'images.txt:3', 'camera'),
            ('an image out of the folder', column(images, 3, 10, '../../office.m'), 'images.txt:3', 'outside'),
            ('an absolute path', column(images, 3, 10, '/etc/passwd'), 'images.txt:3', 'outside'),
            ('an image without a name', change(images, lambda data: data.replace(b' 000000.png', b'')), 'images.txt:3', 'name'),
            ('one id twice', column(images, 5, 1, '1'), 'images.txt:', 'id'),
            ('a line of points that is cut', line(images, 4, '1 2'), 'images.txt:4', 'point'),
            ('points that are words', line(images, 4, 'a b c'), 'images.txt:4', 'point'),
            ('no line of points', change(images, lambda data: b'\n'.join(data.split(b'\n')[:3]) + b'\n'), 'images.txt', 'points'),
            ('images that are all gone', both(remove('colmap/images'), folder_at('colmap/images')), 'colmap/images', 'image|two'),
            ('images.txt is a pipe', fifo(images), 'images.txt', 'no such file|regular'),
            ('images.txt is a folder', folder_at(images), 'images.txt', 'no such file|folder'),
            ('cameras.txt is /dev/zero', link(cameras, '/dev/zero'), 'cameras.txt', 'no such file|regular')):
        yield Kind('COLMAP', name, words, list(says), damage, needs=('out',))
    yield Kind('COLMAP', 'a folder of images that is not there', [*words[:4], 'gone', *words[5:]], ['gone'], needs=('out',))
    yield Kind('COLMAP', 'a model that is a file', ['map', 'import', 'office.m', *words[3:]], ['office.m|cameras.txt', 'no such|folder'],
               needs=('out',))
