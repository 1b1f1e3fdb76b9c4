# SPDX-License-Identifier: Apache-2.0
"""Image, video and bag files written and read with the standard library, as far as the kinds of bad input need it."""
import sqlite3
import struct
import zlib


# ---- Images: grey, rows of bytes ------------------------------------------------------------------------------------

def read_png(data):
    """Width, height, bytes a pixel and rows of a PNG without a palette, as the command renders them."""
    at, packed, size = 8, b'', None
    while at < len(data):
        length, name = struct.unpack('>I4s', data[at:at + 8])
        if name == b'IHDR':
            size = struct.unpack('>IIBB', data[at + 8:at + 18])
        elif name == b'IDAT':
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    width, height, depth, colour = size
    step = depth // 8 * {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    return width, height, step, _unfiltered(zlib.decompress(packed), width * step, height, step)


def _unfiltered(raw, stride, height, step):
    rows, above = [], bytes(stride)
    for y in range(height):
        begin = y * (stride + 1)
        above = _unfiltered_row(raw[begin], bytearray(raw[begin + 1:begin + 1 + stride]), above, step)
        rows.append(bytes(above))
    return rows


def _paeth(a, b, c):
    p = a + b - c
    near = (abs(p - a), abs(p - b), abs(p - c))
    return a if near[0] <= near[1] and near[0] <= near[2] else b if near[1] <= near[2] else c


def _unfiltered_row(kind, row, above, step):
    for x in range(len(row) if kind else 0):
        left, corner = (row[x - step], above[x - step]) if x >= step else (0, 0)
        row[x] = (row[x] + (0, left, above[x], (left + above[x]) // 2, _paeth(left, above[x], corner))[kind]) & 255
    return row


def png_chunk(name, data):
    return struct.pack('>I', len(data)) + name + data + struct.pack('>I', zlib.crc32(name + data))


def png(width, height, rows, depth=8, colour=0, level=1):
    head = struct.pack('>IIBBBBB', width, height, depth, colour, 0, 0, 0)
    packed = zlib.compress(b''.join(b'\0' + row for row in rows), level)
    return b'\x89PNG\r\n\x1a\n' + png_chunk(b'IHDR', head) + png_chunk(b'IDAT', packed) + png_chunk(b'IEND', b'')


def pgm(width, height, rows):
    return b'P5\n%d %d\n255\n' % (width, height) + b''.join(rows)


def bmp(width, height, rows):
    palette = b''.join(bytes((v, v, v, 0)) for v in range(256))
    at = 54 + len(palette)
    head = struct.pack('<2sIHHI', b'BM', at + width * height, 0, 0, at)
    info = struct.pack('<IiiHHIIiiII', 40, width, height, 1, 8, 0, width * height, 2835, 2835, 256, 0)
    return head + info + palette + b''.join(reversed(rows))


def tiff(width, height, rows):
    """Not compressed, one strip. The directory follows the pixels."""
    pixels = b''.join(rows)
    entries = [(256, 3, width), (257, 3, height), (258, 3, 8), (259, 3, 1), (262, 3, 1), (273, 4, 8), (277, 3, 1), (278, 3, height),
               (279, 4, len(pixels))]
    directory = struct.pack('<H', len(entries))
    for tag, kind, value in entries:
        directory += struct.pack('<HHII', tag, kind, 1, value)
    return struct.pack('<2sHI', b'II', 42, 8 + len(pixels)) + pixels + directory + bytes(4)


def _huffman(counts, symbols):
    codes, code, at = {}, 0, 0
    for length, count in enumerate(counts, 1):
        for symbol in symbols[at:at + count]:
            codes[symbol] = format(code, f'0{length}b')
            code += 1
        at += count
        code <<= 1
    return codes


def jpeg(width, height, rows):
    """Baseline, grey, each block of 8 x 8 pixels by its mean alone (the tables are those of Annex K of the standard)."""
    counts, symbols = [0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0], list(range(12))
    codes, bits, before = _huffman(counts, symbols), [], 0
    for y in range(0, height, 8):
        for x in range(0, width, 8):
            block = [rows[min(y + dy, height - 1)][min(x + dx, width - 1)] for dy in range(8) for dx in range(8)]
            value = round(sum(block) / 64 - 128)
            difference, before = value - before, value
            size = abs(difference).bit_length()
            extra = difference if difference >= 0 else difference + (1 << size) - 1
            bits.append(codes[size] + (format(extra, f'0{size}b') if size else '') + '0')  # 0: the end of the block
    text = ''.join(bits)
    text += '1' * (-len(text) % 8)
    scan = bytes(int(text[k:k + 8], 2) for k in range(0, len(text), 8)).replace(b'\xff', b'\xff\0')
    quantisation = b'\xff\xdb' + struct.pack('>HB', 67, 0) + bytes([8]) + bytes([1] * 63)
    frame = b'\xff\xc0' + struct.pack('>HBHHBBBB', 11, 8, height, width, 1, 1, 0x11, 0)
    dc = b'\xff\xc4' + struct.pack('>HB', 19 + len(symbols), 0) + bytes(counts) + bytes(symbols)
    ac = b'\xff\xc4' + struct.pack('>HB', 20, 0x10) + bytes([1] + [0] * 15) + b'\0'
    start = b'\xff\xda' + struct.pack('>HBBBBBB', 8, 1, 1, 0, 0, 63, 0)
    return b'\xff\xd8' + quantisation + frame + dc + ac + start + scan + b'\xff\xd9'


def npy(width, height, values):
    """values: floats by rows."""
    head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({height}, {width}), }}"
    head += ' ' * (-(len(head) + 11) % 64) + '\n'
    return b'\x93NUMPY\1\0' + struct.pack('<H', len(head)) + head.encode() + struct.pack(f'<{len(values)}f', *values)


