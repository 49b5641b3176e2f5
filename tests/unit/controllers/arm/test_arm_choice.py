"""Where a path begins if not as near as asked, and what is said of the singularities on it."""

import math
import re

import numpy as np
import pytest
from arm_cases import radians
from drawn_cases import WIDE, faults_of, hand_of
from test_arm_path import drawn, spline_of

from controllers.arm import look_ahead, retiming
from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import Line
from controllers.arm.plan import OutOfRange, RangeWatch
from controllers.arm.singular_places import NEAR, singular_places
from controllers.motion import InfeasibleMotion

GEOMETRY = ArmGeometry(**WIDE)
PERIOD = 5e-3
EVERY = range(6)


def plan(path, geometry=GEOMETRY):
    return LookAhead(LookAheadSettings(), geometry, PERIOD).prepare(path)


def narrowed(made, joint, room=0.05):
    """Return an arm of which one joint may not go where a plan has it, nor a turn away."""
    low, high = list(WIDE["position_min"]), list(WIDE["position_max"])
    if made.positions[0, joint] < 0.0:  # the other branch is across the singularity
        low[joint] = float(made.positions[:, joint].max()) + room
        high[joint] = low[joint] + math.pi
    else:
        high[joint] = float(made.positions[:, joint].min()) - room
        low[joint] = high[joint] - math.pi
    return ArmGeometry(position_min=tuple(low), position_max=tuple(high))


@pytest.mark.parametrize("joint", [2, 4])
def test_a_path_is_begun_on_a_branch_that_keeps_the_ranges(joint):
    path = drawn(3)
    free = plan(path)
    geometry = narrowed(free, joint)
    made = plan(path, geometry)
    assert faults_of(geometry, path, made, EVERY, EVERY) == []
    assert (made.positions >= np.array(geometry.position_min)).all()
    assert (made.positions <= np.array(geometry.position_max)).all()
    at, tool = hand_of(geometry, path.near)
    spline, end = spline_of(np.array(path.points) @ tool.T + at)
    for row, u in ((0, 0.0), (-1, end)):
        hand, turned = hand_of(geometry, made.positions[row])
        np.testing.assert_allclose(hand, spline(u), atol=1e-9)
        np.testing.assert_allclose(turned, tool, atol=1e-9)
    (note,) = made.notes
    assert note.startswith("on the branch ")
    assert f"q{joint + 1} would be at" in note


def test_if_no_branch_keeps_the_ranges_that_is_said_with_how_many_were_tried(monkeypatch):
    """Of the others the joints alone are looked at: 7 timings took a minute."""
    path = drawn(3)
    free = plan(path)
    low, high = list(WIDE["position_min"]), list(WIDE["position_max"])
    low[2], high[2] = 2.7, 2.8  # more bent than any way to the path is
    with pytest.raises(InfeasibleMotion, match=r"None of 7 other branches keeps all ranges\."):
        plan(path, ArmGeometry(position_min=tuple(low), position_max=tuple(high)))
    assert not free.notes
    timings = []

    def counted(*args):
        timings.append(args)
        return retiming.retime_within(*args)

    monkeypatch.setattr(look_ahead, "retime_within", counted)
    with pytest.raises(InfeasibleMotion, match="None of 7 other branches"):
        plan(path, ArmGeometry(position_min=tuple(low), position_max=tuple(high)))
    assert len(timings) == 1


def test_joints_are_watched_for_the_first_that_no_whole_turns_keep_in_its_range():
    watch = RangeWatch(ArmGeometry(position_min=(-3.0,) * 6, position_max=(3.0,) * 6))
    watch((7.0, 0.0, 0.0, 0.0, 0.0, 0.0))  # a turn less is within
    watch((4.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(OutOfRange, match=r"q1 would go from 183\.35 to 401\.07 deg") as refused:
        watch((3.2, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert refused.value.turns is None


def test_whole_turns_are_told_with_the_reason():
    path = drawn(3)
    free = plan(path)
    low, high = list(WIDE["position_min"]), list(WIDE["position_max"])
    low[3] = float(free.positions[:, 3].min()) - 0.1 - math.tau
    high[3] = float(free.positions[:, 3].max()) + 0.1 - math.tau
    made = plan(path, ArmGeometry(position_min=tuple(low), position_max=tuple(high)))
    (note,) = made.notes
    assert note.startswith(
        "whole turns away, q4 by -1: from the nearest beginning (near, begin), after "
    )


def places(path):
    made = plan(path)
    return made, singular_places(made.indices, made.positions)


def dense_signs(made, column):
    """Return how often an index changes its sign, of the joints' spline, many times as fine."""
    from scipy.interpolate import CubicSpline

    from controllers.arm.kinematics import dimensions_of, singularity_indices

    arm, t = dimensions_of(GEOMETRY), made.t
    joints = CubicSpline(t, made.positions)(np.linspace(0.0, t[-1], 20 * len(t)))
    values = np.array([singularity_indices(arm, tuple(q))[column] for q in joints.tolist()])
    values = values[np.abs(values) > 1e-7]
    return int(np.count_nonzero(np.diff(np.sign(values))))


@pytest.mark.parametrize("seed", range(8))
def test_every_pass_of_a_singularity_is_told(seed):
    made, found = places(drawn(seed))
    for column, kind in enumerate(("shoulder", "elbow", "wrist")):
        through = [place for place in found if place.kind == kind and place.through]
        assert len(through) == dense_signs(made, column)
        past = [place for place in found if place.kind == kind and not place.through]
        index = np.abs(made.indices[:, column])
        for place in past:
            assert place.size == pytest.approx(index[place.at])
            assert place.size < NEAR[column]
        if index.min() < NEAR[column]:
            assert through or past


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ([0.2, 0.1, -0.1, -0.2], [(1, True)]),
        ([0.2, 0.0, -0.2], [(1, True)]),
        ([0.2, 0.0, 0.2], [(1, False)]),
        ([0.2, 0.01, 0.2, 0.2, -0.02, 0.01, -0.3], [(1, False), (4, True), (5, True), (5, True)]),
        ([0.0, 0.0, 0.2], [(0, False)]),
        ([0.2, 0.3], []),
    ],
)
def test_passes_are_counted_by_the_signs(values, told):
    indices = np.full((len(values), 3), 1.0)
    indices[:, 2] = values
    found = singular_places(indices, np.zeros((len(values), 6)))
    assert [(place.at, place.through) for place in found] == told


def test_a_near_miss_says_by_how_much_and_what_swings():
    path = Line(middle=radians(0, 30, 80, 0, 1, 0), direction=(0.0, 1.0, 0.0))
    made, (place,) = places(path)
    assert (place.kind, place.through) == ("wrist", False)
    assert math.degrees(math.asin(place.size)) == pytest.approx(1.0, abs=0.02)
    close = made.positions[np.abs(made.indices[:, 2]) < NEAR[2]]
    q4, q6 = (math.degrees(np.ptp(close[:, joint])) for joint in (3, 5))
    assert q4 > 90.0  # or it would be no near miss
    swings = r"q4 turns by (\S+) deg and q6 turns by (\S+) deg"
    said = re.match(rf"beside it by (\S+) deg: {swings}", place.words)
    np.testing.assert_allclose([float(n) for n in said.groups()], [1.0, q4, q6], rtol=0.02)
