# SPDX-License-Identifier: Apache-2.0
"""Settings that are wrong, given by --set or in a file."""
from .kinds import Kind, empty, fifo, folder_at, large, link, replace, run, write


def kinds():
    return [*by_option(), *wrong_files(), *wrong_values()]


def by_option():
    for value, *says in (
            ('orb.featurs=3', 'featurs', 'orb.features'), ('features=500', "'features'", 'nearest'), ('orb.features', '--set', 'NAME=VALUE'),
            ('=3', "''|NAME=VALUE"),
            ('orb.features=', 'orb.features', 'whole number from 50'), ('orb.features=x', 'orb.features', 'whole number from 50'),
            ('orb.features=49', 'orb.features', '50 to 30000'), ('orb.features=30001', 'orb.features', '50 to 30000'),
            ('orb.features=1e3', 'orb.features', 'whole number'),
            ('orb.features=99999999999999999999', 'orb.features', 'whole number'), ('orb.features=1000 ', 'orb.features', 'whole number'),
            ('orb.scale_factor=nan', 'orb.scale_factor', '1.05 to 2'), ('orb.scale_factor=inf', 'orb.scale_factor', '1.05 to 2'),
            ('orb.scale_factor=-1.2', 'orb.scale_factor', '1.05 to 2'), ('orb.scale_factor=1,2', 'orb.scale_factor', '1.05 to 2'),
            ('orb.scale_factor=0x1p0', 'orb.scale_factor', '1.05 to 2'), ('orb.scale_factor=1e999', 'orb.scale_factor', '1.05 to 2'),
            ('orb.subpixel=yes', 'orb.subpixel', 'true or false'), ('orb.subpixel=1', 'orb.subpixel', 'true or false'),
            ('orb.subpixel=True', 'orb.subpixel', 'true or false'),
            ('orb.levels=-1', 'orb.levels', '0 to 16'), ('orb.levels=17', 'orb.levels', '0 to 16'),
            ('orb.subpixel=true\x1b[2J', 'orb.subpixel', 'true or false'),
            ('orb.levels=8\n', 'orb.levels', '0 to 16'), ('tracker.min_inliers=-1', 'tracker.min_inliers', '4 to 1000'),
            ('mapper.max_map_mb=-1', 'mapper.max_map_mb', 'from 0'), ('loop.max_rotation=181', 'loop.max_rotation', '0 to 180'),
            ('system.seed=-1', 'system.seed', '0 to 2147483647'), ('system.trajectory_frames=9', 'system.trajectory_frames', 'programs'),
            ('\x1b]0;title\x07=1', 'nearest'), ('x' * 100000 + '=1', 'nearest'), ('orb.features=' + '9' * 100000, 'orb.features', 'whole number')):
        name = value if len(value) < 40 else value[:20] + '…'
        yield Kind('settings', f'--set {name!r}', run('rgbd', '--set', value), says)
    yield Kind('settings', '--set without --dump-config being fooled', ['run', '--dump-config', '--set', 'orb.levels=-1'], ['orb.levels', '0 to 16'])


