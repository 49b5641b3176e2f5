"""Paths along the boundary of the workspace, to it, from it, touching it and leaving it."""

import math
import re

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from twist_oracle import hand_of

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import TurnBack
from controllers.arm.pose_path import PosePath
from controllers.motion import InfeasibleMotion

ARM = ArmGeometry()
REACH = ARM.a2 + ARM.a3
NEAR = (0.0, 0.6, 0.8, 0.0, 0.4, 0.0)
TOOL = hand_of(ARM, NEAR)[1].apply([0.0, 0.0, ARM.d6])
PERIOD = 5e-3
HEIGHTS = np.linspace(0.2, 0.8, 25)


def place(distance, azimuth, height):
    """Return the tool point whose wrist is so far from the shoulder."""
    flat = distance * math.cos(height)
    wrist = (flat * math.cos(azimuth), flat * math.sin(azimuth), distance * math.sin(height))
    return np.array(wrist) + TOOL


def spline_of(points):
    """Return the places of the spline through points, by length along the chords."""
    u = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    return CubicSpline(u, points)(np.linspace(0.0, u[-1], 20_001))


def plan(points, speed=0.1):
    law = LookAhead(LookAheadSettings(), ARM, PERIOD)
    return law.prepare(PosePath(points=tuple(map(tuple, points)), near=NEAR, speed=speed))


PATHS = {
    "along it, 1 mm inside": [place(REACH - 1e-3, 0.2 * x, x) for x in HEIGHTS],
    "along it, 1 um inside": [place(REACH - 1e-6, 0.2 * x, x) for x in HEIGHTS],
    "along it": [place(REACH, 0.2 * x, x) for x in HEIGHTS],
    "touching it": [place(REACH - 0.5 * (x - 0.5) ** 2, 0.2 * x, x) for x in HEIGHTS],
    "touching it, few places": [
        place(REACH - 0.5 * (x - 0.5) ** 2, 0.2 * x, x) for x in np.linspace(0.2, 0.8, 5)
    ],
    "passing it by 1 um": [place(REACH - 1e-6 - 0.5 * (x - 0.5) ** 2, x, x) for x in HEIGHTS],
    "along it and away": [
        place(REACH - 0.5 * max(0.0, x - 0.5) ** 2, 0.1, x) for x in np.linspace(0.2, 0.8, 400)
    ],
    "straight to it": [place(REACH - 0.1 * x, 0.1, 0.5) for x in np.linspace(1.0, 0.0, 9)],
    "to it": [place(REACH - 0.1 * x, 0.2 - 0.1 * x, 0.5) for x in np.linspace(1.0, 0.0, 9)],
    "from it": [place(REACH - 0.1 * x, 0.1 + 0.1 * x, 0.5) for x in np.linspace(0.0, 1.0, 9)],
}


@pytest.mark.parametrize("name", PATHS)
def test_a_path_at_the_boundary_is_followed_within_all_limits(name):
    points = np.array(PATHS[name])
    made, spline = plan(points), spline_of(points)
    q = made.positions
    mean = np.diff(q, axis=0)[:-1] / PERIOD  # the last step is shorter
    assert (np.abs(mean) / np.array(ARM.rate_limits)).max() < 1.001
    harder = np.diff(mean, axis=0, prepend=np.zeros((1, 6))) / PERIOD
    assert (np.abs(harder) / np.array(ARM.acceleration_limits)).max() < 1.001
    tool = hand_of(ARM, NEAR)[1]
    for joints in q[::4]:
        at, turn = hand_of(ARM, joints)
        chord = np.linalg.norm(spline - at, axis=1).min()
        assert chord < 0.5 * np.linalg.norm(np.diff(spline, axis=0), axis=1).max() + 1e-6
        assert (turn * tool.inv()).magnitude() < 1e-6
    assert made.path_deviation < 1e-7
    assert np.linalg.norm(hand_of(ARM, q[-1])[0] - points[-1]) < 1e-8


@pytest.mark.parametrize("seed", range(8))
def test_a_spline_that_leaves_the_workspace_is_refused_with_where_it_is_farthest_outside(seed):
    """Between places that are all inside a spline may bulge out of the workspace."""
    rng = np.random.default_rng((31, seed))
    inside = 10 ** rng.uniform(-7, -3)
    heights = np.linspace(rng.uniform(0.0, 0.3), rng.uniform(0.5, 1.0), rng.integers(3, 9))
    points = [place(REACH - inside * rng.uniform(0.5, 1), 0.5 * x, x) for x in heights]
    spline = spline_of(np.array(points))
    beyond = np.linalg.norm(spline - TOOL, axis=1) - REACH
    if beyond.max() < 1e-8:
        assert plan(points).path_deviation < 1e-7
        return
    with pytest.raises(InfeasibleMotion, match="the path leaves the workspace") as refused:
        plan(points)
    said = re.search(
        r"after (\S+) m of \S+ m, between places \d and \d the path leaves.* m\. It is farthest "
        r"outside after (\S+) m of \S+ m, between places \d and \d, by (\S+) mm\.",
        str(refused.value),
    )
    gone = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(spline, axis=0), axis=1))))
    assert np.interp(float(said[1]), gone, beyond) > -1e-8
    assert 1e-3 * float(said[3]) == pytest.approx(beyond.max(), rel=5e-3)
    assert np.interp(float(said[2]), gone, beyond) == pytest.approx(beyond.max(), rel=0.01)


