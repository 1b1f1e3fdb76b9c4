# SPDX-License-Identifier: Apache-2.0
import gc
import json
import pathlib
import subprocess
import sys
import threading
import tracemalloc
import types

import numpy as np
import pytest

import covis
import golden
from conftest import COVIS, ROOT, system, track_all

WIDTH, HEIGHT = 160, 120
SMALL = covis.Camera(WIDTH, HEIGHT, 130, 130, 80, 60)


# ---- The same bytes as in C++ ----

@pytest.mark.parametrize('name', ['desk_rgbd', 'desk_mono', 'street_stereo'])
def test_a_trajectory_has_the_bytes_of_the_command(recording, tmp_path, name):
    source = covis.Recording(recording(name))
    slam = system(source)
    results = track_all(slam, source)
    slam.finish()
    mine = tmp_path / 'mine.txt'
    slam.trajectory().save(str(mine))
    assert sum(r.tracked for r in results) >= 0.9 * len(results)
    sums = json.loads((pathlib.Path(golden.HERE) / 'sums.json').read_text()).get(golden.platform_key())
    if sums:  # to which the test `golden` holds the command
        assert golden.md5(mine.read_bytes()) == sums[name]['trajectory.txt']
    else:
        subprocess.run([COVIS, 'run', recording(name), '--quiet', '--out', tmp_path / 'out'], check=True)
        assert mine.read_bytes() == (tmp_path / 'out' / 'trajectory.txt').read_bytes()


# ---- What comes out ----

def test_a_result_says_where_the_camera_is(desk):
    slam, results, _ = desk
    last = results[-1]
    assert last.state == covis.TrackingState.tracking and last.reason == covis.NoPoseReason.none
    matrix = last.pose.matrix
    assert matrix.shape == (4, 4)
    assert np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-9)
    back = covis.Pose.from_matrix(matrix)
    assert np.allclose(abs(np.dot([back.qx, back.qy, back.qz, back.qw],
                                  [last.pose.qx, last.pose.qy, last.pose.qz, last.pose.qw])), 1)
    assert last.covariance.shape == (6, 6)
    assert np.all(np.linalg.eigvalsh(last.covariance) > 0)
    pixels, ids, places = slam.tracked_points()
    count = len(ids)
    assert count > last.inliers if last.key_frame else count == last.inliers  # a key frame has new points as well
    assert pixels.shape == (count, 2) and places.shape == (count, 3)
    assert pixels[:, 0].max() < 320 and pixels[:, 1].max() < 240


def test_every_rotation_is_a_matrix_and_back():
    random = np.random.default_rng(1)
    for _ in range(50):
        q = random.normal(size=4)
        q /= np.linalg.norm(q)
        pose = covis.Pose(1, 2, 3, *q)
        back = covis.Pose.from_matrix(pose.matrix)
        assert np.isclose(abs(np.dot(q, [back.qx, back.qy, back.qz, back.qw])), 1)
        assert (back.x, back.y, back.z) == (1, 2, 3)


TURN = np.array([[0., -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]])


def changed(array, place, value):
    array = np.array(array, float)
    array[place] = value
    return array


@pytest.mark.parametrize('matrix, message', [
    (TURN[:3], r'matrix: a shape \(4, 4\) is wanted'),
    (changed(TURN, (0, 0), np.nan), 'matrix: finite numbers are wanted'),
    (changed(TURN, (2, 3), np.inf), 'matrix: finite numbers are wanted'),
    (changed(TURN, (3, 0), 0.5), 'matrix: a last row of 0, 0, 0, 1 is wanted'),
    (TURN.T, 'matrix: a last row of 0, 0, 0, 1 is wanted'),
    (np.diag([2., 2, 2, 1]), 'matrix: a rotation is wanted'),
    (np.diag([1., 1, -1, 1]), 'matrix: a rotation is wanted'),
    (np.diag([0., 0, 0, 1]), 'matrix: a rotation is wanted'),
])
def test_matrices_that_are_no_poses_are_refused(matrix, message):
    with pytest.raises(ValueError, match=message):
        covis.Pose.from_matrix(matrix)


