# SPDX-License-Identifier: Apache-2.0
"""The worth of a run's poses: ground truth and estimates paired, aligned and judged. Positions alone are looked at.

Pairing is that of `covis eval`: with the true pose within half a millisecond; else with the interpolation between two
true poses at most 0.1 s apart; else with the nearest within 0.02 s; else the frame has no truth.

Errors are after Horn's closed form (J. Opt. Soc. Am. A 1987), with scale for one camera. ATE is the RMSE after the plain
least-squares alignment. Frames claimed wrong are judged after a robust one, weighted anew in turns after Huber with the median error as threshold, so
that frames that are wrong don't spread their error over the others. Poses of different submaps have no common frame of reference, so
each submap is aligned by itself.
"""
import bisect
import json
import math
import statistics

SAME = 0.0005            # seconds: stamps rounded to milliseconds count as equal
MAX_GAP = 0.1            # seconds between two true poses that are interpolated
MAX_DIFFERENCE = 0.02    # seconds to the nearest true pose
ROUNDS = 15              # rounds of robust alignment
WRONG_SHARE = 0.01       # share of the path: an error above it is a frame claimed wrong,
WRONG_MEDIANS = 5        # and so is one above this many times the run's median error,
FLOOR_SHARE = 0.0005     # unless it is below this share of the path
FLOOR_M = 0.01           # or below this many metres: nobody is misled by it, and truth is no better known


# ---- Positions --------------------------------------------------------------------------------------------------------

def minus(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def distance(a, b):
    return math.dist(a, b)


def read_positions(file):
    """Rows `t x y z …` of a TUM trajectory, as (seconds, position), by rising stamp."""
    poses = []
    for line in file.read_text().splitlines():
        words = line.replace(',', ' ').split()
        if words and not words[0].startswith('#'):
            poses.append((float(words[0]), tuple(map(float, words[1:4]))))
    return sorted(poses)


def truth_at(truth, stamp):
    """The true position at a stamp, or None. truth: (seconds, position) by rising stamp."""
    after = bisect.bisect_left(truth, (stamp,))
    around = [truth[k] for k in (after - 1, after) if 0 <= k < len(truth)]
    if not around:
        return None
    best = min(around, key=lambda pose: abs(pose[0] - stamp))
    if abs(best[0] - stamp) <= SAME:
        return best[1]
    if len(around) == 2 and around[1][0] - around[0][0] <= MAX_GAP:
        (t0, a), (t1, b) = around
        s = (stamp - t0) / (t1 - t0)
        return tuple((1 - s) * u + s * v for u, v in zip(a, b))
    return best[1] if abs(best[0] - stamp) <= MAX_DIFFERENCE else None


def path_length(positions):
    return sum(distance(a, b) for a, b in zip(positions, positions[1:]))


# ---- Alignment --------------------------------------------------------------------------------------------------------

def largest_eigenvector(matrix):
    """The eigenvector of a symmetric matrix, by Jacobi's rotations."""
    n = len(matrix)
    a = [list(row) for row in matrix]
    v = [[float(i == j) for j in range(n)] for i in range(n)]
    for _ in range(50):
        rest = sum(a[i][j] ** 2 for i in range(n) for j in range(i))
        if rest <= 1e-30 * sum(a[i][i] ** 2 for i in range(n)):
            break
        for p in range(n - 1):
            for q in range(p + 1, n):
                if a[p][q] == 0:
                    continue
                theta = (a[q][q] - a[p][p]) / (2 * a[p][q])
                t = math.copysign(1, theta) / (abs(theta) + math.hypot(theta, 1))
                c = 1 / math.hypot(t, 1)
                s = t * c
                for row in a:
                    row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
                a[p], a[q] = ([c * x - s * y for x, y in zip(a[p], a[q])], [s * x + c * y for x, y in zip(a[p], a[q])])
                for row in v:
                    row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
    best = max(range(n), key=lambda i: a[i][i])
    return [row[best] for row in v]


def rotation_of(q):
    w, x, y, z = (value / math.sqrt(sum(u * u for u in q)) for value in q)
    return ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))


