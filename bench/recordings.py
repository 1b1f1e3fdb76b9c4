# SPDX-License-Identifier: Apache-2.0
"""Recordings as bench/suite finds them: what a folder holds, which sensors it allows, how `covis run` reads it, and where its truth is."""
import hashlib
import pathlib
import re
import struct

from trajectories import read_positions, rotation_of

CAMERAS = pathlib.Path(__file__).resolve().parent.parent / 'cameras'
LARGE_IMAGE = 1000  # pixels: a wider image of a car's camera gets LARGE_FEATURES
LARGE_FEATURES = 2000
FAR_BASELINE = 0.3  # metres: a rendered stereo pair wider than that is on a car, and its depth images end too near to be of use
TRUTH_OFFSET = 1000  # seconds: in rendered photo worlds the truth's stamps are ahead of times.txt
IMAGES = ('.png', '.jpg', '.jpeg', '.pgm', '.bmp')


def images_in(folder):
    return sorted(file for file in folder.iterdir() if file.suffix.lower() in IMAGES)


def lines_of(file):
    return [line.split() for line in file.read_text().splitlines() if line.strip() and not line.lstrip().startswith('#')]


def width_of(image):
    """The width of a PNG file in pixels; 0 for others."""
    head = image.read_bytes()[:24] if image.suffix.lower() == '.png' else b''
    return struct.unpack('>I', head[16:20])[0] if head[:8] == b'\x89PNG\r\n\x1a\n' else 0


class Recording:
    """A folder that `covis run` reads, as it is or after it was laid out."""

    kind = None

    def __init__(self, folder):
        self.folder, self.name, self.camera = folder, folder.name, None

    def sensors(self):
        raise NotImplementedError

    def images(self):
        """The images of the first camera."""
        raise NotImplementedError

    def truth(self, _sensor):
        """(seconds, position of the first camera) by rising stamp; empty without truth."""
        file = self.folder / 'groundtruth.txt'
        return read_positions(file) if file.exists() else []

    def source(self, _sensor, _work):
        """The folder for `covis run`; what has to be laid out for it goes into the folder `work`."""
        return self.folder

    def settings(self):
        return []

    def arguments(self, sensor, work):
        camera = ['--camera', str(self.camera)] if self.camera else []
        return ['run', str(self.source(sensor, work)), '--sensor', sensor, *camera, *(f'--set={s}' for s in self.settings())]

    def fingerprint(self):
        """Changes when a file of the recording does (by size and time) or its camera file."""
        digest = hashlib.sha256()
        for file in sorted(self.folder.rglob('*')):
            if file.is_file():
                stat = file.stat()
                digest.update(f'{file.relative_to(self.folder)} {stat.st_size} {stat.st_mtime_ns}\n'.encode())
        if self.camera:
            digest.update(self.camera.read_bytes())
        return digest.hexdigest()


class Tum(Recording):
    kind = 'TUM'

    def sensors(self):
        depth = any((self.folder / name).exists() for name in ('depth.txt', 'associations.txt'))
        return ['rgbd', 'mono'] if depth else ['mono']

    def images(self):
        listed = self.folder / 'rgb.txt'
        return [self.folder / row[1] for row in lines_of(listed if listed.exists() else self.folder / 'associations.txt')]


class Images(Recording):
    kind = 'images'

    def sensors(self):
        return ['mono']

    def images(self):
        return images_in(self.folder / 'images')


class Kitti(Recording):
    kind = 'KITTI'

    def sensors(self):
        stereo = any((self.folder / right).is_dir() and (self.folder / left).is_dir() for left, right in (('image_0', 'image_1'), ('image_2', 'image_3')))
        return ['stereo', 'mono'] if stereo else ['mono']

    def images(self):
        return images_in(self.folder / ('image_0' if (self.folder / 'image_0').is_dir() else 'image_2'))

    def truth(self, sensor):
        poses, times = self.folder / 'poses.txt', self.folder / 'times.txt'
        if poses.exists() and times.exists():
            return sorted((float(time[0]), tuple(float(row[k]) for k in (3, 7, 11))) for time, row in zip(lines_of(times), lines_of(poses)))
        in_frames = self.folder / 'groundtruth_tum.txt'
        return read_positions(in_frames) if in_frames.exists() else super().truth(sensor)

    def settings(self):
        return [f'orb.features={LARGE_FEATURES}'] if width_of(self.images()[0]) > LARGE_IMAGE else []