def test_a_matrix_as_exact_as_text_is_a_pose():
    pose = covis.Pose.from_matrix(np.round(covis.Pose(1, 2, 3, 0.1, 0.3, 0.5, 0.65 ** 0.5).matrix, 3).astype(np.float32))
    assert np.isclose(pose.qx ** 2 + pose.qy ** 2 + pose.qz ** 2 + pose.qw ** 2, 1)
    assert np.allclose([pose.x, pose.y, pose.z, pose.qx, pose.qy, pose.qz], [1, 2, 3, 0.1, 0.3, 0.5], atol=1e-3)


PLACES, TURNS = np.zeros((3, 3)), np.tile([0., 0, 0, 1], (3, 1))


@pytest.mark.parametrize('positions, quaternions, message', [
    (PLACES[:2], TURNS, r'positions: a shape \(n, 3\)'),
    (PLACES, TURNS[:, :3], r'quaternions: a shape \(n, 4\)'),
    (changed(PLACES, (1, 2), np.nan), TURNS, 'positions: finite numbers are wanted in row 1'),
    (changed(PLACES, (2, 0), -np.inf), TURNS, 'positions: finite numbers are wanted in row 2'),
    (PLACES, changed(TURNS, (2, 3), np.nan), 'quaternions: a unit quaternion is wanted in row 2'),
    (PLACES, changed(TURNS, (0, 3), 0), 'quaternions: a unit quaternion is wanted in row 0'),
    (PLACES, changed(TURNS, (1, 0), 1), 'quaternions: a unit quaternion is wanted in row 1'),
])
def test_trajectories_that_are_none_are_refused(positions, quaternions, message):
    assert len(covis.Trajectory([1, 2, 3], PLACES, TURNS)) == 3
    with pytest.raises(ValueError, match=message):
        covis.Trajectory([1, 2, 3], positions, quaternions)


def test_quaternions_nearly_of_length_1_become_rotations():
    path = covis.Trajectory([1, 2, 3], PLACES, TURNS * 1.009)
    assert np.allclose(np.linalg.norm(path.quaternions, axis=1), 1, atol=1e-12)
    covis.Pose.from_matrix(path[0].matrix)


@pytest.mark.parametrize('seconds', [0, -1, np.nan, np.inf])
def test_the_difference_of_stamps_is_a_time(seconds):
    path = covis.Trajectory([1, 2, 3], PLACES, TURNS)
    with pytest.raises(ValueError, match='max_difference: a positive number of seconds is wanted'):
        covis.evaluate(path, path, max_difference=seconds)


def test_a_log_sink_may_own_what_logs():
    class Robot:
        def __init__(self):
            covis.set_log_sink(self.hear)

        def hear(self, level, message):
            pass

        def __del__(self):
            covis.set_log_sink(None)  # within the replacement of the sink

    robot = Robot()
    del robot
    covis.set_log_sink(None)


DROPPED_IN_A_SINK = """
import covis, sys, threading
source = covis.Recording(sys.argv[1])
ended = threading.Event()
class Camera(covis.Slam):
    def __del__(self):
        ended.set()
slams = [Camera(source.camera, source.sensor, timing=covis.Timing.realtime, vocabulary=covis.default_vocabulary())]
def sink(level, message):
    if threading.current_thread() is not threading.main_thread():
        slams.clear()
covis.set_log_sink(sink)
for frame in source:
    if not slams:
        break
    slams[0].track(frame.stamp, frame.image, depth=frame.depth)
    ended.wait(0.05)
print('ended' if ended.wait(5) else 'nothing was written by another thread')
"""


def test_a_system_may_be_dropped_by_its_own_thread(recording):
    done = subprocess.run([sys.executable, '-c', DROPPED_IN_A_SINK, recording('desk_rgbd')], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, 'ended'), done.stderr


