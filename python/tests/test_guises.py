# SPDX-License-Identifier: Apache-2.0
"""bench/guises: where a camera in a guise sees a point is where the image in that guise shows it."""
import importlib.machinery
import importlib.util
import pathlib

import numpy as np
import pytest

import covis

SCRIPT = pathlib.Path(__file__).parents[2] / 'bench' / 'guises'
# What becomes of a point's place in the camera.
WAYS = {'turned': lambda x, y: (-x, -y), 'mirrored': lambda x, y: (-x, y), 'portrait': lambda x, y: (-y, x), 'half': lambda x, y: (x, y),
        'double': lambda x, y: (x, y), 'narrow': lambda x, y: (x, y), 'cut': lambda x, y: (x, y)}


@pytest.fixture(scope='module')
def guises():
    pytest.importorskip('PIL')
    loader = importlib.machinery.SourceFileLoader('guises', str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader('guises', loader))
    loader.exec_module(module)
    return module


def pixel_of(camera, x, y):
    k1, k2, p1, p2, k3 = camera.distortion
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return camera.fx * u + camera.cx, camera.fy * v + camera.cy


@pytest.mark.parametrize('guise', WAYS)
def test_a_point_is_where_the_camera_sees_it(guises, guise):
    camera = covis.Camera(160, 120, 150, 140, 82, 57, lens=covis.Lens.brown_conrady, distortion=[0.1, -0.05, 0.02, -0.03, 0.01])
    seen = guises.camera_in(covis, camera, guise)
    for x, y in ((0.1, 0.12), (-0.2, 0.05), (0.15, -0.2)):
        u, v = pixel_of(camera, x, y)
        rows, columns = np.mgrid[0:camera.height, 0:camera.width]
        blob = 250 * np.exp(-((columns - u) ** 2 + (rows - v) ** 2) / 18)
        image = guises.LOOKS[guise](guises.grey(blob), 0, 0).astype(float)
        assert image.shape == (seen.height, seen.width)
        rows, columns = np.mgrid[0:image.shape[0], 0:image.shape[1]]
        shown = (columns * image).sum() / image.sum(), (rows * image).sum() / image.sum()
        assert shown == pytest.approx(pixel_of(seen, *WAYS[guise](x, y)), abs=0.05)


def test_the_path_of_a_pair_that_changes_sides_is_that_of_its_right_camera(guises):
    half = np.sqrt(0.5)  # to the left: the camera's right is the world's depth
    truth = covis.Trajectory([0, 10, 20], np.array([[0., 0, 0], [1, 0, 0], [3, 0, 0]]), np.array([[0., -half, 0, half]] * 3))
    turned = guises.truth_in(covis, truth, 'turned', 20, 0.5)
    assert turned.stamps.tolist() == [0, 10, 20]
    assert turned.positions == pytest.approx(np.array([[3, 0, 0.5], [1, 0, 0.5], [0, 0, 0.5]]))
    mirrored = guises.truth_in(covis, truth, 'mirrored', 20, 0)
    assert mirrored.positions == pytest.approx(np.array([[0, 0, 0], [-1, 0, 0], [-3, 0, 0]]))
