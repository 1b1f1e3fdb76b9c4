# SPDX-License-Identifier: Apache-2.0
"""Files of recordings and trajectories as they are in the field: rows without stamps, images that can't be read."""
import pathlib
import shutil

import pytest

import covis


def test_rows_without_stamps_are_not_compared_with_those_of_other_frames(desk, tmp_path):
    truth = desk[2]
    truth.save(tmp_path / 'truth.txt', format='kitti')
    part = covis.Trajectory(truth.stamps[40:], truth.positions[40:], truth.quaternions[40:])
    part.save(tmp_path / 'part.txt', format='kitti')
    load = covis.Trajectory.load
    whole = load(tmp_path / 'truth.txt', stamps=tmp_path / 'truth_times.txt')
    assert (whole.stamps == truth.stamps).all()
    assert covis.evaluate(load(tmp_path / 'part.txt', stamps=tmp_path / 'part_times.txt'), whole).ate_rmse < 1e-6
    with pytest.raises(covis.Error, match=f'{len(part)} rows, and .*truth_times.txt has {len(truth)} stamps'):
        load(tmp_path / 'part.txt', stamps=tmp_path / 'truth_times.txt')
    for other in (load(tmp_path / 'truth.txt'), whole):
        with pytest.raises(covis.Error, match='rows of the estimate have no stamps'):
            covis.evaluate(load(tmp_path / 'part.txt'), other)
    rows = load(tmp_path / 'truth.txt')
    assert covis.evaluate(rows, rows).ate_rmse < 1e-6
    truth.save(tmp_path / 'tum.txt')
    with pytest.raises(covis.Error, match='tum.txt has stamps of its own'):
        load(tmp_path / 'tum.txt', stamps=tmp_path / 'truth_times.txt')


@pytest.fixture
def messages():
    said = []
    covis.set_log_sink(lambda level, text: said.append((level, text)))
    yield said
    covis.set_log_sink(None)


def cut(folder, numbers):
    """Leaves of the images with these numbers the first bytes, by which they pass as images."""
    images = sorted((pathlib.Path(folder) / 'rgb').iterdir())
    for k in numbers if numbers is not None else range(len(images)):
        images[k].write_bytes(images[k].read_bytes()[:200])
    return len(images)


def test_an_image_that_cant_be_read_is_left_out(recording, tmp_path, messages):
    folder = shutil.copytree(recording('desk_rgbd'), tmp_path / 'desk')
    size = cut(folder, [3, 7])
    source = covis.Recording(folder)
    indices = [frame.index for frame in source]
    assert indices == [k for k in range(size) if k not in (3, 7)]
    assert source.unreadable == 2
    warnings = [text for level, text in messages if level == covis.LogLevel.warning]
    assert len(warnings) == 2 and all('rgb' in text for text in warnings)


def test_a_recording_without_a_frame_that_can_be_read_is_an_error(recording, tmp_path, messages):
    folder = shutil.copytree(recording('desk_rgbd'), tmp_path / 'desk')
    size = cut(folder, None)
    source = covis.Recording(folder)
    with pytest.raises(covis.Error, match='no frame could be read'):
        list(source)
    assert source.unreadable == size


def test_many_frames_that_lack_a_file_are_left_out_where_that_is_asked_for(recording, tmp_path):
    folder = shutil.copytree(recording('desk_rgbd'), tmp_path / 'desk')
    depths = sorted((folder / 'depth').iterdir())
    for file in depths[::4]:
        file.unlink()
    with pytest.raises(covis.Error, match='frames lack a file'):
        covis.Recording(folder)
    assert len(list(covis.Recording(folder, skip_bad=True))) == len(depths) - len(depths[::4])


def test_topics_are_those_of_a_bag(recording):
    for name in ('topic', 'right_topic', 'depth_topic'):
        with pytest.raises(covis.Error, match='topic|bag'):
            covis.Recording(recording('desk_rgbd'), **{name: '/camera'})