# ---- Motion JPEG in AVI --------------------------------------------------------------------------------------------

def _riff(name, data):
    return name + struct.pack('<I', len(data)) + data + b'\0' * (len(data) % 2)


def _riff_list(name, data):
    return _riff(b'LIST', name + data)


def avi(width, height, rate, jpegs):
    head = struct.pack('<14I', 1000000 // rate, 0, 0, 0x10, len(jpegs), 0, 1, max(map(len, jpegs)), width, height, 0, 0, 0, 0)
    stream = struct.pack('<4s4sIHHIIIIIIIIHHHH', b'vids', b'MJPG', 0, 0, 0, 0, 1, rate, 0, len(jpegs), max(map(len, jpegs)), 0xffffffff, 0, 0, 0,
                         width, height)
    picture = struct.pack('<IiiHH4sIiiII', 40, width, height, 1, 24, b'MJPG', width * height * 3, 0, 0, 0, 0)
    lists = _riff_list(b'hdrl', _riff(b'avih', head) + _riff_list(b'strl', _riff(b'strh', stream) + _riff(b'strf', picture)))
    frames, index, at = b'', b'', 4
    for image in jpegs:
        frames += _riff(b'00dc', image)
        index += struct.pack('<4sIII', b'00dc', 0x10, at, len(image))
        at = 4 + len(frames)
    return _riff(b'RIFF', b'AVI ' + lists + _riff_list(b'movi', frames) + _riff(b'idx1', index))


# ---- Messages and bags of ROS ----------------------------------------------------------------------------------------

class Cdr:
    """Serialises fields in their order, each at a multiple of its size, for ROS 2."""

    def __init__(self):
        self.data = b''

    def put(self, form, *values):
        for value in values:
            self.data += b'\0' * (-len(self.data) % struct.calcsize('<' + form)) + struct.pack('<' + form, value)
        return self

    def text(self, value):
        self.put('I', len(value) + 1)
        self.data += value.encode() + b'\0'
        return self

    def array(self, value):
        self.put('I', len(value))
        self.data += value
        return self

    def message(self):
        return b'\0\1\0\0' + self.data


def image_message(stamp, width, height, encoding, data):
    message = Cdr().put('I', stamp // 10**9, stamp % 10**9).text('camera').put('I', height, width).text(encoding)
    return message.put('B', 0).put('I', len(data) // height).array(data).message()


def camera_message(width, height, fx, cx, cy):
    message = Cdr().put('I', 0, 1).text('camera').put('I', height, width).text('plumb_bob').put('I', 5).put('d', *[0] * 5)
    message.put('d', fx, 0, cx, 0, fx, cy, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1, fx, 0, cx, 0, 0, fx, cy, 0, 0, 0, 1, 0)
    return message.put('I', 0, 0, 0, 0, 0, 0).put('B', 0).message()


def ros2_bag(file, messages):
    """messages: (topic, type, time in nanoseconds, bytes)"""
    file.unlink(missing_ok=True)
    bag = sqlite3.connect(file)
    bag.executescript('CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL, '
                      'offered_qos_profiles TEXT NOT NULL); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, '
                      'timestamp INTEGER NOT NULL, data BLOB NOT NULL);')
    ids = {}
    for topic, kind, at, data in messages:
        if topic not in ids:
            ids[topic] = len(ids) + 1
            bag.execute('INSERT INTO topics VALUES(?, ?, ?, ?, ?)', (ids[topic], topic, kind, 'cdr', ''))
        bag.execute('INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)', (ids[topic], at, data))
    bag.commit()
    bag.close()


def sql(path, command, *values):
    """A damage: changes a bag of ROS 2."""
    def do(folder):
        bag = sqlite3.connect(folder / path)
        bag.execute(command, values)
        bag.commit()
        bag.close()
    return do


def _field(name, value):
    return struct.pack('<I', len(name) + 1 + len(value)) + name + b'=' + value


def _record(fields, data):
    head = b''.join(_field(name, value) for name, value in fields)
    return struct.pack('<I', len(head)) + head + struct.pack('<I', len(data)) + data


def ros1_image(stamp, width, height, encoding, data):
    head = struct.pack('<IIII', 0, stamp // 10**9, stamp % 10**9, 6) + b'camera'
    return head + struct.pack('<III', height, width,
                              len(encoding)) + encoding.encode() + struct.pack('<BII', 0, len(data) // height, len(data)) + data


def ros1_bag(topic, kind, messages):
    """One topic and one chunk (wiki.ros.org/Bags/Format/2.0). messages: (time in nanoseconds, bytes)"""
    def u32(value):
        return struct.pack('<I', value)

    def moment(t):
        return struct.pack('<II', t // 10**9, t % 10**9)

    connection = _record([(b'op', b'\7'), (b'conn', u32(0)), (b'topic', topic)],
                         _field(b'topic', topic) + _field(b'type', kind) + _field(b'md5sum', b'0' * 32) + _field(b'message_definition', b'none'))
    chunk, entries = connection, b''
    for t, data in messages:
        entries += moment(t) + u32(len(chunk))
        chunk += _record([(b'op', b'\2'), (b'conn', u32(0)), (b'time', moment(t))], data)
    made = _record([(b'op', b'\5'), (b'compression', b'none'), (b'size', u32(len(chunk)))], chunk)
    index = _record([(b'op', b'\4'), (b'ver', u32(1)), (b'conn', u32(0)), (b'count', u32(len(messages)))], entries)
    magic = b'#ROSBAG V2.0\n'
    at = len(magic) + 4096
    fields = [(b'op', b'\3'), (b'index_pos', struct.pack('<Q', at + len(made) + len(index))), (b'conn_count', u32(1)), (b'chunk_count', u32(1))]
    head = _record(fields, b'')
    head = head[:-4] + u32(4096 - len(head)) + b' ' * (4096 - len(head))
    info = _record([(b'op', b'\6'), (b'ver', u32(1)), (b'chunk_pos', struct.pack('<Q', at)), (b'start_time', moment(messages[0][0])),
                    (b'end_time', moment(messages[-1][0])), (b'count', u32(1))], u32(0) + u32(len(messages)))
    return magic + head + made + index + connection + info