def wrong_files():
    bomb = 'a: &a [x,x,x,x,x,x,x,x,x]\n' + ''.join(f'{chr(98 + k)}: &{chr(98 + k)} [{",".join(["*" + chr(97 + k)] * 9)}]\n' for k in range(9))
    for name, content, *says in (
            ('a list', '- orb.features: 500\n- orb.levels: 8\n', 'map'), ('a single value', '42\n', 'map'), ('a text', 'hello\n', 'map'),
            ('no YAML', 'orb: [1, 2\n', ':[12]:', 'not YAML'), ('a tab for an indent', 'orb:\n\tfeatures: 500\n', ':2:', 'not YAML'),
            ('an anchor that is not there', 'orb:\n  features: *gone\n', ':2:', 'not YAML'), ('an anchor bomb', bomb, "unknown|single value|nearest"),
            ('an anchor of itself', 'orb: &a\n  features: *a\n', ':2:', 'itself'),
            ('nested 5000 deep', 'a: ' + '[' * 5000 + ']' * 5000 + '\n', 'deep|not YAML|nearest|single value'),
            ('nested maps, 5000 deep', ''.join(' ' * k + 'a:\n' for k in range(5000)), 'deep|not YAML|nearest|unknown'),
            ('two documents', 'orb: {levels: 8}\n---\norb: {levels: 99}\n', '2|document|twice|one', ),
            ('a byte order mark of UTF-16', 'orb:\n  levels: 99\n'.encode('utf-16'), 'orb.levels|not YAML|map'),
            ('zero bytes', bytes(100), 'not YAML|map'),
            ('binary', bytes(range(256)) * 10, 'not YAML|map'), ('bytes that are no UTF-8', b'orb:\n  f\xff\xfe: 3\n', 'nearest|not YAML'),
            ('a very long line', 'orb:\n  levels: ' + 'x' * 1000000 + '\n', ':2:', 'orb.levels', '0 to 16'),
            ('a very long key', 'x' * 2000 + ': 3\n', ':1:', 'nearest|not YAML'),
            ('a key that is a list', '? [orb, levels]\n: 8\n', ':1:', 'unknown|single|nearest|name'),
            ('a key that is a map', '? {orb: levels}\n: 8\n', ':1:', 'unknown|single|nearest|name'),
            ('a null key', '~: 8\n', ':1:', 'unknown|nearest'),
            ('a key twice', 'orb:\n  levels: 8\n  levels: 7\n', ':3:', 'orb.levels', 'twice'),
            ('a section twice', 'orb:\n  levels: 8\norb:\n  levels: 7\n', ':4:', 'orb.levels', 'twice'),
            ('a section that is a value', 'orb: 8\n', ':1:', "orb", 'unknown|nearest'),
            ('a value that is a section', 'orb:\n  levels:\n    a: 8\n', ':3:', 'orb.levels.a'),
            ('an escape in a key', '"orb\\e[31m": 8\n', ':1:', 'nearest'), ('an escape in a value', 'orb:\n  levels: "8\\e[31m"\n', ':2:',
                                                                            'orb.levels', '0 to 16'),
            ('a quoted line break', 'orb:\n  levels: "8\\n"\n', ':2:', 'orb.levels', '0 to 16'),
            ('a tag', 'orb:\n  levels: !!python/object:os.system [ls]\n', ':2:', 'orb.levels'),
            ('a setting of old that is gone', 'orb:\n  featurs: 500\n', ':2:', 'orb.features')):
        yield Kind('settings', f'--config, {name}', run('rgbd', '--config', 'settings.yaml'), ['settings.yaml', *says],
                   write('settings.yaml', content))
    for name, damage, *says in (('a folder', folder_at('settings.yaml'), 'folder', 'file'), ('a pipe', fifo('settings.yaml'), 'pipe', 'regular file'),
                                ('a device', link('settings.yaml', '/dev/zero'), 'device', 'regular file'),
                                ('a link to nothing', link('settings.yaml', 'gone'), "can't be opened"),
                                ('a link to itself', link('settings.yaml', 'settings.yaml'), "can't be opened"),
                                ('2 GiB of nothing', large('settings.yaml', 1 << 31), 'MiB')):
        yield Kind('settings', f'--config, {name}', run('rgbd', '--config', 'settings.yaml'), ['settings.yaml', *says], damage)
    yield Kind('settings', '--config, an image', run('rgbd', '--config', 'image/first.png'), ['first.png', 'YAML|map'])
    yield Kind('settings', '--config, a map of Covis', run('rgbd', '--config', 'office.m'), ['office.m', 'YAML|map of settings'])
    yield Kind('settings', '--config, an empty file', run('rgbd', '--config', 'settings.yaml'), [], empty('settings.yaml'), passed_over=True)


def wrong_values():
    for old, new, *says in (
            ('features: 1000', 'features: nan', 'orb.features', '50 to 30000'), ('features: 1000', 'features: [1000]', 'orb.features',
                                                                                 'single value'),
            ('features: 1000', 'features:', 'orb.features', 'single value'), ('features: 1000', 'features: ~', 'orb.features', 'single value'),
            ('features: 1000', 'features: 1_000', 'orb.features', '50 to 30000'),
            ('features: 1000', 'features: 0x3e8', 'orb.features', '50 to 30000'),
            ('scale_factor: 1.2', 'scale_factor: .nan', 'orb.scale_factor', '1.05 to 2'),
            ('scale_factor: 1.2', 'scale_factor: .inf', 'orb.scale_factor', '1.05 to 2'),
            ('scale_factor: 1.2', 'scale_factor: 2.01', 'orb.scale_factor', '1.05 to 2'),
            ('subpixel: true', 'subpixel: yes', 'orb.subpixel', 'true or false'),
            ('min_inliers: 30', 'min_inliers: three', 'tracker.min_inliers', '4 to 1000'),
            ('motion_window: 15', 'motion_window: -15', 'tracker.motion_window', '1 to 200'),
            ('max_map_mb: 0', 'max_map_mb: 1e99', 'mapper.max_map_mb', 'whole number'), ('tracker:', 'trakcer:', 'trakcer', 'nearest')):
        yield Kind('settings', f'--config, {new}', run('rgbd', '--config', 'settings.yaml'), [r'settings.yaml:\d+:', *says],
                   replace('settings.yaml', old, new))
