# SPDX-License-Identifier: Apache-2.0
"""Makes scene.bin, the file that covis view shows, for a map of any size (apps/view/rows.h has its layout)."""
import json
import struct

import numpy as np

INFO, KEY_FRAMES, POINTS, EDGES, PATH, FRAMES, TEXTS, LOOP, OBSERVATIONS, CAMERAS = 1, 2, 4, 6, 8, 10, 11, 12, 14, 16
POSE = [('t', '<f4', 3), ('q', '<f4', 4)]
ROWS = {
    KEY_FRAMES: np.dtype([('id', '<u4'), ('submap', '<u4'), ('frame', '<i4'), ('parent', '<u4'), ('stamp', '<f8'), *POSE, ('camera', '<u4')]),
    POINTS: np.dtype([('id', '<u4'), ('t', '<f4', 3), ('colour', 'u1', 3), ('has_colour', 'u1'), ('submap', '<u4'), ('frame', '<i4')]),
    EDGES: np.dtype([('a', '<u4'), ('b', '<u4'), ('shared', '<u2'), ('loop', '<u2')]),
    PATH: np.dtype([('frame', '<i4'), ('submap', '<u4'), *POSE]),
    FRAMES: np.dtype([('frame', '<i4'), ('state', 'u1'), ('flags', 'u1'), ('reason', '<u2'), ('stamp', '<f8'), *POSE, ('submap', '<u4'),
                      ('inliers', '<i4'), ('features', '<i4'), ('tracking_ms', '<f4'), ('total_ms', '<f4')]),
}
CAMERA = np.dtype([('fx', '<f4'), ('fy', '<f4'), ('cx', '<f4'), ('cy', '<f4'), ('width', '<u4'), ('height', '<u4')])
PLACE = np.dtype([('id', '<u4'), ('t', '<f4', 3), ('submap', '<u4')])
OBSERVATION = np.dtype([('other', '<u4'), ('u', '<u2'), ('v', '<u2')])


def block(kind, body):
    return struct.pack('<II', kind, len(body)) + body + b'\0' * (-len(body) % 4)


def around(share):
    """Poses on a wavy ring of 300 m that looks along the path."""
    angle = 2 * np.pi * share
    t = np.stack([50 * np.sin(angle), -2 * np.sin(5 * angle), 50 * np.cos(angle)], axis=1)
    q = np.stack([0 * angle, np.sin((angle + np.pi / 2) / 2), 0 * angle, np.cos((angle + np.pi / 2) / 2)], axis=1)
    return t, q


def observations(key_frames, points, every):
    """Each key frame observes the points that begin with it."""
    blocks = b''
    owner = np.clip(points['frame'] // every, 0, len(key_frames) - 1)
    first = np.searchsorted(owner, np.arange(len(key_frames) + 1))
    for n in range(len(key_frames)):
        rows = np.zeros(first[n + 1] - first[n], OBSERVATION)
        rows['other'] = points['id'][first[n]:first[n + 1]]
        rows['u'], rows['v'] = 4 * (17 * rows['other'] % 640), 4 * (31 * rows['other'] % 480)
        blocks += block(OBSERVATIONS, struct.pack('<I', n) + rows.tobytes())
    return blocks


def made_scene(key_frames, points, every=5, loop=False, submaps=1, lost=(), second_camera=None):
    """The bytes of scene.bin (docs/viewer.md) with a map of this size; every n-th frame is a key frame.
    loop: the last key frames close one, before which they lay 8 m lower. Each key frame observes its nearest points.
    submaps: how many there are, one after the other along the path. lost: numbers of frames without a pose.
    second_camera: (fx, fy, cx, cy, width, height) of the one that made the second half of the key frames."""
    random = np.random.default_rng(1)
    frames = key_frames * every
    k = np.zeros(key_frames, ROWS[KEY_FRAMES])
    k['id'], k['frame'] = np.arange(key_frames), np.arange(key_frames) * every
    k['parent'], k['stamp'] = np.concatenate([[0xffffffff], np.arange(key_frames - 1)]), k['frame'] / 30
    k['t'], k['q'] = around(k['frame'] / frames)
    p = np.zeros(points, ROWS[POINTS])
    p['id'], share = np.arange(points), np.sort(random.random(points))
    p['t'] = around(share)[0] * (1 + 0.15 * random.standard_normal((points, 1))) + random.standard_normal((points, 3)) * [3, 4, 3]
    p['frame'] = share * frames
    near = np.concatenate([np.stack([np.arange(key_frames - d), np.arange(d, key_frames)], axis=1) for d in range(1, 11)])
    near = near[np.lexsort((near[:, 1], near[:, 0]))]
    for rows in (k, p):
        rows['submap'] = submaps * rows['frame'] // frames
    near = near[k['submap'][near[:, 0]] == k['submap'][near[:, 1]]]
    e = np.zeros(len(near), ROWS[EDGES])
    e['a'], e['b'], e['shared'] = near[:, 0], near[:, 1], 400 // (near[:, 1] - near[:, 0])
    path = np.zeros(frames, ROWS[PATH])
    path['frame'] = np.arange(frames)
    path['t'], path['q'] = around(path['frame'] / frames)
    path['submap'] = submaps * path['frame'] // frames
    f = np.zeros(frames, ROWS[FRAMES])
    for name in ('frame', 't', 'q', 'submap'):
        f[name] = path[name]
    f['flags'], f['stamp'], f['inliers'], f['tracking_ms'] = 4, f['frame'] / 30, random.integers(200, 400, frames), 10 + 3 * random.random(frames)
    f['state'][list(lost)], f['flags'][list(lost)] = 1, 0
    path = np.delete(path, list(lost))
    info = {'title': f'{key_frames} key frames, {points} points', 'mode': 'finished', 'source': 'made by bench/viewer', 'states': ['tracking', 'lost'],
            'sensor': 'rgbd', 'camera': {'width': 640, 'height': 480, 'fx': 525, 'fy': 525, 'cx': 320, 'cy': 240}}
    loops = b''
    if loop:
        e[-1]['loop'] = 1
        after = np.zeros(key_frames, PLACE)
        after['id'], after['t'] = k['id'], k['t']
        before = after.copy()
        before['t'][:, 1] += 8 * np.linspace(0, 1, key_frames)
        head = struct.pack('<IiIfII', 0, frames - every, 0, 8, key_frames, key_frames)
        loops = block(LOOP, head + before.tobytes() + after.tobytes())
    cameras = b''
    if second_camera:
        k['camera'][key_frames // 2:] = 1
        cameras = block(CAMERAS, np.array([second_camera], CAMERA).tobytes())
    lists = [(KEY_FRAMES, k), (POINTS, p), (EDGES, e), (PATH, path), (FRAMES, f)]
    return b'COVISVW1' + block(INFO, json.dumps(info).encode()) + block(TEXTS, b'[""]') + cameras + b''.join(
        block(kind, rows.tobytes()) for kind, rows in lists) + loops + observations(k, p, every)
