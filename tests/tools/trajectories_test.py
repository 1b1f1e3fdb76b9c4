#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of bench/trajectories.py: pairing, alignment and frames claimed wrong, on paths whose errors are known."""
import math
import pathlib
import random
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'bench'))
import trajectories  # noqa: E402
from trajectories import align, claimed_wrong, errors, figures, key_of, robust_errors, truth_at  # noqa: E402


def walk(count=200):
    """A path of about 10 cm a frame that fills space."""
    return [(5 * math.cos(k / 50), 5 * math.sin(k / 50), math.sin(k / 20)) for k in range(count)]


def moved(points, scale=1.0, quaternion=(0.4, -0.2, 0.7, 0.5), shift=(3.0, -20.0, 1.0)):
    R = trajectories.rotation_of(quaternion)
    return [tuple(scale * sum(r * x for r, x in zip(row, p)) + s for row, s in zip(R, shift)) for p in points]


class PairingTest(unittest.TestCase):
    truth = [(10.0, (0.0, 0.0, 0.0)), (10.08, (8.0, 0.0, 4.0)), (11.0, (9.0, 9.0, 9.0))]

    def test_the_true_pose_of_the_same_time(self):
        self.assertEqual(truth_at(self.truth, 10.0004), (0.0, 0.0, 0.0))
        self.assertEqual(truth_at(self.truth, 11.0), (9.0, 9.0, 9.0))

    def test_between_two_true_poses(self):
        for found, wanted in zip(truth_at(self.truth, 10.02), (2.0, 0.0, 1.0)):
            self.assertAlmostEqual(found, wanted)

    def test_near_one_across_a_gap_and_beyond_the_ends(self):
        self.assertEqual(truth_at(self.truth, 10.095), (8.0, 0.0, 4.0))
        self.assertEqual(truth_at(self.truth, 9.985), (0.0, 0.0, 0.0))
        self.assertIsNone(truth_at(self.truth, 10.5))
        self.assertIsNone(truth_at(self.truth, 11.1))
        self.assertIsNone(truth_at([], 1.0))


class AlignmentTest(unittest.TestCase):
    def test_a_moved_path_has_no_error(self):
        path = walk()
        self.assertLess(max(errors(align(moved(path), path, False), path)), 1e-9)
        self.assertLess(max(errors(align(moved(path, 0.2), path, True), path)), 1e-9)
        self.assertGreater(max(errors(align(moved(path, 0.2), path, False), path)), 1.0)

    def test_a_half_turn_and_no_turn(self):
        path = walk()
        for quaternion in [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (1, 1e-9, 0, 0)]:
            self.assertLess(max(errors(align(moved(path, 1.0, quaternion), path, False), path)), 1e-9)

    def test_a_straight_path(self):
        path = [(0.0, 0.0, float(k)) for k in range(20)]
        self.assertLess(max(errors(align(moved(path, 3.0), path, True), path)), 1e-9)
        self.assertEqual(errors(align([(1, 2, 3)], [(0, 0, 0)], True), [(0, 0, 0)]), [0.0])

    def test_least_squares_are_least(self):
        source = random.Random(1)
        path = walk()
        noisy = [tuple(x + source.gauss(0, 0.05) for x in p) for p in moved(path, 2.0)]
        best = sum(e * e for e in errors(align(noisy, path, True), path))
        self.assertLess(best / len(path), 3 * 0.025 ** 2 * 1.3)
        for other in (moved(align(noisy, path, True), 1.001, (1, 0, 0, 0), (0, 0, 0)),
                      moved(align(noisy, path, True), 1.0, (1, 0.001, 0, 0), (0, 0, 0)),
                      moved(align(noisy, path, True), 1.0, (1, 0, 0, 0), (0.001, 0, 0))):
            self.assertGreater(sum(e * e for e in errors(other, path)), best)

    def test_weights(self):
        path = walk()
        bent = moved(path)[:150] + moved(path, 1.0, (1, 0, 0, 0))[150:]
        found = errors(align(bent, path, False, [1.0] * 150 + [0.0] * 50), path)
        self.assertLess(max(found[:150]), 1e-9)
        self.assertGreater(min(found[150:]), 0.1)

    def test_wrong_frames_do_not_spread(self):
        source = random.Random(2)
        path = walk(1000)
        given = [tuple(x + source.gauss(0, 0.002) for x in p) for p in moved(path)]
        given[400:420] = [tuple(x + 8 for x in p) for p in given[400:420]]
        plain, robust = (errors(align(given, path, False), path), robust_errors(given, path, False))
        self.assertGreater(max(plain[:400]), 0.1)
        self.assertLess(max(robust[:400] + robust[420:]), 0.012)
        self.assertGreater(min(robust[400:420]), 13)


