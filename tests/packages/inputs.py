#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a video and a bag of ROS 1, of three frames of 96x72 pixels each, and their camera file: for tests of an installed
command, which reads these by its plug-ins.

  tests/packages/inputs.py FOLDER       # video.y4m, recording.bag, camera.yaml
"""
import pathlib
import struct
import sys

WIDTH, HEIGHT, FRAMES = 96, 72, 3
CAMERA = f'width: {WIDTH}\nheight: {HEIGHT}\nfx: 80\nfy: 80\ncx: 48\ncy: 36\n'


def grey(frame):
    return bytes((x // 8 + y // 8 + frame) % 2 * 200 for y in range(HEIGHT) for x in range(WIDTH))


def video():
    """YUV4MPEG2, the colours of half the size."""
    colours = bytes([128]) * (WIDTH * HEIGHT // 2)
    return f'YUV4MPEG2 W{WIDTH} H{HEIGHT} F10:1 C420\n'.encode() + b''.join(b'FRAME\n' + grey(i) + colours for i in range(FRAMES))


def text(data):
    return struct.pack('<I', len(data)) + data


def record(data, **fields):
    """wiki.ros.org/Bags/Format/2.0"""
    return text(b''.join(text(name.encode() + b'=' + value) for name, value in fields.items())) + text(data)


def number(value, kind='<I'):
    return struct.pack(kind, value)


def bag():
    stamps = [(i + 1, 0) for i in range(FRAMES)]  # seconds, nanoseconds
    topic = b'/camera/image_raw'
    about = record(b''.join(text(field) for field in (b'topic=' + topic, b'type=sensor_msgs/Image', b'md5sum=060021388200f6f0f447d0fcd9c64743',
                                                      b'message_definition=')), op=b'\x07', conn=number(0), topic=topic)
    chunk, places = about, b''
    for i, stamp in enumerate(stamps):
        places += struct.pack('<III', *stamp, len(chunk))
        image = struct.pack('<III', i, *stamp) + text(b'camera') + struct.pack('<II', HEIGHT, WIDTH) + text(b'mono8') + b'\0' + number(WIDTH)
        chunk += record(image + text(grey(i)), op=b'\x02', conn=number(0), time=struct.pack('<II', *stamp))

    def begin(index):
        return b'#ROSBAG V2.0\n' + record(b' ' * 64, op=b'\x03', index_pos=number(index, '<Q'), conn_count=number(1), chunk_count=number(1))
    start = len(begin(0))
    body = record(chunk, op=b'\x05', compression=b'none', size=number(len(chunk)))
    body += record(places, op=b'\x04', ver=number(1), conn=number(0), count=number(FRAMES))
    times = {name: struct.pack('<II', *stamp) for name, stamp in (('start_time', stamps[0]), ('end_time', stamps[-1]))}
    return begin(start + len(body)) + body + about + record(struct.pack('<II', 0, FRAMES), op=b'\x06', ver=number(1),
                                                            chunk_pos=number(start, '<Q'), **times, count=number(1))


def write(folder):
    folder = pathlib.Path(folder)
    (folder / 'video.y4m').write_bytes(video())
    (folder / 'recording.bag').write_bytes(bag())
    (folder / 'camera.yaml').write_text(CAMERA)


if __name__ == '__main__':
    write(sys.argv[1])