def test_a_snapshot_is_sound_and_is_not_copied(desk):
    slam, results, _ = desk
    s = slam.snapshot()
    n, m = len(s.points), len(s.key_frame_ids)
    assert n > 100 and m >= 2
    assert s.points.shape == (n, 3) and s.points.dtype == np.float64
    assert s.point_ids.shape == (n,) and len(set(s.point_ids.tolist())) == n
    assert s.key_frame_positions.shape == (m, 3) and s.key_frame_quaternions.shape == (m, 4)
    assert np.allclose(np.linalg.norm(s.key_frame_quaternions, axis=1), 1)
    assert s.edges.shape[1] == 2 and s.edges.max() < m and np.all(s.edges[:, 0] < s.edges[:, 1])
    assert s.edge_loops.dtype == np.bool_
    assert s.observations[:, 0].max() < m and s.observations[:, 1].max() < n
    assert len(s.observation_pixels) == len(s.observations)
    assert s.submaps[0].points == n and s.submaps[0].key_frames == m
    assert len(s.stamps) == sum(r.tracked for r in results)
    assert s.points.base is not None and not s.points.flags.writeable
    with pytest.raises(ValueError):
        s.points[0, 0] = 1
    points, mean = s.points, s.points.mean()
    del s
    gc.collect()
    assert points.mean() == mean, 'the array keeps the snapshot'


def test_errors_and_the_picture(desk, tmp_path):
    slam, _, truth = desk
    path = slam.trajectory()
    assert len(path) == len(path.stamps) == len(path.positions)
    compared = covis.evaluate(path, truth)
    assert compared.ate_rmse < 0.02
    assert compared.coverage > 0.9
    assert compared.errors.shape == (len(compared.estimate),)
    assert np.isclose(np.sqrt((compared.errors ** 2).mean()), compared.ate_rmse)
    assert np.isclose(compared.figures['ate_m']['rmse'], compared.ate_rmse)
    assert 'ATE' in str(compared)
    moved = covis.Trajectory(path.stamps, path.positions + [1, 2, 3], path.quaternions)
    assert np.isclose(covis.evaluate(moved, path, align='none').ate_rmse, np.sqrt(14))
    picture = tmp_path / 'path.png'
    covis.plot(path, truth).figure.savefig(picture)
    assert picture.stat().st_size > 5000
    file = str(tmp_path / 'path.txt')
    path.save(file)
    assert np.allclose(covis.Trajectory.load(file).positions, path.positions, atol=1e-6)


def test_a_map_is_kept_and_localised_in(desk, recording, tmp_path):
    slam, _, _ = desk
    file = str(tmp_path / 'desk.m')
    slam.save_map(file)
    source = covis.Recording(recording('desk_rgbd'), first=10, count=3)
    later = system(source, map=file, mode=covis.Mode.localisation)
    assert later.mode == covis.Mode.localisation
    frame = next(source)
    place = later.locate(frame.image, depth=frame.depth)
    positions, stamps = slam.snapshot().positions, slam.snapshot().stamps
    there = positions[stamps.tolist().index(frame.stamp)]
    assert np.linalg.norm(np.array([place.pose.x, place.pose.y, place.pose.z]) - there) < 0.05
    assert later.locate(np.zeros_like(frame.image), depth=frame.depth) is None
    later.mode = covis.Mode.mapping
    assert later.mode == covis.Mode.mapping
    later.reset()
    assert len(later.snapshot().points) == 0
    later.load_map(file)
    assert len(later.snapshot().points) == len(slam.snapshot().points)


def test_worlds_of_submaps_are_kept_apart(recording, tmp_path):
    parts = [covis.Recording(recording(name), count=n) for name, n in (('room_rgbd', 30), ('posters_rgbd', 40))]
    slam = system(parts[0])
    truths, last = [], 0
    for part in parts:
        later = last + 10**8
        truth = part.truth()
        truths.append(covis.Trajectory(truth.stamps + later, truth.positions, truth.quaternions))
        for frame in part:
            last = frame.stamp + later
            slam.track(last, frame.image, depth=frame.depth)
    slam.finish()
    path = slam.trajectory()
    assert set(path.submaps) == {0, 1}
    sizes = sorted(((path.submaps == k).sum(), k) for k in (0, 1))
    largest = sizes[-1][1]
    assert covis.evaluate(path, truths[largest]).ate_rmse < 0.01, 'of the map with the most poses alone'
    lines = covis.plot(path).lines
    assert [len(line.get_xdata()) for line in lines] == [size for size, _ in reversed(sizes)], 'a line for each world'
    assert lines[0].get_label() == 'Covis' and f'submap {sizes[0][1]}' in lines[1].get_label()
    assert np.allclose(lines[0].get_xdata(), path.positions[path.submaps == largest][:, 0])
    path.save(tmp_path / 'path.txt')
    for file, (size, k) in zip(('path_map1.txt', 'path.txt'), sizes):
        saved = covis.Trajectory.load(tmp_path / file)
        assert len(saved) == size and covis.evaluate(saved, truths[k]).ate_rmse < 0.01