class Euroc(Recording):
    kind = 'EuRoC'

    def sensors(self):
        return ['stereo', 'mono'] if (self.folder / 'mav0' / 'cam1').is_dir() else ['mono']

    def images(self):
        return images_in(self.folder / 'mav0' / 'cam0' / 'data')

    def truth(self, _sensor):
        """The body's poses, moved to the first camera."""
        base = self.folder / 'mav0'
        files = [file for file in (base / name / 'data.csv' for name in ('state_groundtruth_estimate0', 'mocap0')) if file.exists()]
        sensor = base / 'cam0' / 'sensor.yaml'
        if not files or not sensor.exists():
            return []
        data = re.search(r'T_BS:.*?data:\s*\[(.*?)\]', sensor.read_text(), re.DOTALL)
        camera = [float(data.group(1).split(',')[k]) for k in (3, 7, 11)] if data else [0.0] * 3
        poses = []
        for line in files[0].read_text().splitlines():
            if line and not line.startswith('#'):
                stamp, *values = line.split(',')
                poses.append((int(stamp) / 1e9, moved(list(map(float, values[:3])), list(map(float, values[3:7])), camera)))
        return sorted(poses)


def moved(position, quaternion, offset):
    """position + R offset; the quaternion has w first."""
    return tuple(p + sum(r * o for r, o in zip(row, offset)) for p, row in zip(position, rotation_of(quaternion)))


class PhotoWorld(Recording):
    """A rendered world of photographs: left/, right/, depth/, times.txt from 0 on, truth from 1000 s on, calib.txt, camera.txt."""

    kind = 'photo world'

    def __init__(self, folder):
        super().__init__(folder)
        self.values = {row[0]: row[1] for row in lines_of(folder / 'camera.txt')}

    def on_a_car(self):
        return float(self.values['baseline_m']) > FAR_BASELINE

    def sensors(self):
        return ['stereo', 'mono'] if self.on_a_car() else ['stereo', 'rgbd', 'mono']

    def images(self):
        return images_in(self.folder / 'left')

    def settings(self):
        return [f'orb.features={LARGE_FEATURES}'] if int(self.values['width']) > LARGE_IMAGE else []

    def truth(self, sensor):
        offset = 0 if sensor == 'rgbd' else TRUTH_OFFSET
        return [(stamp - offset, position) for stamp, position in read_positions(self.folder / 'groundtruth.txt')]

    def source(self, sensor, work):
        name = f"{self.name}-{hashlib.sha256(str(self.folder).encode()).hexdigest()[:8]}-{'rgbd' if sensor == 'rgbd' else 'stereo'}"
        layout = work / 'layouts' / name
        layout.mkdir(parents=True, exist_ok=True)
        if sensor == 'rgbd':
            links = {name: name for name in ('rgb.txt', 'depth.txt', 'left', 'depth', 'groundtruth.txt')}
            camera = ''.join(f'{key}: {self.values[key]}\n' for key in ('width', 'height', 'fx', 'fy', 'cx', 'cy', 'fps', 'depth_scale'))
            (layout / 'camera.yaml').write_text(camera)
        else:
            links = {'image_0': 'left', 'image_1': 'right', 'calib.txt': 'calib.txt', 'times.txt': 'times.txt'}
            rows = lines_of(self.folder / 'groundtruth.txt')
            (layout / 'groundtruth_tum.txt').write_text(''.join(f'{float(row[0]) - TRUTH_OFFSET:.6f} {" ".join(row[1:])}\n' for row in rows))
        for link, target in links.items():
            if not (layout / link).is_symlink():
                (layout / link).symlink_to(self.folder / target)
        return layout


def open_recording(folder):
    """The recording a folder holds, or None."""
    if (folder / 'camera.txt').exists() and (folder / 'left').is_dir() and (folder / 'times.txt').exists():
        return PhotoWorld(folder)
    if (folder / 'mav0' / 'cam0').is_dir():
        return Euroc(folder)
    if (folder / 'image_0').is_dir() or (folder / 'image_2').is_dir():
        return Kitti(folder)
    if (folder / 'rgb.txt').exists() or (folder / 'associations.txt').exists():
        return Tum(folder)
    if (folder / 'images').is_dir() and (folder / 'camera.yaml').exists():
        return Images(folder)
    return None


def find_recordings(folder, depth=3):
    """The recording in a folder, or those in the folders it holds."""
    recording = open_recording(folder)
    if recording:
        return [recording]
    inside = sorted(path for path in folder.iterdir() if path.is_dir()) if depth > 0 else []
    return [recording for path in inside for recording in find_recordings(path, depth - 1)]


def choose_cameras(recordings, given):
    """Camera files: those given by the recording's name, else, for a TUM folder without one, the file in cameras/ whose name is part of it."""
    for recording in recordings:
        if recording.name in given:
            recording.camera = pathlib.Path(given[recording.name]).resolve()
        elif isinstance(recording, Tum) and not any((recording.folder / name).exists() for name in ('camera.yaml', 'calibration.txt')):
            known = [file for file in sorted(CAMERAS.glob('*.yaml')) if file.stem in recording.name]
            recording.camera = known[0] if known else None
