# SPDX-License-Identifier: Apache-2.0
"""Camera files: Covis' own, and those of other programs."""
from .kinds import Kind, append, both, cut, empty, fifo, folder_at, large, line, link, locked, remove, rename, replace, run, write, zero

GOOD = {'width': '320', 'height': '240', 'fx': '250', 'fy': '250', 'cx': '159.5', 'cy': '119.5', 'model': 'pinhole', 'fps': '8',
        'depth_scale': '5000', 'baseline': '0.08'}


def kinds():
    return [*fields(), *lens(), *files(), *of_other_programs()]


def text(**changes):
    """A camera file; None leaves a field out."""
    values = {**GOOD, **changes}
    return ''.join(f'{key}: {value}\n' for key, value in values.items() if value is not None)


def kind(name, content, *says):
    return Kind('cameras', name, run('rgbd', '--camera', 'camera.yaml'), ['camera.yaml', *says], write('camera.yaml', content))


def fields():
    for key in ('width', 'height', 'fx', 'fy', 'cx', 'cy'):
        yield kind(f'{key} is absent', text(**{key: None}), key, 'missing')
    wrong = ('nan', '.nan', 'inf', '-1', '0', '1e308', '1e-308', 'wide', '[3, 4]', '{a: 1}', '', '~', '"320 "', '3.2.0')
    for key in ('width', 'fx', 'cx'):
        for value in wrong:
            if (key, value) == ('cx', '1e-308'):
                continue  # it lies inside the image
            yield kind(f'{key}: {value}', text(**{key: value}), r'yaml:\d+', key, 'must be|single value|principal point|positive')
    for key, values in (('height', ('nan', '240.5', '1000000')), ('fy', ('inf', '-250', '0')), ('cy', ('nan', '-0.5', '240')),
                        ('fps', ('nan', '0', '-8', '1e9', 'fast')),
                        ('depth_scale', ('nan', '0', '-5000', '1e308', 'mm')), ('baseline', ('nan', '0', '-0.1', '1e308', 'ten')),
                        ('depth_sigma_a', ('nan', '-1', '2')),
                        ('depth_noise', ('kinekt', '', '[1, 2]')), ('depth_fx', ('nan', '0', '-585', '1e308', '5'))):
        for value in values:
            yield kind(f'{key}: {value}', text(**{key: value}), r'yaml:\d+', key, 'must|single value|principal point')
    yield kind('bf: -40', text(baseline=None, bf='-40'), ':10', 'bf', 'must be')
    yield kind('width as a fraction', text(width='320.5'), ':1', 'width', 'whole number')
    yield kind('baseline and bf', text(bf='20'), 'baseline', 'bf', 'not both')
    yield kind('depth_noise and depth_sigma_a', text(depth_noise='kinect', depth_sigma_a='0.001'), 'depth_noise', 'not both')
    yield kind('depth_x without depth_fx', text(depth_x='0.02'), r'yaml:\d+', 'depth_x', 'depth_fx')
    yield kind('depth_x of a kilometre', text(depth_fx='300', depth_x='1000'), r'yaml:\d+', 'depth_x', 'must be')
    yield kind('no noise at all', text(depth_sigma_a='0', depth_sigma_b='0'), 'depth_sigma_a', 'greater than 0')
    yield kind('an unknown key', text(focal='250'), r'yaml:\d+', 'focal', 'nearest')
    yield kind('a key in capitals', text(fx=None, FX='250'), r'yaml:\d+', 'FX', 'nearest')
    yield kind('a key twice', text() + 'fx: 251\n', r'yaml:11', 'fx', 'twice')
    yield kind('an escape in a key', text() + '"\\e[31mfx": 3\n', r'yaml:11', 'nearest')
    yield kind('a value of 100,000 characters', text(model='x' * 100000), 'model', 'pinhole')
    yield kind('the size of other images', text(width='640', height='480', cx='320', cy='240'), '320x240', '640x480')
    yield kind('a size turned by 90 degrees', text(width='240', height='320', cx='120', cy='160'), '320x240', '240x320')


