# SPDX-License-Identifier: Apache-2.0
"""The good inputs, and the older results that must survive, which every kind of bad input begins from."""
import pathlib
import shutil
import struct
import subprocess

from . import formats

FRAMES, RATE, WIDTH, HEIGHT, FOCAL = 12, 8, 320, 240, 250
ORIGIN = 1_500_000_000_000_000_000  # nanoseconds, of recordings whose stamps are times of day


class Material:
    def __init__(self, covis, folder):
        self.covis, self.folder = covis, folder

    def make(self):
        for sensor in ('rgbd', 'stereo', 'mono'):
            self.run('synth', 'room', '--sensor', sensor, '--frames', str(FRAMES), '--fps', str(RATE), '--width', str(WIDTH), '--height', str(HEIGHT),
                     '--noise', '2', '--quiet', '--out', sensor)
        shutil.copy(self.folder / 'rgbd/camera.yaml', self.folder / 'camera.yaml')
        shutil.copy(self.folder / 'mono/camera.yaml', self.folder / 'mono.yaml')
        (self.folder / 'settings.yaml').write_bytes(self.run('run', '--dump-config').stdout)
        self.recordings()
        self.vocabularies()
        self.results()
        self.boards()

    def run(self, *words):
        return subprocess.run([self.covis, *words], cwd=self.folder, check=True, capture_output=True)

    def put(self, name, data):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())

    def recordings(self):
        """The same few frames as recordings of each other kind."""
        rgb, depth = sorted((self.folder / 'rgbd/rgb').iterdir()), sorted((self.folder / 'rgbd/depth').iterdir())
        left, right = sorted((self.folder / 'stereo/image_0').iterdir()), sorted((self.folder / 'stereo/image_1').iterdir())
        for k in range(FRAMES):
            stamp = ORIGIN + k * 10**9 // RATE
            for camera, image in ((0, left[k]), (1, right[k])):
                self.put(f'euroc/mav0/cam{camera}/data/{stamp}.png', image.read_bytes())
            self.put(f'icl/rgb/{k}.png', rgb[k].read_bytes())
            self.put(f'icl/depth/{k}.png', depth[k].read_bytes())
            self.put(f'lounge/color/{stamp / 1e9:.6f}.png', rgb[k].read_bytes())
            self.put(f'lounge/aligned_depth/{stamp / 1e9:.6f}.png', depth[k].read_bytes())
            self.put(f'open3d/color/{k:06}.png', rgb[k].read_bytes())
            self.put(f'open3d/depth/{k:06}.png', depth[k].read_bytes())
            self.put(f'tartan/image_left/{k:06}_left.png', rgb[k].read_bytes())
            self.put(f'tartan/depth_left/{k:06}_left_depth.npy', formats.npy(WIDTH, HEIGHT, metres(depth[k].read_bytes())))
        self.lists()
        self.videos_and_bags(rgb)
        self.single_images(rgb[0])

    def lists(self):
        stamps = [ORIGIN + k * 10**9 // RATE for k in range(FRAMES)]
        for camera in (0, 1):
            self.put(f'euroc/mav0/cam{camera}/data.csv', '#timestamp [ns],filename\n' + ''.join(f'{t},{t}.png\n' for t in stamps))
            self.put(f'euroc/mav0/cam{camera}/sensor.yaml',
                     'sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: '
                     f'[1, 0, 0, {0.11 * camera}, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: {RATE}\nresolution: [{WIDTH}, {HEIGHT}]\n'
                     f'camera_model: pinhole\nintrinsics: [{FOCAL}, {FOCAL}, 159.5, 119.5]\ndistortion_model: radial-tangential\n'
                     'distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n')
        self.put('icl/associations.txt', ''.join(f'{k} depth/{k}.png {k} rgb/{k}.png\n' for k in range(FRAMES)))
        self.put('icl/room.gt.freiburg', ''.join(f'{k} 0 0 {0.01 * k} 0 0 0 1\n' for k in range(FRAMES)))
        for name, sub in (('color', 'color'), ('aligned_depth', 'aligned_depth')):
            self.put(f'lounge/{name}.txt', ''.join(f'{t / 1e9:.6f} {sub}/{t / 1e9:.6f}.png\n' for t in stamps))
        self.put('lounge/sensors.yaml', f'd400_color_optical_frame:\n  width: {WIDTH}\n  height: {HEIGHT}\n  fps: {RATE}\n'
                 f'  distortion_model: none\n  distortion_coefficients: [0, 0, 0, 0, 0]\n  intrinsics: [{FOCAL}, 159.5, {FOCAL}, 119.5]\n')
        self.put('open3d/camera_intrinsic.json',
                 f'{{"width": {WIDTH}, "height": {HEIGHT}, "intrinsic_matrix": [{FOCAL}, 0, 0, 0, {FOCAL}, 0, 159.5, 119.5, 1]}}\n')
        self.put('tartan/pose_left.txt', ''.join(f'{0.01 * k} 0 0 0 0 0 1\n' for k in range(FRAMES)))
        shutil.copy(self.folder / 'mono/camera.yaml', self.folder / 'tartan/camera.yaml')
        shutil.copy(self.folder / 'mono/camera.yaml', self.folder / 'icl/camera.yaml')

    def videos_and_bags(self, images):
        grey = [rows_of(image.read_bytes()) for image in images]
        frames = [formats.jpeg(WIDTH, HEIGHT, rows) for rows in grey]
        self.put('walk.avi', formats.avi(WIDTH, HEIGHT, RATE, frames))
        stamps = [ORIGIN + k * 10**9 // RATE for k in range(FRAMES)]
        formats.ros2_bag(self.folder / 'office.db3',
                         [('/camera/camera_info', 'sensor_msgs/msg/CameraInfo', ORIGIN, formats.camera_message(WIDTH, HEIGHT, FOCAL, 159.5, 119.5))] +
                         [('/camera/image_raw', 'sensor_msgs/msg/Image', t, formats.image_message(t, WIDTH, HEIGHT, 'mono8', b''.join(rows)))
                          for t, rows in zip(stamps, grey)])
        self.put('office.bag', formats.ros1_bag(b'/camera/image_raw', b'sensor_msgs/Image',
                                                [(t, formats.ros1_image(t, WIDTH, HEIGHT, 'mono8', b''.join(rows))) for t,
                                                 rows in zip(stamps, grey)]))

    def single_images(self, image):
        """The first image in each format; for kinds that put one into a recording."""
        rows = rows_of(image.read_bytes())
        for name, make in (('png', formats.png), ('pgm', formats.pgm), ('bmp', formats.bmp), ('tif', formats.tiff), ('jpg', formats.jpeg)):
            self.put(f'image/first.{name}', make(WIDTH, HEIGHT, rows))
        self.put('image/small.png', formats.png(64, 48, [row[:64] for row in rows[:48]]))
        self.put('image/deep.png', formats.png(WIDTH, HEIGHT, [b''.join(bytes((v, 0)) for v in row) for row in rows], 16))
        self.put('image/colour.png', formats.png(WIDTH, HEIGHT, [b''.join(bytes((v, v, v)) for v in row) for row in rows], 8, 2))

    def vocabularies(self):
        self.run('vocab', 'train', 'mono/images', '--branching', '4', '--depth', '3', '--quiet', '--out', 'words.covis-voc')
        self.run('vocab', 'convert', 'words.covis-voc', 'words.txt')

    def results(self):
        """Maps, and the older results that stand where a command is to write."""
        self.run('run', 'rgbd', '--quiet', '--out', 'out', '--save-map', 'office.m', '--keep-images')
        self.run('run', 'mono', '--quiet', '--out', 'mono_out', '--save-map', 'mono.m')
        for name in ('report.html', 'scene.bin', 'trajectory.png'):  # their sizes alone count
            self.put(f'out/{name}', (self.folder / 'out' / name).read_bytes()[:5000])
        for name in ('office.m', 'words.covis-voc', 'words.txt', 'camera.yaml'):
            shutil.copy(self.folder / name, self.folder / 'out' / name)
        self.put('out/picture.png', formats.png(8, 8, [bytes(8)] * 8))
        for name in ('trajectory.txt', 'keyframes.txt'):
            shutil.copy(self.folder / 'out' / name, self.folder / name)
        shutil.copy(self.folder / 'rgbd/groundtruth.txt', self.folder / 'truth.txt')
        shutil.copy(self.folder / 'stereo/poses.txt', self.folder / 'poses.txt')
        shutil.copy(self.folder / 'stereo/times.txt', self.folder / 'times.txt')
        self.run('map', 'export', 'office.m', '--to', 'colmap', '--out', 'colmap')
        for name in ('colmap', 'out'):
            assert (self.folder / name).is_dir()

    def boards(self):
        """Images that show a checkerboard of 9 x 6 inner corners from the front, at several places: no calibration, but a board."""
        for k in range(4):
            rows = []
            for y in range(HEIGHT):
                rows.append(bytes(255 * (not (0 <= x - 40 - 5 * k < 200 and 0 <= y - 40 - 5 * k < 140) or ((x - 40 - 5 * k) // 20 + (y - 40 - 5 * k) // 20) % 2)
                                  for x in range(WIDTH)))
            self.put(f'board/{k}.png', formats.png(WIDTH, HEIGHT, rows))


def rows_of(data):
    """Grey rows of a PNG in grey or colour."""
    _, _, step, rows = formats.read_png(data)
    return [row[::step] for row in rows]


def metres(data):
    _, _, _, rows = formats.read_png(data)
    return [value / 5000 for row in rows for value in struct.unpack(f'>{len(row) // 2}H', row)]


def make_material(covis, folder):
    pathlib.Path(folder).mkdir(parents=True)
    Material(covis, pathlib.Path(folder)).make()