def test_events_and_messages_come_by_themselves(recording):
    source = covis.Recording(recording('desk_rgbd'))
    slam = system(source)
    events, messages = [], []
    covis.set_log_sink(lambda level, message: messages.append((level, message)))
    slam.on_event(lambda event: events.append((event.kind, slam.snapshot().revision)))
    track_all(slam, source)
    black = np.zeros((240, 320), np.uint8)
    for k in range(3):
        result = slam.track(10**12 + k, black, depth=np.zeros((240, 320), np.float32))
    slam.finish()
    covis.set_log_sink(None)
    slam.on_event(None)
    kinds = [kind for kind, _ in events]
    assert kinds.count(covis.EventKind.submap_begun) == 1
    assert kinds.count(covis.EventKind.lost) == 1
    assert kinds.count(covis.EventKind.key_frame_made) >= len(slam.snapshot().key_frame_ids)
    assert any('tracking lost' in message for _, message in messages)
    assert result.pose is None and result.covariance is None and covis.describe(result.reason) in repr(result)


def test_an_exception_of_the_sink_is_reported_and_tracking_goes_on(recording, monkeypatch):
    source = covis.Recording(recording('desk_rgbd'))
    slam = system(source)
    raised = []
    monkeypatch.setattr(sys, 'unraisablehook', lambda unraisable: raised.append(unraisable.exc_value))

    def sink(level, message):
        raise KeyError(message)
    covis.set_log_sink(sink)
    track_all(slam, source)
    black = np.zeros((240, 320), np.uint8)
    for k in range(3):
        slam.track(10**12 + k, black, depth=np.zeros((240, 320), np.float32))
    slam.finish()
    covis.set_log_sink(None)
    assert raised and all(isinstance(e, KeyError) for e in raised)
    assert len(slam.snapshot().key_frame_ids) > 2


def test_an_exception_of_a_handler_comes_out_of_track(recording):
    source = covis.Recording(recording('desk_rgbd'), count=3)
    slam = system(source)

    def handler(event):
        raise KeyError('mine')
    slam.on_event(handler)
    with pytest.raises(KeyError, match='mine'):
        track_all(slam, source)
    slam.on_event(None)
    assert all(r.tracked for r in track_all(slam, source)), 'the frame was tracked all the same'


def test_other_threads_run_and_ask_meanwhile(recording):
    source = covis.Recording(recording('desk_rgbd'))
    slam = system(source)
    counts, stop = [], threading.Event()

    def viewer():
        while not stop.is_set():
            counts.append(len(slam.snapshot().points))
            assert slam.camera.fx > 0
    thread = threading.Thread(target=viewer)
    thread.start()
    track_all(slam, source)
    stop.set()
    thread.join()
    assert len(counts) > 1 and max(counts) > 100


# ---- What is refused ----

@pytest.fixture
def small():
    return covis.Slam(SMALL, covis.Sensor.rgbd)


IMAGE = np.full((HEIGHT, WIDTH), 90, np.uint8)
DEPTH = np.full((HEIGHT, WIDTH), 2, np.float32)


@pytest.mark.parametrize('image, depth, error, message', [
    (IMAGE.astype(np.float32), DEPTH, TypeError, 'image: dtype uint8 is wanted, not float32'),
    (IMAGE, DEPTH.astype(np.float64), TypeError, 'depth: dtype float32 is wanted, not float64'),
    (IMAGE, DEPTH.astype(np.uint16), TypeError, 'depth: dtype float32'),
    ([[1, 2], [3, 4]], DEPTH, TypeError, 'image: a NumPy array'),
    (None, DEPTH, TypeError, 'image: a NumPy array'),
    (np.dstack([IMAGE] * 3), DEPTH, ValueError, r'image: a shape \(height, width\)'),
    (np.asfortranarray(IMAGE), DEPTH, ValueError, 'image: rows must be contiguous'),
    (IMAGE[::-1], DEPTH, ValueError, 'image: rows must be contiguous'),
    (IMAGE[:, ::2], DEPTH, ValueError, 'image: rows must be contiguous'),
    (IMAGE[:100], DEPTH, covis.Error, 'image: the image is empty or is 160x100'),
    (IMAGE, DEPTH[:0], covis.Error, 'depth: the image is empty'),
    (IMAGE, None, covis.Error, 'depth: the image is empty'),
])
def test_arrays_that_are_wrong_are_named(small, image, depth, error, message):
    with pytest.raises(error, match=message):
        small.track(0, image, depth=depth)
    assert small.track(0, IMAGE, depth=DEPTH).state == covis.TrackingState.not_initialised, 'nothing has changed'