def lens():
    brown, fisheye = {'model': 'brown_conrady'}, {'model': 'kannala_brandt'}
    for name, values, *says in (
            ('an unknown model', {'model': 'fisheye'}, 'fisheye', 'kannala_brandt'), ('a model that is a number', {'model': '3'}, "'3'", 'pinhole'),
            ('a model that is empty', {'model': ''}, 'model', 'single value'), ('a lens of a pinhole', {'distortion': '[0.1, 0, 0, 0]'}, 'distortion',
                                                                                'pinhole', 'brown_conrady'),
            ('three coefficients', {**brown, 'distortion': '[0.1, 0, 0]'}, 'distortion', 'k1'),
            ('six coefficients', {**brown, 'distortion': '[1, 2, 3, 4, 5, 6]'}, 'distortion', 'k1'),
            ('five of a fisheye', {**fisheye, 'distortion': '[0, 0, 0, 0, 0]'}, 'distortion', 'k4'),
            ('no list of them', {**brown, 'distortion': '0.1'}, 'distortion', 'list'),
            ('an empty list', {**brown, 'distortion': '[]'}, 'distortion', 'list'),
            ('a map of them', {**brown, 'distortion': '{k1: 0.1}'}, 'distortion', 'list'),
            ('a coefficient that is nan', {**brown, 'distortion': '[nan, 0, 0, 0]'}, 'distortion', 'finite'),
            ('one that is a word', {**brown, 'distortion': '[a, 0, 0, 0]'}, 'distortion', 'finite'),
            ('one that is infinite', {**brown, 'distortion': '[1e999, 0, 0, 0]'}, 'distortion', 'finite'),
            ('one that is a list', {**brown, 'distortion': '[[1], 0, 0, 0]'}, 'distortion', 'finite'),
            ('one of 1e308', {**brown, 'distortion': '[1e308, 0, 0, 0]'}, 'distortion|coefficient|lens')):
        yield kind(f'lens: {name}', text(**values), *says)
    for name, values in (('a lens that folds', {**brown, 'distortion': '[-3, 0, 0, 0]'}),
                         ('a fisheye that folds', {**fisheye, 'distortion': '[-5, 0, 0, 0]'})):
        # The run is made, and finds no keypoint where the image is unfolded.
        yield Kind('cameras', f'lens: {name}', run('rgbd', '--camera', 'camera.yaml'), ['rgbd: no frame was tracked', 'distortion'],
                   write('camera.yaml', text(**values)),
                   changes=('out',))
    yield Kind('cameras', 'lens: of a stereo pair', run('stereo', '--camera', 'camera.yaml'), ['camera.yaml', 'rectified', 'pinhole'],
               write('camera.yaml', text(**brown, distortion='[0.1, 0, 0, 0]')))
    yield Kind('cameras', 'a stereo pair without baseline', run('stereo', '--camera', 'camera.yaml'), ['camera.yaml', 'baseline'],
               write('camera.yaml', text(baseline=None)))


