#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `covis map export` writes, read by those it is for: Debian's COLMAP, and readers of the formats.

  tests/exports/exports_test.py COVIS

A desk is rendered, tinted so that its images have colours, and mapped with COVIS (the command's file). The figures of
docs/exports.md are printed.
"""
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import matplotlib.image
import numpy as np

COVIS = sys.argv[1]
WORK = pathlib.Path(tempfile.mkdtemp(prefix='covis_exports'))
RECORDING, MAP = WORK / 'desk', WORK / 'desk.m'


def run(*command, code=0):
    """What the command wrote to both of its streams."""
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != code:
        raise AssertionError(f'{command}: exit code {done.returncode}\n{done.stdout}')
    return done.stdout


def setUpModule():
    run(COVIS, 'synth', 'desk', '--sensor', 'rgbd', '--out', RECORDING, '--frames', '60', '--fps', '10', '--width', '320',
        '--height', '240', '--distortion', '1')
    for file in (RECORDING / 'rgb').iterdir():
        grey = matplotlib.image.imread(file)
        matplotlib.image.imsave(file, np.dstack([grey, 1 - grey, np.full_like(grey, 0.2)]))
    run(COVIS, 'run', RECORDING, '--out', WORK / 'out', '--save-map', MAP, '--keep-images', '--quiet')


def tearDownModule():
    shutil.rmtree(WORK)


def export(to, name, *more):
    out = WORK / name
    run(COVIS, 'map', 'export', MAP, '--to', to, '--out', out, *more)
    return out


def rotation_of(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def info():
    return json.loads(run(COVIS, 'map', 'info', MAP, '--json'))


def contents(folder):
    """The bytes of each file in a folder, by its name."""
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob('*') if f.is_file()}


def analysed(model):
    """Figures of COLMAP's model_analyzer."""
    text = run('colmap', 'model_analyzer', '--path', model)
    return {name: float(value) for name, value in re.findall(r'^(?:.*\] )?([A-Z][a-z ]+): ([0-9.]+)', text, re.MULTILINE)}


def read_model(folder):
    """Reads a COLMAP model in text: the positions of its points by id, and of each image by name the rows x, y, id of point."""
    def lines_of(name):
        return [line for line in (folder / name).read_text().splitlines() if not line.startswith('#')]
    points = {int(line.split()[0]): np.array(line.split()[1:4], float) for line in lines_of('points3D.txt')}
    images, lines = {}, lines_of('images.txt')
    for head, keypoints in zip(lines[::2], lines[1::2]):
        rows = np.array(keypoints.split(), float).reshape(-1, 3)
        images[head.split()[-1]] = rows[rows[:, 2] >= 0]
    return points, images


def reprojection_errors(folder):
    """Returns the reprojection error of each observation of a COLMAP model in text, pixels, by the id of its point."""
    points, images = read_model(folder)
    fx, fy, cx, cy = (float(v) for v in (folder / 'cameras.txt').read_text().splitlines()[-1].split()[4:8])
    errors = {}
    for line in (folder / 'images.txt').read_text().splitlines()[2::2]:
        *pose, _, name = line.split()[1:]
        w, x, y, z, *t = (float(v) for v in pose)
        for u, v, point in images[name]:
            at = rotation_of(w, x, y, z) @ points[int(point)] + t
            error = np.hypot(fx * at[0] / at[2] + cx - u, fy * at[1] / at[2] + cy - v) if at[2] > 0 else np.inf
            errors.setdefault(int(point), []).append(error)
    return errors


def distances(model, other):
    """Between points of two models that were seen within a pixel in the same image, each by its distance from the first camera."""
    (points, images), (other_points, other_images) = model, other
    pairs = set()
    for name, rows in images.items():
        apart = np.linalg.norm(rows[:, None, :2] - other_images[name][None, :, :2], axis=2)
        for row, nearest in enumerate(apart.argmin(axis=1)):
            if apart[row, nearest] < 1:
                pairs.add((int(rows[row, 2]), int(other_images[name][nearest, 2])))
    return [np.linalg.norm(points[a] - other_points[b]) / np.linalg.norm(points[a]) for a, b in sorted(pairs)]


class Colmap(unittest.TestCase):
    def test_colmap_reads_the_model(self):
        model = export('colmap', 'colmap') / 'sparse/0'
        figures = analysed(model)
        self.assertEqual(figures['Registered images'], info()['key_frames'])
        self.assertGreater(figures['Points'], 300)
        self.assertLess(figures['Mean reprojection error'], 1)
        errors = reprojection_errors(model)
        self.assertLessEqual(max(map(max, errors.values())), 4.001)
        self.assertGreaterEqual(min(map(len, errors.values())), 2)
        self.assertEqual(sum(map(len, errors.values())), figures['Observations'])
        self.assertAlmostEqual(np.mean([np.mean(e) for e in errors.values()]), figures['Mean reprojection error'], delta=1e-3)
        self.assertGreater(figures['Mean track length'], 2)
        print(f"our model: {figures['Points']:.0f} points, mean reprojection error {figures['Mean reprojection error']:.2f} pixels")

    def test_its_own_triangulation_from_these_poses_agrees(self):
        out = export('colmap', 'colmap_again')
        camera = (out / 'sparse/0/cameras.txt').read_text().splitlines()[-1].split()
        database = out / 'database.db'
        run('colmap', 'feature_extractor', '--database_path', database, '--image_path', out / 'images',
            '--ImageReader.single_camera', '1', '--ImageReader.camera_model', 'PINHOLE',
            '--ImageReader.camera_params', ','.join(camera[4:]), '--SiftExtraction.use_gpu', '0',
            '--SiftExtraction.num_threads', '2')
        run('colmap', 'exhaustive_matcher', '--database_path', database, '--SiftMatching.use_gpu', '0',
            '--SiftMatching.num_threads', '2')
        (out / 'triangulated').mkdir()
        run('colmap', 'point_triangulator', '--database_path', database, '--image_path', out / 'images',
            '--input_path', out / 'sparse/0', '--output_path', out / 'triangulated', '--clear_points', '1',
            '--Mapper.ba_refine_focal_length', '0', '--Mapper.ba_refine_extra_params', '0')
        figures = analysed(out / 'triangulated')
        self.assertEqual(figures['Registered images'], info()['key_frames'])
        self.assertGreater(figures['Points'], 200)
        self.assertLess(figures['Mean reprojection error'], 1)
        run('colmap', 'model_converter', '--input_path', out / 'triangulated', '--output_path', out / 'triangulated',
            '--output_type', 'TXT')
        apart = distances(read_model(out / 'triangulated'), read_model(out / 'sparse/0'))
        self.assertGreater(len(apart), 50)
        self.assertLess(np.median(apart), 0.01)
        print(f"COLMAP's points: {figures['Points']:.0f}, mean reprojection error {figures['Mean reprojection error']:.2f} pixels; "
              f"{len(apart)} of them are {100 * np.median(apart):.2f} % of their distance from ours (median)")

    def test_without_images_the_model_is_written_and_that_is_said(self):
        alone = WORK / 'alone.m'
        shutil.copy(MAP, alone)
        text = run(COVIS, 'map', 'export', alone, '--to', 'colmap', '--out', WORK / 'alone')
        self.assertIn('--keep-images', text)
        figures, aligned = analysed(WORK / 'alone/sparse/0'), analysed(export('colmap', 'with_images') / 'sparse/0')
        self.assertLess(figures['Mean reprojection error'], 1)
        self.assertLess(aligned['Mean reprojection error'], 0.8 * figures['Mean reprojection error'])
        self.assertGreater(aligned['Points'], 0.98 * figures['Points'])
        self.assertGreater(aligned['Observations'], 0.9 * figures['Observations'])
        print(f"without images: {figures['Points']:.0f} points, mean reprojection error {figures['Mean reprojection error']:.2f} pixels")


class Import(unittest.TestCase):
    def test_images_are_found_in_a_map_made_of_a_model(self):
        """Of the model exported; poses are those of the run in whose world it is."""
        out = export('colmap', 'to_import')
        run(COVIS, 'map', 'import', out / 'sparse/0', '--images', out / 'images', '--out', WORK / 'imported.m')
        imported = json.loads(run(COVIS, 'map', 'info', WORK / 'imported.m', '--json'))
        self.assertEqual(imported['key_frames'], info()['key_frames'])
        self.assertGreater(imported['points'], 200)
        (out / 'binary').mkdir()
        run('colmap', 'model_converter', '--input_path', out / 'sparse/0', '--output_path', out / 'binary', '--output_type', 'BIN')
        run(COVIS, 'map', 'import', out / 'binary', '--images', out / 'images', '--out', WORK / 'binary.m')
        self.assertEqual((WORK / 'binary.m').read_bytes(), (WORK / 'imported.m').read_bytes(), 'the binary model is the same')
        # All frames, by the lens with distortion; the model has the undistorted images of a few.
        text = run(COVIS, 'localize', RECORDING, '--sensor', 'mono', '--map', WORK / 'imported.m', '--out', WORK / 'found.txt')
        found, path = np.loadtxt(WORK / 'found.txt', ndmin=2), np.loadtxt(WORK / 'out/trajectory.txt')
        self.assertGreater(len(found), 0.8 * len(path), text)
        errors = [np.linalg.norm(row[1:4] - path[np.argmin(abs(path[:, 0] - row[0])), 1:4]) for row in found]
        self.assertLess(np.median(errors), 0.02)
        self.assertLess(max(errors), 0.1)

    def test_what_is_no_model_is_said(self):
        for folder, message in ((WORK, 'cameras.txt: there is no such file'), (WORK / 'none', 'no such file')):
            self.assertIn(message, run(COVIS, 'map', 'import', folder, '--images', WORK, '--out', WORK / 'x.m', code=1))
        out = export('colmap', 'damaged')
        images = out / 'sparse/0/images.txt'
        images.write_text(images.read_text().replace('1 ', 'one ', 1))
        text = run(COVIS, 'map', 'import', out / 'sparse/0', '--images', out / 'images', '--out', WORK / 'x.m', code=1)
        self.assertRegex(text, r'images.txt:\d+: ')
        self.assertFalse((WORK / 'x.m').exists())


class OtherFormats(unittest.TestCase):
    def test_points_have_normals_and_the_colours_of_the_images(self):
        data = export('ply', 'map.ply').read_bytes()
        head, body = data.split(b'end_header\n', 1)
        count = int(re.search(rb'element vertex (\d+)', head).group(1))
        points = list(struct.iter_unpack('<6f3B', body))
        self.assertEqual(len(points), count)
        self.assertGreater(count, 500)
        for *_, red, green, blue in points:
            self.assertLessEqual(abs(red + green - 255), 3)
            self.assertLessEqual(abs(blue - 51), 1)
        self.assertGreater(max(p[6] for p in points) - min(p[6] for p in points), 50)

    def test_nerfstudio_finds_its_images(self):
        out = export('nerfstudio', 'nerf')
        transforms = json.loads((out / 'transforms.json').read_text())
        self.assertEqual(len(transforms['frames']), info()['key_frames'])
        for frame in transforms['frames']:
            self.assertEqual(matplotlib.image.imread(out / frame['file_path']).shape[:2], (240, 320))
            rotation = np.array(frame['transform_matrix'])[:3, :3]
            np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
        self.assertTrue((out / transforms['ply_file_path']).exists())

    def test_poses_come_round_trip(self):
        """TUM, KITTI and COLMAP hold one pose: that of the key frames' file of the run."""
        tum = np.loadtxt(export('tum', 'path.txt'))
        np.testing.assert_allclose(tum, np.loadtxt(WORK / 'out/keyframes.txt'), atol=1e-6)
        kitti = np.loadtxt(export('kitti', 'kitti.txt')).reshape(-1, 3, 4)
        np.testing.assert_allclose(kitti[:, :, 3], tum[:, 1:4], atol=1e-5)
        lines = (export('colmap', 'poses') / 'sparse/0/images.txt').read_text().splitlines()[2::2]
        for line, pose in zip(lines, kitti):
            w, x, y, z, *t = (float(v) for v in line.split()[1:8])
            rotation = rotation_of(w, x, y, z)
            np.testing.assert_allclose(rotation.T, pose[:, :3], atol=1e-5)
            np.testing.assert_allclose(-rotation.T @ t, pose[:, 3], atol=1e-5)

    def test_bundler_and_geojson_are_written(self):
        out = export('bundler', 'bundler')
        self.assertEqual((out / 'bundle.out').read_text().splitlines()[1].split()[0], str(info()['key_frames']))
        for line in (out / 'list.txt').read_text().splitlines():
            self.assertTrue((out / line.split()[0]).exists())
        centred = contents(out / 'images_centred')
        export('colmap', 'bundler')
        self.assertEqual(contents(out / 'images_centred'), centred, 'images of another shape are beside them')
        self.assertEqual(set(contents(out / 'images')), set(centred))
        path = json.loads(export('geojson', 'path.geojson', '--origin', '48.2', '16.4', '--heading', '30').read_text())
        line = path['features'][0]['geometry']['coordinates']
        self.assertEqual(len(line), info()['key_frames'])
        np.testing.assert_allclose(line[0], [16.4, 48.2, 0], atol=1e-6)

    def test_a_map_of_one_camera_has_no_metres(self):
        mono, path, cloud = WORK / 'mono.m', WORK / 'mono.geojson', WORK / 'mono.ply'
        run(COVIS, 'run', RECORDING, '--sensor', 'mono', '--out', WORK / 'mono', '--save-map', mono, '--quiet')
        geojson = [COVIS, 'map', 'export', mono, '--to', 'geojson', '--origin', '48', '16', '--out', path]
        said = run(*geojson, code=1)
        self.assertIn('--scale METRES is missing', said)
        self.assertIn('mono.m', said)
        self.assertFalse(path.exists())
        run(*geojson, '--scale', '1')
        self.assertIn('units of the map', run(COVIS, 'map', 'info', mono))
        self.assertIn('extent_units', json.loads(run(COVIS, 'map', 'info', mono, '--json')))
        run(COVIS, 'map', 'export', mono, '--to', 'ply', '--out', cloud)
        for file in (cloud, WORK / 'mono/map.ply'):
            self.assertIn(b'comment map points, units of the map\n', file.read_bytes())
        self.assertIn('extent_m', info())

    def test_models_of_an_earlier_export_are_not_left(self):
        for to, first, second in (('colmap', 'sparse/0', 'sparse/1'), ('nerfstudio', 'transforms.json', 'transforms_map1.json'),
                                  ('bundler', 'bundle.out', 'bundle_map1/bundle.out')):
            out = export(to, f'left_{to}')
            if to == 'colmap':
                shutil.copytree(out / first, out / second)
                (out / 'sparse/2').mkdir()
                (out / 'sparse/2/cameras.txt').write_text('1 PINHOLE by hand')
            else:
                (out / second).parent.mkdir(exist_ok=True)
                shutil.copy(out / first, out / second)
            export(to, f'left_{to}')
            self.assertTrue((out / first).exists())
            self.assertFalse((out / second).exists(), to)
        self.assertTrue((WORK / 'left_colmap/sparse/2/cameras.txt').exists())
        cloud, second = (WORK / f'left{end}.ply' for end in ('', '_map1'))
        run(COVIS, 'map', 'export', MAP, '--to', 'ply', '--out', cloud)
        shutil.copy(cloud, second)
        self.assertIn('left_map1.ply: it was there before', run(COVIS, 'map', 'export', MAP, '--to', 'ply', '--out', cloud))
        self.assertTrue(second.exists(), 'a cloud may be of another map')

    def test_the_command_counts_what_is_written(self):
        for to, more in (('tum', ()), ('geojson', ('--origin', '48', '16'))):
            said = run(COVIS, 'map', 'export', MAP, '--to', to, '--out', WORK / f'counted.{to}', *more)
            self.assertIn(f"{info()['key_frames']} key frames of 1 map", said)

    def test_a_picture_from_above(self):
        run(COVIS, 'map', 'info', MAP, '--picture', WORK / 'above.png')
        picture = (255 * matplotlib.image.imread(WORK / 'above.png')[:, :, :3]).astype(int)
        for what, colour in {'points': (150, 160, 175), 'path': (200, 40, 30)}.items():
            drawn = (abs(picture - colour).max(axis=2) < 30).sum()
            self.assertGreater(drawn, 300, what)


class Refused(unittest.TestCase):
    def refusal(self, *arguments):
        return run(COVIS, 'map', 'export', *arguments, code=1)

    def test_what_is_wrong_is_named(self):
        out = WORK / 'nothing'
        self.assertIn('--origin', self.refusal(MAP, '--to', 'geojson', '--out', out))
        self.assertIn('--heading', self.refusal(MAP, '--to', 'geojson', '--out', out, '--origin', '1', '1', '--heading', 'nan'))
        self.assertIn('latitude', self.refusal(MAP, '--to', 'geojson', '--out', out, '--origin', '91', '0'))
        self.assertIn('--origin: it says nothing to the format ply',
                      self.refusal(MAP, '--to', 'ply', '--out', out, '--origin', '1', '1'))
        self.assertIn('nowhere', self.refusal(MAP, '--to', 'colmap', '--out', out, '--images', WORK / 'nowhere'))
        self.assertIn('missing.m', self.refusal(WORK / 'missing.m', '--to', 'ply', '--out', out))
        self.assertFalse(out.exists())

    def test_a_folder_that_cant_be_made_is_said(self):
        self.assertIn('/dev/full', self.refusal(MAP, '--to', 'colmap', '--out', '/dev/full/model'))


class FullDisk(unittest.TestCase):
    """A limit on the size of files is to the command what a full disk is."""
    def limited(self, size, *command):
        """Exit code and messages, where no file may have more than so many bytes."""
        done = subprocess.run(['prlimit', f'--fsize={size}', *(str(c) for c in command)], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        return done.returncode, [line for line in done.stdout.splitlines() if not line.startswith('info: ')]

    def test_each_export_says_so_once_and_leaves_nothing(self):
        """Each file but the largest fits, so that a folder is half written when the export fails."""
        for to, more in (('ply', ()), ('kitti', ()), ('geojson', ('--origin', '48', '16')), ('colmap', ()), ('nerfstudio', ()),
                         ('bundler', ())):
            with self.subTest(to=to):
                beside = WORK / f'full_{to}'
                beside.mkdir()
                out = beside / 'out'
                command = [COVIS, 'map', 'export', MAP, '--to', to, '--out', out, *more]
                run(*command)
                whole = contents(beside)
                made = set(beside.iterdir())
                largest = max(whole, key=lambda name: len(whole[name]))
                for there in (whole, {}):
                    code, messages = self.limited(len(whole[largest]) - 1, *command)
                    self.assertEqual((code, contents(beside)), (1, there))
                    self.check_message(messages, beside / largest)
                    self.assertEqual(set(beside.iterdir()), made if there else set())
                    for path in beside.iterdir():
                        shutil.rmtree(path) if path.is_dir() else path.unlink()

    def check_message(self, messages, file):
        self.assertEqual(messages, [f"error: {file}: it can't be written: File too large"])

    def test_a_run_says_so_and_leaves_no_file_that_is_cut_off(self):
        out, saved = WORK / 'full_run', WORK / 'full_maps/desk.m'
        saved.parent.mkdir()
        command = [COVIS, 'run', RECORDING, '--count', '10', '--quiet', '--out', out]
        code, messages = self.limited(2000, *command)
        self.assertEqual(code, 1)
        self.check_message(messages, out / 'map.ply')
        self.assertIn('keyframes.txt', contents(out))
        self.assertLess(max(map(len, contents(out).values())), 2001)
        code, messages = self.limited(20000, *command, '--save-map', saved)
        self.assertEqual((code, contents(saved.parent)), (1, {}))
        self.assertEqual([m for m in messages if 'desk.m' in m], [f"error: {saved}: it can't be written: File too large"])

    def test_a_disk_that_says_so_at_the_end_leaves_the_old_file(self):
        """As network file systems do: close() has the error, after every write was taken."""
        source, late, file = WORK / 'late.c', WORK / 'late.so', WORK / 'late.ply'
        source.write_text(LATE)
        run('cc', '-shared', '-fPIC', '-o', late, source)
        file.write_text('ply\nold')  # of the kind that is replaced
        text = run('env', f'LD_PRELOAD={late}', COVIS, 'map', 'export', MAP, '--to', 'ply', '--out', file, code=1)
        self.assertIn(f"{file}: it can't be written: No space left on device", text)
        self.assertEqual(file.read_text(), 'ply\nold')


LATE = r"""
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
int close(int handle) {
  struct stat status;
  const int flags = fcntl(handle, F_GETFL);
  const int written = flags >= 0 && (flags & O_ACCMODE) == O_WRONLY && fstat(handle, &status) == 0 &&
                      S_ISREG(status.st_mode) && status.st_size > 0;
  const int closed = (int)syscall(SYS_close, handle);
  if (written) errno = ENOSPC;
  return written ? -1 : closed;
}
"""


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