def centre(points, weights, total):
    return tuple(sum(w * p[k] for w, p in zip(weights, points)) / total for k in range(3))


def align(estimate, truth, with_scale, weights=None):
    """The estimate moved onto the truth: scale (1 unless asked for), rotation and translation that are best for the weighted squares."""
    weights = weights or [1.0] * len(estimate)
    total = sum(weights)
    from_centre, to_centre = centre(estimate, weights, total), centre(truth, weights, total)
    m = [[0.0] * 3 for _ in range(3)]
    spread = 0.0
    for w, p, q in zip(weights, estimate, truth):
        x, y, z = minus(p, from_centre)
        u, v, t = minus(q, to_centre)
        spread += w * (x * x + y * y + z * z)
        for row, value in zip(m, (w * x, w * y, w * z)):
            row[0] += value * u
            row[1] += value * v
            row[2] += value * t
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = m
    R = rotation_of(largest_eigenvector(((xx + yy + zz, yz - zy, zx - xz, xy - yx), (yz - zy, xx - yy - zz, xy + yx, zx + xz),
                                         (zx - xz, xy + yx, yy - xx - zz, yz + zy), (xy - yx, zx + xz, yz + zy, zz - xx - yy))))
    scale = 1.0
    if with_scale and spread > 0:
        scale = sum(R[i][j] * m[j][i] for i in range(3) for j in range(3)) / spread
    sR = [[scale * value for value in row] for row in R]
    shift = [to_centre[i] - sum(sR[i][k] * from_centre[k] for k in range(3)) for i in range(3)]
    return [tuple(a * x + b * y + c * z + s for (a, b, c), s in zip(sR, shift)) for x, y, z in estimate]


def errors(estimate, truth):
    return [distance(a, b) for a, b in zip(estimate, truth)]


def rmse(values):
    return math.sqrt(sum(e * e for e in values) / len(values)) if values else None


def robust_errors(estimate, truth, with_scale):
    """Errors after the robust alignment."""
    found = errors(align(estimate, truth, with_scale), truth)
    for _ in range(ROUNDS):
        threshold = max(statistics.median(found), 1e-9)
        found = errors(align(estimate, truth, with_scale, [min(1.0, threshold / max(e, 1e-12)) for e in found]), truth)
    return found


# ---- One run ----------------------------------------------------------------------------------------------------------

def key_of(stamp):
    """Stamps as keys: microseconds, which a double holds for dates too."""
    return round(stamp * 1e6)


class Run:
    """The results that `covis run` left in a folder."""

    def __init__(self, frames, online, final):
        self.frames = frames  # lines of stats.jsonl
        self.online = online  # trajectory_online.txt: microseconds to position
        self.final = final    # by submap, trajectory.txt first: the same

    @classmethod
    def read(cls, folder):
        def positions(name):
            return {key_of(stamp): position for stamp, position in read_positions(folder / name)}

        final = [positions('trajectory.txt')]
        while (folder / f'trajectory_map{len(final)}.txt').exists():
            final.append(positions(f'trajectory_map{len(final)}.txt'))
        frames = [json.loads(line) for line in (folder / 'stats.jsonl').read_text().splitlines()]
        return cls(frames, positions('trajectory_online.txt'), final)

    def claim(self, frame):
        """The pose a frame was said to have: (the world it is in, position), or None for a frame that claimed none.

        An older covis tells no online poses of submaps but the first: the final ones stand for them. A frame that was
        located afterwards claimed none when it was tracked: afterwards() has it."""
        if frame['state'] != 'tracking' or frame.get('tentative') or frame.get('method') == 'backtracked':
            return None
        if 'online' in frame:
            return ('online', frame['online']['submap']), tuple(frame['online']['position_m'])
        key, submap = key_of(frame['stamp']), frame.get('map', 0)
        if submap == 0 and key in self.online:
            return ('online', None), self.online[key]
        position = self.final[submap].get(key) if submap < len(self.final) else None
        return position and (('final', submap), position)


    def afterwards(self):
        """Frames that were located afterwards, by the submap that their final poses are in."""
        found = {}
        for frame in self.frames:
            if frame['state'] == 'tracking' and frame.get('method') == 'backtracked':
                found.setdefault(frame.get('map', 0), []).append(frame)
        return found