def run_of(claims, tentative=(), lost=(), submap=lambda k: 0):
    """A run whose frame k has the pose claims[k]."""
    frames = []
    for k, position in enumerate(claims):
        state = 'lost' if k in lost else 'tracking'
        frame = {'frame': k, 'stamp': k / 10, 'state': state, 'tentative': k in tentative}
        if state == 'tracking':
            frame.update(map=0, online={'submap': submap(k), 'position_m': list(position)})
        frames.append(frame)
    kept = {key_of(k / 10): tuple(p) for k, p in enumerate(claims) if k not in lost}
    return trajectories.Run(frames, kept, [kept])


class ClaimedWrongTest(unittest.TestCase):
    def setUp(self):
        self.path = walk()
        self.truth = {key_of(k / 10): p for k, p in enumerate(self.path)}
        self.length = trajectories.path_length(self.path)

    def found(self, run):
        return claimed_wrong(run, self.truth, self.length, False)

    def away(self, frames, by):
        given = moved(self.path)
        for k in frames:
            given[k] = tuple(x + by / math.sqrt(3) for x in given[k])
        return given

    def test_none(self):
        found = self.found(run_of(moved(self.path)))
        self.assertEqual((found['claims'], found['wrong'], found['wrong_frames']), (200, 0, []))

    def test_by_the_path_and_by_the_median(self):
        given = self.away([70, 71], 1.2 * trajectories.WRONG_SHARE * self.length)
        given[100] = tuple(x + 0.03 for x in given[100])  # above 5 medians and 1 cm
        given[101] = tuple(x + 0.003 for x in given[101])  # above 5 medians only
        found = self.found(run_of(given))
        self.assertEqual([frame for frame, _ in found['wrong_frames']], [70, 71, 100])
        self.assertEqual((found['wrong'], found['wrong_path'], found['wrong_median'], found['wrong_both']), (3, 2, 3, 2))

    def test_who_claims_nothing_is_not_wrong(self):
        given = self.away([70, 71, 72], 5)
        found = self.found(run_of(given, tentative=[70], lost=[71]))
        self.assertEqual([frame for frame, _ in found['wrong_frames']], [72])
        self.assertEqual(found['claims'], 198)

    def test_each_submap_by_itself(self):
        given = moved(self.path)[:100] + moved(self.path, 1.0, (0, 1, 0, 0), (9, 9, 9))[100:]
        self.assertEqual(self.found(run_of(given, submap=lambda k: k // 100))['wrong'], 0)
        self.assertGreater(self.found(run_of(given))['wrong'], 0)

    def test_an_older_covis_tells_online_poses_in_a_file(self):
        run = run_of(self.away([70], 5))
        for frame in run.frames:
            del frame['online']
        run.final = [{key_of(k / 10): p for k, p in enumerate(moved(self.path))}]
        self.assertEqual([frame for frame, _ in self.found(run)['wrong_frames']], [70])
        del run.online[key_of(7.0)]  # joined from another submap: only its final pose is known
        self.assertEqual(self.found(run)['wrong'], 0)

    def test_frames_located_afterwards_are_judged_among_the_final_poses(self):
        given = self.away(range(60, 70), 2 * trajectories.WRONG_SHARE * self.length)  # rigidly off, by themselves they fit
        run = run_of(given)
        for k in range(50, 70):
            run.frames[k]['method'] = 'backtracked'
            run.frames[k].pop('online', None)
        run.final = [{key_of(frame['stamp']): position for frame, position in zip(run.frames, given)}]
        found = self.found(run)
        self.assertEqual(found['claims'], 200)
        self.assertEqual([k for k, _ in found['wrong_frames']], list(range(60, 70)))

    def test_frames_without_truth_are_not_judged(self):
        self.truth = {key: p for key, p in self.truth.items() if key > key_of(8)}
        found = self.found(run_of(self.away([70], 5)))
        self.assertEqual((found['claims'], found['wrong']), (119, 0))
        self.assertEqual(claimed_wrong(run_of(self.path), {}, 0, False)['claims'], 0)


class FiguresTest(unittest.TestCase):
    def test_shares_and_errors(self):
        path = walk()
        truth = [(k / 10, p) for k, p in enumerate(path) if k < 150]
        found = figures(run_of(moved(path), lost=range(20)), truth, False)
        self.assertEqual((found['frames'], found['frames_with_truth'], found['wrong']), (200, 150, 0))
        self.assertAlmostEqual(found['tracked'], 0.9)
        self.assertAlmostEqual(found['tracked_of_paired'], 130 / 150)
        self.assertLess(found['ate_m'] + found['ate_online_m'], 1e-8)
        self.assertAlmostEqual(found['path_m'], trajectories.path_length(path[:150]))

    def test_without_truth(self):
        found = figures(run_of(walk()), [], True)
        self.assertEqual(found['tracked'], 1)
        self.assertNotIn('ate_m', found)

    def test_nothing_tracked(self):
        path = walk(20)
        found = figures(run_of(path, lost=range(20)), [(k / 10, p) for k, p in enumerate(path)], True)
        self.assertEqual((found['tracked'], found['ate_m'], found['claims']), (0, None, 0))


if __name__ == '__main__':
    unittest.main()