def test_rows_may_be_part_of_a_wider_array(small):
    wide = np.zeros((HEIGHT, 2 * WIDTH), np.uint8)
    assert small.track(0, wide[:, :WIDTH], depth=DEPTH).reason == covis.NoPoseReason.few_features


def test_points_have_the_colours_of_the_images(recording):
    source = covis.Recording(recording('desk_rgbd'))
    slam = system(source)
    for frame in source:
        picture = source.picture(frame.index)
        assert np.array_equal(picture, frame.image), 'rendered recordings are grey'
        tinted = np.dstack([picture, 255 - picture, np.full_like(picture, 30)])
        slam.track(frame.stamp, frame.image, depth=frame.depth, colour=tinted[:, :, ::-1].copy(),
                   order=covis.ColourOrder.bgr)
    slam.finish()
    colours = slam.snapshot().point_colours.astype(int)
    assert colours.shape == (len(slam.snapshot().points), 3) and (colours[:, 2] == 30).all()
    assert (abs(colours[:, 0] + colours[:, 1] - 255) <= 1).all() and np.ptp(colours[:, 0]) > 50


@pytest.mark.parametrize('colour, error, message', [
    (IMAGE, ValueError, r'colour: a shape \(height, width, 3\)'),
    (np.dstack([IMAGE] * 3).astype(float), TypeError, 'colour: a NumPy array of uint8'),
    (np.dstack([IMAGE] * 3)[:, :, ::-1], ValueError, 'colour: rows must be contiguous'),
    (np.zeros((10, 10, 3), np.uint8), covis.Error, 'colour: the image is empty or is 10x10'),
])
def test_colours_that_are_wrong_are_named(small, colour, error, message):
    with pytest.raises(error, match=message):
        small.track(0, IMAGE, depth=DEPTH, colour=colour)


def test_depth_that_is_not_finite_is_no_depth(small):
    depth = DEPTH.copy()
    depth[::2] = np.nan
    depth[1::4] = np.inf
    assert not small.track(0, IMAGE, depth=depth).tracked


def test_other_errors_have_their_message():
    with pytest.raises(covis.Error, match='fx and fy'):
        covis.Slam(covis.Camera(640, 480, float('nan'), 500, 320, 240), covis.Sensor.monocular)
    with pytest.raises(covis.Error, match='orb.features'):
        covis.Slam(SMALL, covis.Sensor.monocular, settings={'orb.feature': 10})
    with pytest.raises(covis.Error, match='nowhere'):
        covis.Slam(SMALL, covis.Sensor.monocular, map='/nowhere.m')
    with pytest.raises(covis.Error, match='stamps must rise'):
        slam = covis.Slam(SMALL, covis.Sensor.monocular)
        slam.track(1, IMAGE)
        slam.track(1, IMAGE)
    with pytest.raises(covis.Error, match='nowhere'):
        covis.Recording('/nowhere')
    with pytest.raises(ValueError, match='kind'):
        covis.Recording('/nowhere', kind='tape')
    with pytest.raises(ValueError, match='five'):
        covis.Camera(640, 480, 500, 500, 320, 240, distortion=[0] * 6)
    with pytest.raises(TypeError):
        covis.Slam(SMALL, 'rgbd')
    with pytest.raises(covis.Error, match='to localise in|needs a map'):
        covis.Slam(SMALL, covis.Sensor.rgbd, mode=covis.Mode.localisation)


