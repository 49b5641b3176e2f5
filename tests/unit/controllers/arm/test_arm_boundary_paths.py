"""Paths along the boundary of the workspace, to it, from it, touching it and leaving it."""

import math
import re

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from twist_oracle import hand_of

from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
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
    with pytest.raises(InfeasibleMotion, match="m the path leaves the workspace") as refused:
        plan(points)
    said = re.search(
        r"after (\S+) m of \S+ m the path leaves.* m\. It is farthest outside after "
        r"(\S+) m of \S+ m, by (\S+) mm\.$",
        str(refused.value),
    )
    gone = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(spline, axis=0), axis=1))))
    assert np.interp(float(said[1]), gone, beyond) > -1e-8
    assert 1e-3 * float(said[3]) == pytest.approx(beyond.max(), rel=0.01)
    assert np.interp(float(said[2]), gone, beyond) == pytest.approx(beyond.max(), rel=0.01)