def files():
    bomb = 'a: &a [x,x,x,x,x,x,x,x,x]\n' + ''.join(f'{chr(98 + k)}: &{chr(98 + k)} [{",".join(["*" + chr(97 + k)] * 9)}]\n' for k in range(9))
    for name, damage, *says in (
            ('empty', empty('camera.yaml'), 'map|empty', 'width'), ('cut within a key', cut('camera.yaml', 30), r'camera.yaml'),
            ('zeros', zero('camera.yaml', 0, 1), 'YAML|map'),
            ('a list', write('camera.yaml', '- 320\n- 240\n'), 'map', 'width'), ('one value', write('camera.yaml', '320'), 'map', 'width'),
            ('no YAML', write('camera.yaml', 'width: [320\nheight: 240\n'), r'yaml:\d', 'not YAML'),
            ('binary', write('camera.yaml', bytes(range(256)) * 40), 'YAML|map'),
            ('an anchor bomb', write('camera.yaml', bomb), 'unknown key'), ('nested 5000 deep', write('camera.yaml', 'width: ' + '[' * 5000 + '\n'),
                                                                            'YAML|deep|single value'),
            ('a folder', folder_at('camera.yaml'), 'folder', 'file is expected'), ('a pipe', fifo('camera.yaml'), 'pipe', 'regular file'),
            ('/dev/zero', link('camera.yaml', '/dev/zero'), 'device', 'regular file'),
            ('/dev/full', link('camera.yaml', '/dev/full'), 'device', 'regular file'),
            ('a link to nothing', link('camera.yaml', 'gone.yaml'), "can't be opened"), ('2 GiB', large('camera.yaml', 1 << 31), 'MiB'),
            ('gone', remove('camera.yaml'), "can't be opened", 'No such file')):
        yield Kind('cameras', f'file: {name}', run('rgbd', '--camera', 'camera.yaml'), ['camera.yaml', *says], damage)
    yield Kind('cameras', 'file: not readable', run('rgbd', '--camera', 'camera.yaml'), ['camera.yaml', 'Permission denied'], locked('camera.yaml'),
               as_nobody=True)
    yield Kind('cameras', 'file: an image', run('rgbd', '--camera', 'image/first.png'), ['first.png', 'YAML|map'])
    yield Kind('cameras', 'file: a map', run('rgbd', '--camera', 'office.m'), ['office.m', 'YAML|map'])
    yield Kind('cameras', 'file: settings', run('rgbd', '--camera', 'settings.yaml'), ['settings.yaml:1', 'unknown key'])
    yield Kind('cameras', 'file: a name that is no UTF-8, and a wrong field', run('rgbd', '--camera', b'caf\xe9.yaml'),
               ['caf.*yaml:3', 'fx', 'must be'],
               both(replace('camera.yaml', 'fx: 250', 'fx: x'), rename('camera.yaml', 'caf\udce9.yaml')), needs=('camera.yaml',))
    for path, change, *says in (('rgbd/camera.yaml', line('rgbd/camera.yaml', 3, 'fx: nan'), ':3', 'fx', 'must be'),
                                ('rgbd/camera.yaml', empty('rgbd/camera.yaml'), 'map|empty'),
                                ('mono/camera.yaml', append('mono/camera.yaml', 'lens: 3\n'), 'lens', 'nearest')):
        yield Kind('cameras', f'{path} of a recording, {says[-1]}', run(path.split('/')[0]), [path, *says], change)
    yield Kind('cameras', 'none, of a TUM folder', run('rgbd'), ['rgbd', 'calibration', '--camera'], remove('rgbd/camera.yaml'))
    for name, row, *says in (('three numbers', '250 250 159.5', 'fx fy cx cy'), ('nan', 'nan 250 159.5 119.5', 'nan', 'finite'),
                             ('a negative fx', '-250 250 159.5 119.5', 'fx', 'positive'),
                             ('words', 'fx fy cx cy', "'fx'", 'finite'), ('empty', '', 'fx fy cx cy'), ('1e308', '1e308 250 159.5 119.5', 'fx|focal'),
                             ('a principal point outside', '250 250 1000 119.5', 'cx|principal')):
        yield Kind('cameras', f'calibration.txt: {name}', run('rgbd'), ['calibration.txt', *says],
                   both(remove('rgbd/camera.yaml'), write('rgbd/calibration.txt', row + '\n')))


KALIBR = ('cam0:\n  camera_model: pinhole\n  intrinsics: [250, 250, 159.5, 119.5]\n  distortion_model: radtan\n  distortion_coeffs: [0.1, 0, 0, 0]\n'
          '  resolution: [320, 240]\n')
ROS = ('image_width: 320\nimage_height: 240\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [250, 0, 159.5, 0, 250, 119.5, 0, 0, 1]\ndistortion_model: plumb_bob\n'
       'distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n')
COLMAP = '1 OPENCV 320 240 250 250 160 120 0.1 0 0 0\n'
OPEN3D = '{"width": 320, "height": 240, "intrinsic_matrix": [250, 0, 0, 0, 250, 0, 159.5, 119.5, 1]}\n'


