# SPDX-License-Identifier: Apache-2.0
"""Covis: visual SLAM for monocular, stereo and RGB-D cameras.

    import covis
    recording = covis.Recording('office')                     # a TUM, KITTI, EuRoC or image folder, a video, a camera
    slam = covis.Slam(recording.camera, recording.sensor, timing=covis.Timing.deterministic,
                      vocabulary=covis.default_vocabulary())
    for frame in recording:
        result = slam.track(frame.stamp, frame.image, right=frame.right, depth=frame.depth)
    slam.finish()
    print(covis.evaluate(slam.trajectory(), recording.truth()))

Images are NumPy arrays (height, width): uint8 for grey images, float32 metres for depth; they are read where they lie.
Arrays that come out are views which can't be written; copy them to change them. Stamps are in nanoseconds, lengths in
metres; a pose is T_wc, camera to world, with the camera's x to the right, y down and z forward.

One thread calls what is not a question: track, tracked_points, locate, finish, reset, load_map, on_event, and sets mode. Any
thread may ask for snapshot, trajectory, save_map, mode, camera and settings meanwhile. The interpreter's lock is released while Covis works.
"""
from ._covis import *  # noqa: F401,F403
from ._covis import Slam, __version__, _trajectory_of  # noqa: F401
from .plot import plot  # noqa: F401
from .vocabulary import default_vocabulary  # noqa: F401

Slam.trajectory = lambda self: _trajectory_of(self)
Slam.trajectory.__doc__ = 'The poses of all frames so far, with every correction: a Trajectory.'
