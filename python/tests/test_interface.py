# SPDX-License-Identifier: Apache-2.0
"""Every name of the public headers is in Python, under the same name or where this file says."""
import functools
import re
import sys

import covis
from conftest import ROOT

sys.path.insert(0, str(ROOT / 'tools'))
from cpp_outline import Outline  # noqa: E402

# Structs and enums whose members are elsewhere; `Slam.track({})` are arguments of a call.
TYPES = {
    'SensorType': 'Sensor.{}', 'LensType': 'Lens.{}', 'Event::Kind': 'EventKind.{}',
    'CameraParameters': 'Camera.{}', 'MapSnapshot': 'Snapshot.{}', 'MapSnapshot::Submap': 'Submap.{}',
    'SlamOptions': 'Slam.__init__({})', 'Frame': 'Slam.track({})',
    # Lists of structs are columns.
    'MapSnapshot::KeyFrame': 'Snapshot.key_frame_{}s', 'MapSnapshot::Point': 'Snapshot.point_{}s',
    'MapSnapshot::Edge': 'Snapshot.edge_{}', 'TrajectoryPose': 'Trajectory.{}s',
}
# Names that these rules do not lead to.
NAMES = {
    'Slam.create': 'Slam.__init__', 'Slam.set_mode': 'Slam.mode',
    'name': 'NoPoseReason.none.name', 'version': '__version__', 'kNoColour': 'NO_COLOUR',
    'ColourImage.order': 'Slam.track(order)',
    'MapSnapshot.key_frames': 'Snapshot.key_frame_ids', 'MapSnapshot.trajectory': 'Snapshot.positions',
    'MapSnapshot::KeyFrame.pose': 'Snapshot.key_frame_positions',
    'MapSnapshot::Edge.a': 'Snapshot.edges', 'MapSnapshot::Edge.b': 'Snapshot.edges',
    'MapSnapshot::Edge.loop': 'Snapshot.edge_loops',
    'MapSnapshot::Observation.key_frame': 'Snapshot.observations',
    'MapSnapshot::Observation.point': 'Snapshot.observations',
    'TrajectoryPose.pose': 'Trajectory.positions',
    **{f'MapSnapshot::Point.{axis}': 'Snapshot.points' for axis in 'xyz'},
    **{f'MapSnapshot::Observation.{axis}': 'Snapshot.observation_pixels' for axis in 'uv'},
    **{f'TrackedPoint.{member}': 'Slam.tracked_points' for member in ('u', 'v', 'point', 'x', 'y', 'z')},
}
# Names that Python does not have, and why.
ABSENT = {
    **{f'{image}.{member}': 'a NumPy array has it'
       for image in ('GreyImage', 'DepthImage', 'ColourImage') for member in ('data', 'width', 'height', 'stride')},
    'Slam.Impl': 'private', 'Slam.impl_': 'private',
}


def declared():
    """{name: number of an enumerator, or None}, for example Pose.x, Slam.track, SensorType.rgbd, describe, kNoColour."""
    names = {}
    for header in sorted((ROOT / 'include' / 'covis').glob('*.h*')):
        text = header.read_text()
        outline = Outline(text)
        for each in outline.classes:
            names.update({f'{each.name}.{member}': None for member in each.fields + each.methods})
        names.update({function.name: None for function in outline.functions if '::' not in function.name})
        code = re.sub(r'//.*', '', text)
        names.update({name: None for name in re.findall(r'^inline constexpr \w+ (k\w+)', code, re.MULTILINE)})
        for indent, enum, values in re.findall(r'^( *)enum class (\w+) \{(.*?)\}', code, re.DOTALL | re.MULTILINE):
            enum = 'Event::' * bool(indent) + enum
            names.update({f'{enum}.{value}': k for k, value in enumerate(re.findall(r'\w+', values))})
    return names


def find(path):
    """The thing of a path, or the call whose parameter it names; raises when there is none."""
    path, _, parameter = path.rstrip(')').partition('(')
    thing = functools.reduce(getattr, path.split('.'), covis)
    if parameter and parameter not in re.findall(r'(\w+): ', thing.__doc__.splitlines()[0]):
        raise AttributeError(parameter)
    return thing


def test_python_has_every_name_of_the_headers():
    names, missing = declared(), []
    assert len(names) > 150 and 'Setting.type' in names and 'NoPoseReason.pose_uncertain' in names and 'set_log_sink' in names
    for name, number in names.items():
        if name in ABSENT:
            continue
        struct, _, member = name.rpartition('.')
        path = NAMES.get(name) or TYPES.get(struct, f'{struct}.{{}}' if struct else '{}').format(member)
        try:
            found = find(path)
        except AttributeError:
            missing.append(f'{name}: no covis.{path}')
            continue
        assert number is None or int(found) == number, name
    assert missing == []


def test_the_lists_of_exceptions_name_what_there_is():
    names = declared()
    assert [name for name in [*NAMES, *ABSENT] if name not in names] == []
    assert set(TYPES) <= {name.rpartition('.')[0] for name in names}
    assert not set(NAMES) & set(ABSENT)