def ate(positions, truth, with_scale):
    """RMSE of positions by their stamp's key against true ones by the same; None when fewer than three have truth."""
    keys = [key for key in positions if key in truth]
    if len(keys) < 3:
        return None
    true = [truth[key] for key in keys]
    return rmse(errors(align([positions[key] for key in keys], true, with_scale), true))


def claimed_wrong(run, truth, path, with_scale):
    """The frames that said `tracking`, not tentative, and were wrong. truth: position by key."""
    worlds = {}
    for frame in run.frames:
        claim, true = run.claim(frame), truth.get(key_of(frame['stamp']))
        if claim and true:
            worlds.setdefault(claim[0], []).append((frame['frame'], claim[1], true))
    judged = []  # (error, frame)
    for poses in worlds.values():
        if len(poses) >= 3:
            numbers, estimate, true = zip(*poses)
            judged += zip(robust_errors(estimate, true, with_scale), numbers)
    # Those located afterwards are judged among all final poses of their submap.
    for submap, frames in run.afterwards().items():
        final = run.final[submap]
        keys = [key for key in final if key in truth]
        if len(keys) >= 3:
            error = dict(zip(keys, robust_errors([final[key] for key in keys], [truth[key] for key in keys], with_scale)))
            judged += [(error[key_of(frame['stamp'])], frame['frame']) for frame in frames if key_of(frame['stamp']) in error]
    if not judged:
        return {'claims': 0, 'wrong': 0, 'wrong_path': 0, 'wrong_median': 0, 'wrong_both': 0, 'wrong_frames': []}
    floor = max(FLOOR_M, FLOOR_SHARE * path)
    median = statistics.median(e for e, _ in judged)
    by_path, by_median = max(floor, WRONG_SHARE * path), max(floor, WRONG_MEDIANS * median)
    wrong = sorted((frame, round(e, 4)) for e, frame in judged if e > min(by_path, by_median))

    def above(bound):
        return sum(e > bound for e, _ in judged)

    return {'claims': len(judged), 'claim_median_m': median, 'claim_worst_m': max(judged)[0], 'wrong': len(wrong), 'wrong_path': above(by_path),
            'wrong_median': above(by_median), 'wrong_both': above(max(by_path, by_median)), 'wrong_frames': wrong}


def share(part, whole):
    return part / whole if whole else 0.0


def figures(run, truth, with_scale):
    """All that is told of a run from its poses. truth: (seconds, position) by rising stamp, or None."""
    tracked = [frame for frame in run.frames if frame['state'] == 'tracking']
    found = {'frames': len(run.frames), 'tracked': share(len(tracked), len(run.frames)),
             'tracked_in_first_map': share(sum(frame.get('map', 0) == 0 for frame in tracked), len(run.frames)),
             'late': sum(frame['state'] == 'late' for frame in run.frames)}
    if not truth:
        return found
    true = {}
    for frame in run.frames:
        position = truth_at(truth, frame['stamp'])
        if position:
            true[key_of(frame['stamp'])] = position
    path = path_length([true[key] for key in sorted(true)])
    paired = sum(key_of(frame['stamp']) in true for frame in tracked)
    found.update(frames_with_truth=len(true), tracked_of_paired=share(paired, len(true)), path_m=path,
                 ate_m=ate(run.final[0], true, with_scale), ate_online_m=ate(run.online, true, with_scale))
    found.update(claimed_wrong(run, true, path, with_scale))
    return found
