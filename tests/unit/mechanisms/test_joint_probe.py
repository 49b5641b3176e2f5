"""The motion that shows a pair's loop of the joint: in one plane, smooth, shaken alike each way."""

import math

import numpy as np
import pytest

from rig.mechanisms.joint.references.probe import JointProbe

STEP = 1e-4


@pytest.fixture(params=[(0.7, 0.0, 1.2), (0.8, 0.5 * math.pi, 1.3), (0.9, 2.0, 1.5)])
def probe(request):
    tilt, azimuth, rate = request.param
    return JointProbe(tilt=tilt, azimuth=azimuth, rate=rate, repeats=2)


def sampled(probe):
    t = np.arange(0.0, probe.duration, STEP)
    return t, np.array([[*one.axis, *one.velocity, *one.acceleration]
                        for one in map(probe.at, t.tolist())])  # fmt: skip


def test_the_axis_stays_in_its_plane_and_within_its_tilt(probe):
    _, motion = sampled(probe)
    axis = motion[:, :3]
    assert np.linalg.norm(axis, axis=1) == pytest.approx(1.0)
    across = axis @ [-math.sin(probe.azimuth), math.cos(probe.azimuth), 0.0]
    assert np.abs(across).max() < 1e-12
    assert np.arccos(axis[:, 2]).max() == pytest.approx(probe.tilt, abs=1e-6)
    towards = axis @ [math.cos(probe.azimuth), math.sin(probe.azimuth), 0.0]
    assert towards.min() == pytest.approx(-math.sin(probe.tilt), abs=1e-6), "it begins there"
    assert towards[0] == pytest.approx(-math.sin(probe.tilt))


def test_velocity_and_acceleration_are_those_of_the_axis(probe):
    _, motion = sampled(probe)
    axis, velocity, acceleration = np.split(motion, 3, axis=1)
    assert np.abs(np.gradient(axis, STEP, axis=0) - velocity)[1:-1].max() < 2e-3 * probe.rate
    off = np.abs(np.gradient(velocity, STEP, axis=0) - acceleration)[1:-1].max(axis=1)
    largest = np.abs(acceleration).max()
    assert np.count_nonzero(off > 0.02 * largest) <= 3 * 2 * 4 * probe.repeats, "but for its turns"


def test_each_glide_is_judged_over_a_period_in_which_it_never_turns_round(probe):
    _, motion = sampled(probe)
    names = [segment.name for segment in probe.segments]
    assert names == ["glide +1", "glide -1", "glide +2", "glide -2"]
    for segment in probe.segments:
        assert segment.end - segment.start == pytest.approx(probe.period)
        part = motion[round(segment.start / STEP) : round(segment.end / STEP), 3:6]
        rates = np.linalg.norm(part, axis=1)
        assert rates.min() > 0.999 * (1.0 - probe.shake) * probe.rate
        assert rates.max() < 1.001 * (1.0 + probe.shake) * probe.rate


def test_a_glide_that_is_over_too_soon_is_refused_in_degrees():
    with pytest.raises(ValueError, match=r"a glide of 40 deg at 1\.396 rad/s takes 0\.5 s"):
        JointProbe(tilt=math.radians(20.0))