def of_other_programs():
    def imported(name, file, content, *says):
        return Kind('cameras', f'import: {name}', ['check', '--import-camera', file, '--out', 'out/camera.yaml'], [file, *says], write(file, content),
                    needs=('out',))
    for old, new, *says in (('pinhole', 'omni', 'omni', 'pinhole'), ('radtan', 'fov', 'fov', 'radtan'),
                            ('[250, 250, 159.5, 119.5]', '[250, 250]', 'intrinsics', '4'),
                            ('[250, 250, 159.5, 119.5]', '[nan, 250, 159.5, 119.5]', 'intrinsics', 'finite'),
                            ('[320, 240]', '[320]', 'resolution', '2'),
                            ('[320, 240]', '[0, 240]', 'resolution|width'), ('[320, 240]', '320', 'resolution', 'list'),
                            ('[0.1, 0, 0, 0]', '[0.1]', 'distortion', '4'),
                            ('[0.1, 0, 0, 0]', '[1e308, 0, 0, 0]', 'distortion|coefficient|lens'),
                            ('[250, 250, 159.5, 119.5]', '[-250, 250, 159.5, 119.5]', 'fx|focal'),
                            ('  intrinsics: [250, 250, 159.5, 119.5]\n', '', 'intrinsics', 'missing')):
        yield imported(f'Kalibr, {new or "no intrinsics"} for {old.strip()[:12]}', 'chain.yaml', KALIBR.replace(old, new), *says)
    yield imported('Kalibr, a second camera without its place', 'chain.yaml', KALIBR + KALIBR.replace('cam0', 'cam1'), 'T_cn_cnm1')
    for old, new, *says in (('image_width: 320\n', '', 'image_width|width'), ('250, 0, 159.5', '250, 0', 'camera_matrix|K'),
                            ('plumb_bob', 'thin_prism', 'thin_prism'),
                            ('[0.1, 0, 0, 0, 0]', '[0.1]', 'distortion|D'), ('[250, 0', '[x, 0', 'camera_matrix', 'finite'),
                            ('[250, 0', '[0, 0', 'fx|focal')):
        yield imported(f'ROS, {new or "nothing"} for {old.strip()[:18]}', 'info.yaml', ROS.replace(old, new), *says)
    for old, new, *says in (('OPENCV', 'FOV', 'FOV', 'PINHOLE'), ('250 250', '250', 'OPENCV'), ('320 240', '-320 240', '64'),
                            ('0.1', 'nan', 'OPENCV'), ('250 250', '0 250', 'focal'),
                            ('1 OPENCV', 'x OPENCV', ':1'), ('160 120', '1600 120', 'principal')):
        yield imported(f'COLMAP, {new} for {old}', 'cameras.txt', COLMAP.replace(old, new), ':1', *says)
    yield imported('COLMAP, two cameras', 'cameras.txt', COLMAP + COLMAP.replace('1 ', '2 ', 1), 'second camera')
    for old, new, *says in (('"width": 320', '"width": "320"', 'width'), ('"width": 320', '"width": 1e99', 'width'),
                            ('250, 0, 0, 0', '250, 0, 0', 'intrinsic_matrix', 'nine'),
                            ('250, 0, 0, 0', '-250, 0, 0, 0', 'intrinsic_matrix', 'positive'), ('250, 0, 0, 0', '250, 7, 0, 0', 'intrinsic_matrix'),
                            ('[250', '[null', 'intrinsic_matrix', 'nine'),
                            ('}', '', 'JSON|YAML'), ('"height": 240, ', '', 'height'), ('[250', '[1e308', 'intrinsic_matrix|fx|focal'),
                            ('[250', '[' * 100000 + '250', 'JSON|intrinsic_matrix')):
        yield imported(f'Open3D, {new[:20] or "nothing"} for {old.strip()[:18]}', 'intrinsic_matrix.json', OPEN3D.replace(old, new), *says)
    for name, damage, *says in (('an empty file', empty('camera.yaml'), 'Kalibr'), ('a text', write('camera.yaml', 'hello\n'), 'Kalibr'),
                                ('a folder', folder_at('camera.yaml'), 'folder|Kalibr'),
                                ('a pipe', fifo('camera.yaml'), 'pipe'), ('binary', write('camera.yaml', bytes(range(256))), 'Kalibr|YAML'),
                                ('nothing', remove('camera.yaml'), "can't be opened|exist"),
                                ("Covis' own", write('camera.yaml', text()), 'Kalibr|Covis')):
        yield Kind('cameras', f'import: {name}', ['check', '--import-camera', 'camera.yaml', '--out', 'out/camera.yaml'], ['camera.yaml', *says],
                   damage)
