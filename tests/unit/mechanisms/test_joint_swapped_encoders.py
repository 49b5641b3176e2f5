"""Opposite encoders that are swapped: the camera tells before anything has moved."""

import pytest

from controllers.spherical_joint.types import CameraSample
from rig.hal import SafetyError
from rig.mechanisms.joint.alarms.camera import MarkerWatch
from rig.mechanisms.joint.alarms.settings import TwistAlarm

ENCODERS = ("e1", "e2", "e3", "e4")
LIMIT, GRACE, FRAME = 3e-3, 0.05, 1 / 60


def looked_at(encoders, camera):
    """Watch a ring at rest until it is refused; return the time and what was said."""
    watch = MarkerWatch("camera", LIMIT, GRACE, TwistAlarm(), ENCODERS)
    for frame in range(60):
        t = frame * FRAME
        watch.take(encoders, t)
        try:
            watch.check(CameraSample(camera, t))
        except SafetyError as error:
            return t, str(error)
    return None


@pytest.mark.parametrize(
    ("camera", "names"),
    [
        ((4e-3, -5e-3, 50e-3), "e1 and e3 are swapped"),
        ((-4e-3, 5e-3, 50e-3), "e2 and e4 are swapped"),
        ((-4e-3, -5e-3, 50e-3), "e1 and e3, and e2 and e4, are swapped"),
    ],
)
def test_the_mirrored_pose_is_told_by_the_camera_before_anything_moves(camera, names):
    t, said = looked_at((4e-3, 5e-3, 50e-3), camera)
    assert GRACE < t <= GRACE + 2 * FRAME
    assert names in said
    assert "before anything has moved" in said


def test_nearly_upright_a_mirrored_pose_is_no_contradiction():
    assert looked_at((0.5e-3, 1e-3, 52e-3), (0.5e-3, -1e-3, 52e-3)) is None


@pytest.mark.parametrize(
    ("encoders", "camera"),
    [
        ((4e-3, 5e-3, 50e-3), (12e-3, 5e-3, 50e-3)),
        # Near upright the mirrored place is as near to any other one.
        ((0.0, 0.2e-3, 52e-3), (0.0, -2.9e-3, 52e-3)),
    ],
)
def test_a_marker_elsewhere_is_not_blamed_on_the_encoders(encoders, camera):
    _, said = looked_at(encoders, camera)
    assert "swapped" not in said
    assert "another rig's calibration" in said