def test_how_far_a_narrow_bulge_leads_outside_is_found_between_the_places_looked_at():
    """Of 500 places along the path none is near its top: 12 percent were missing."""
    ahead = np.linspace(-0.5, 0.5, 21)
    points = [place(REACH - 0.1, x, 0.3) for x in ahead]
    points.insert(11, place(REACH + 5e-5, 0.021, 0.3))
    spline = spline_of(np.array(points))
    beyond = np.linalg.norm(spline - TOOL, axis=1) - REACH
    with pytest.raises(InfeasibleMotion, match="farthest outside") as refused:
        plan(points)
    said = re.search(
        r"farthest outside after \S+ m of \S+ m, between.*, by (\S+) mm", str(refused.value)
    )
    assert 1e-3 * float(said[1]) == pytest.approx(beyond.max(), rel=5e-3)


def test_a_line_through_the_void_round_the_axis_of_q1_is_refused_at_once():
    """It was integrated for 33 s, and then refused for a hand 40 mm off its path."""
    arm = ArmGeometry(a2=0.315, a3=0.407, d6=0.178, base_height=0.067, shoulder_offset=0.146)
    start = (-0.15, -0.405, 0.965, 1.288, -0.552, -0.247)
    path = TurnBack(start=start, direction=(-0.97, -0.0135, -1.0), speed=0.05, turn_rate=0.0)
    with pytest.raises(InfeasibleMotion) as refused:
        LookAhead(LookAheadSettings(), arm, PERIOD).prepare(path)
    said = re.search(
        r"after (\S+) m the line leads the wrist centre to (\S+) m from the axis of q1, nearer "
        r"than the shoulder's offset of 0\.146 m",
        str(refused.value),
    )
    at, turn = hand_of(arm, start)
    way = np.array(path.direction) / np.linalg.norm(path.direction)
    wrist = at + float(said[1]) * way - turn.apply([0.0, 0.0, arm.d6])
    assert np.hypot(*wrist[:2]) == pytest.approx(float(said[2]), abs=1e-4)


def test_where_an_arm_is_stretched_that_reaches_on_by_its_other_side_alone_it_is_said():
    """With a1 the boundary of a branch lies within that of the arm."""
    arm = ArmGeometry(a2=0.25, a3=0.29, d6=0.08, a1=-0.06, shoulder_offset=0.036)
    path = PosePath(
        points=((0.30, 0.25, 0.10), (0.55, 0.20, 0.10)), near=(0.3, 0.6, 0.6, 0.0, 0.5, 0.0)
    )
    with pytest.raises(InfeasibleMotion, match=r"the elbow's singularity \(S3 = .*on this branch"):
        LookAhead(LookAheadSettings(), arm, PERIOD).prepare(path)


@pytest.mark.parametrize("seed", range(6))
def test_a_path_begins_and_ends_at_the_wrists_singularity(seed):
    """Which q4 it begins with is for the path to say."""
    rng = np.random.default_rng((32, seed))
    near = (*rng.uniform((-1.0, 0.0, 1.0), (1.0, 0.5, 1.8)), rng.uniform(-1, 1), 0.0, 0.0)
    begin, turn = hand_of(ARM, near)
    way = rng.normal(size=3)
    bent = begin + np.outer(np.linspace(0.0, 0.1, 4), way / np.linalg.norm(way))
    bent[1:3] += 0.01 * rng.normal(size=(2, 3))
    points = [bent, bent[::-1]][seed % 2]
    law = LookAhead(LookAheadSettings(), ARM, PERIOD)
    made = law.prepare(PosePath(points=tuple(map(tuple, points)), near=near))
    ends = np.sin(made.positions[[0, -1], 4])
    assert abs(ends[seed % 2 and -1]) < 1e-6
    for joints in made.positions[::5]:
        assert (hand_of(ARM, joints)[1] * turn.inv()).magnitude() < 1e-6
    assert (made.rates / np.array(ARM.rate_limits)).max() < 1.001


def test_a_path_begins_at_the_wrists_singularity_on_the_branch_that_is_near():
    """Reaching back the arm would begin with a q4 that is nearer, and cannot go on from there."""
    arm = ArmGeometry(a2=0.579, a3=0.205, d6=0.18, base_height=0.409, wrist_sign=-1, a1=0.084)
    near = (-0.2457, -0.1996, 1.0639, -0.6239, 0.0, -0.4377)
    begin = hand_of(arm, near)[0]
    points = tuple(tuple(begin + x * np.array([0.0579, 0.0192, -0.0913])) for x in (0.0, 0.5, 1.0))
    made = LookAhead(LookAheadSettings(), arm, PERIOD).prepare(PosePath(points=points, near=near))
    assert np.linalg.norm(made.positions[0, :3] - near[:3]) < 1e-6
    for joints in made.positions[::5]:
        at, turn = hand_of(arm, joints)
        assert np.linalg.norm(np.cross(at - begin, points[-1] - begin)) < 1e-9
        assert (turn * hand_of(arm, near)[1].inv()).magnitude() < 1e-6


@pytest.mark.parametrize("seed", [0, 3, 5])
def test_the_hand_keeps_its_speed_where_a_spline_bends_sharply(seed):
    rng = np.random.default_rng((33, seed))
    steps = np.cumsum(rng.normal(size=(50, 3)) * 0.03, axis=0)
    bends = CubicSpline(np.linspace(0.0, 1.0, 50), steps - steps[0])(np.linspace(0.0, 1.0, 200))
    points = bends + hand_of(ARM, NEAR)[0] - 0.15 * TOOL / ARM.d6
    path = PosePath(points=tuple(map(tuple, points)), near=NEAR, speed=0.05)
    trajectory = path.trajectory(dimensions_of(ARM))
    t = np.linspace(0.0, trajectory.duration, 20_001)
    speeds = [np.linalg.norm(trajectory.twist(at).linear) for at in t.tolist()]
    assert np.abs(np.array(speeds) / path.speed - 1.0).max() < 1e-3