def test_a_readout_goes_in_and_comes_back(recording, tmp_path):
    rolling = covis.Camera(WIDTH, HEIGHT, 130, 130, 80, 60, readout=-0.02)
    assert rolling.readout == -0.02 and SMALL.readout == 0
    for sensor in (covis.Sensor.monocular, covis.Sensor.rgbd):
        slam = covis.Slam(rolling, sensor)
        assert slam.camera.readout == pytest.approx(-0.02) and slam.snapshot().camera.readout == pytest.approx(-0.02)
        assert covis.Slam(SMALL, sensor).camera.readout == 0
    for readout in (0.5, -0.5, float('nan')):
        wrong = covis.Camera(WIDTH, HEIGHT, 130, 130, 80, 60, readout=readout)
        with pytest.raises(covis.Error, match='camera: the readout in seconds: .* from -0.2 to 0.2'):
            covis.Slam(wrong, covis.Sensor.rgbd)

    folder = recording('desk_rgbd')
    assert covis.Recording(folder).camera.readout == 0
    file = tmp_path / 'rolling.yaml'
    file.write_text((pathlib.Path(folder) / 'camera.yaml').read_text() + 'readout: 0.015\n')
    source = covis.Recording(folder, camera_file=str(file))
    assert source.camera.readout == pytest.approx(0.015)
    assert system(source).camera.readout == pytest.approx(0.015)


def test_the_camera_of_depth_goes_in_and_comes_back(recording, tmp_path):
    figures = {'depth_fx': 140, 'depth_cx': 81, 'depth_cy': 59, 'depth_x': 0.02, 'depth_y': -0.01}
    slam = covis.Slam(covis.Camera(WIDTH, HEIGHT, 130, 130, 80, 60, **figures), covis.Sensor.rgbd)
    for name, value in figures.items():
        assert getattr(slam.camera, name) == pytest.approx(value), name
    assert covis.Slam(SMALL, covis.Sensor.rgbd).camera.depth_fx == 0
    with pytest.raises(covis.Error, match='camera: depth_fx must be from 0.1 to 10 times fx'):
        covis.Slam(covis.Camera(WIDTH, HEIGHT, 130, 130, 80, 60, depth_fx=5), covis.Sensor.rgbd)

    folder = recording('desk_rgbd')
    file = tmp_path / 'depth.yaml'
    file.write_text((pathlib.Path(folder) / 'camera.yaml').read_text() + ''.join(f'{name}: {value}\n' for name, value in figures.items()))
    source = covis.Recording(folder, camera_file=str(file))
    for name, value in figures.items():
        assert getattr(source.camera, name) == pytest.approx(value), name
    assert system(source).camera.depth_fx == pytest.approx(140)


def test_settings_are_listed_and_given():
    slam = covis.Slam(SMALL, covis.Sensor.monocular, settings={'orb.features': 700, 'loop.close': False})
    settings = {setting.name: setting for setting in slam.settings}
    assert settings['orb.features'].value == '700' and settings['loop.close'].value == 'false'
    assert settings['orb.features'].min < 700 < settings['orb.features'].max
    assert len(covis.default_settings()) == len(settings)
    assert settings['orb.features'].type == covis.SettingType.whole_number
    assert settings['loop.close'].type == covis.SettingType.boolean
    assert {setting.type for setting in slam.settings} <= set(covis.SettingType.__members__.values())


def test_a_frame_is_not_copied(recording):
    """bench/python_overhead says what a frame costs; a copy of its images would be seen in NumPy's memory."""
    source = covis.Recording(recording('desk_rgbd'), count=10)
    slam = system(source)
    frames = list(source)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[1]
    for frame in frames:
        result = slam.track(frame.stamp, frame.image, depth=frame.depth)
        assert result.pose.matrix.shape == (4, 4)
    grown = tracemalloc.get_traced_memory()[1] - before
    tracemalloc.stop()
    assert grown < frames[0].image.nbytes / 2


def test_the_measure_of_overhead_tracks_the_same_frames(desk, recording):
    path = str(ROOT / 'bench' / 'python_overhead')
    overhead = types.ModuleType('python_overhead')
    exec(compile(pathlib.Path(path).read_text(), path, 'exec'), overhead.__dict__)
    rows = overhead.in_python(covis, recording('desk_rgbd'), covis.default_vocabulary())
    assert [row[2] for row in rows] == [(r.pose.x, r.pose.y, r.pose.z) for r in desk[1]]
    assert overhead.least([rows, [(0, 9, 0, 0)] * len(rows)], 0) == [0] * len(rows)
