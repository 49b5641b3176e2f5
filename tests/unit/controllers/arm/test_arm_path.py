"""A path through given places: drawn ones, through and past the wrist's singularity, from files."""

import math

import numpy as np
import pytest
from arm_cases import GEOMETRIES, radians
from drawn_cases import WIDE, faults_of, hand_of
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from controllers.arm.esc import Esc, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.optimum import least_time
from controllers.arm.plain import DampedLeastSquares
from controllers.arm.pose_path import PosePath
from controllers.arm.straight_path import StraightPath
from controllers.arm.types import ArmState
from controllers.motion import InfeasibleMotion

GEOMETRY = ArmGeometry(**WIDE)
PERIOD = 5e-3
EVERY = range(6)


def plan(path, geometry=GEOMETRY):
    return LookAhead(LookAheadSettings(), geometry, PERIOD).prepare(path)


def spline_of(points):
    u = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    return CubicSpline(u, points), u[-1]


def distance(spline, end, point):
    u = np.linspace(0.0, end, 2000)
    k = int(np.argmin(np.linalg.norm(spline(u) - point, axis=1)))
    bounds = (u[max(k - 1, 0)], u[min(k + 1, len(u) - 1)])
    found = minimize_scalar(
        lambda x: np.linalg.norm(spline(x) - point),
        bounds=bounds, method="bounded", options={"xatol": 1e-12},
    )  # fmt: skip
    return found.fun


def drawn(seed):
    """Return a path about a place at or near the wrist's singularity, seen from the tool."""
    rng = np.random.default_rng((61, seed))
    miss = float(rng.choice([0.0, 1e-3, 1e-2, 0.3]))
    near = (float(rng.uniform(-1, 1)), 0.35, 1.5, 0.0, miss, 0.0)
    steps = rng.normal(scale=0.03, size=(4, 3)) + np.array((-0.05, 0.0, 0.0))
    points = np.cumsum(np.insert(steps, 0, (0.1, 0.0, 0.0), axis=0), axis=0)
    if miss == 0.0:
        points[:, 1] = 0.0  # in the arm's plane, through the singularity itself
    return PosePath(
        points=tuple(map(tuple, points.tolist())), near=near, frame="start",
        speed=float(rng.uniform(0.05, 0.3)),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_the_hand_is_on_the_spline_and_the_joints_within_their_limits(seed):
    path = drawn(seed)
    made = plan(path)
    at, tool = hand_of(GEOMETRY, path.near)
    spline, end = spline_of(np.array(path.points) @ tool.T + at)
    hands = [hand_of(GEOMETRY, q) for q in made.positions.tolist()]
    assert max(distance(spline, end, hand) for hand, _ in hands[::7]) < 1e-6
    assert max(np.abs(turned - tool).max() for _, turned in hands) < 1e-6
    np.testing.assert_allclose(hands[0][0], spline(0.0), atol=1e-9)
    np.testing.assert_allclose(hands[-1][0], spline(end), atol=1e-9)
    speeds = np.linalg.norm(np.diff([hand for hand, _ in hands], axis=0), axis=1) / PERIOD
    assert speeds.max() <= path.speed * (1 + 3e-3)  # met at the points of the timing's grid
    assert faults_of(GEOMETRY, path, made, EVERY, EVERY) == []
    assert made.duration <= 1.25 * least_time(GEOMETRY, path)


@pytest.mark.parametrize("seed", range(6))
def test_a_path_of_a_tenth_of_a_millimetre_is_one_too(seed):
    """The joints move by a milliradian: what is near for them is far for its bends."""
    rng = np.random.default_rng((131, seed))
    points = np.cumsum(rng.normal(scale=2e-5, size=(8, 3)), axis=0)
    path = PosePath(
        points=tuple(map(tuple, points.tolist())), near=(0.3, 0.4, 1.2, 0.1, -0.1, 0.0),
        frame="start", speed=float(10 ** rng.uniform(-4, -2)),
    )  # fmt: skip
    for period in (5e-3, 2e-2):
        made = LookAhead(LookAheadSettings(), GEOMETRY, period).prepare(path)
        assert made.path_deviation < 1e-7


def test_it_goes_through_the_wrists_singularity():
    path = next(path for path in map(drawn, range(50)) if path.near[4] == 0.0)
    made = plan(path)
    assert np.ptp(np.sign(made.indices[:, 2])) == 2.0


def written(tmp_path, text):
    file = tmp_path / "places.csv"
    file.write_text(text)
    return PosePath(file=str(file), near=radians(0, 20, 90, 0, 40, 0), frame="start")


def test_a_file_says_places_in_its_units_and_rotations(tmp_path):
    angles = np.radians((0.0, 10.0, 30.0))
    rows = [
        f"{100 * k:g}, {5 * k:g}, 0.02, {math.cos(a / 2)!r}, 0, 0, {math.sin(a / 2)!r}"
        for k, a in enumerate(angles.tolist())
    ]
    path = written(tmp_path, "\n".join(["x (mm), y (cm), z (m), qw, qx, qy, qz", *rows, ""]))
    made = plan(path)
    at, tool = hand_of(GEOMETRY, path.near)
    last, turned = hand_of(GEOMETRY, made.positions[-1])
    np.testing.assert_allclose(last, at + tool @ (0.2, 0.1, 0.02), atol=1e-9)
    c, s = math.cos(angles[-1]), math.sin(angles[-1])
    np.testing.assert_allclose(turned, tool @ [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=1e-9)
    assert made.path_deviation < 1e-6
    assert made.twist_residual < 1e-5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: the header has to name x, y and z"),
        ("x (mm), y (mm)\n1, 2\n", "line 1: the header has to name x, y and z"),
        ("x, y, z\n0, 0, 0\n1, 0, 0\n", "the unit of x is missing"),
        ("x (ft), y (m), z (m)\n0, 0, 0\n", "the unit of x is ft"),
        ("x (m), y (m), z (m), qw\n0, 0, 0, 1\n", "all of qw, qx, qy, qz or none"),
        ("x (m), y (m), z (m)\n0, 0, 0\n0, 1_0, 0\n", "line 3, column 2 (y): '1_0' is no number"),
        ("x (m), y (m), z (m)\n0, 0, 0\n0, nan, 0\n", "line 3, column 2 (y): 'nan' is no number"),
        (
            "x (m), y (m), z (m)\n0, 0, 0\n0, 1\n",
            "line 3: of its 2 cells none is z, which is column 3",
        ),
        (
            "x (m), y (m), z (m)\n0, 0, 0\n0, 0, 0\n",
            "line 3: place 2 of the path is place 1 again.",
        ),
        (
            "x (mm), y (mm), z (mm)\n500, 0, 0\n\n500.0000000001, 0, 0\n",
            "line 4: place 2 of the path is place 1 again, 1e-10 mm away; 1e-06 mm are the least.",
        ),
        (
            "x (m), y (m), z (m), qw, qx, qy, qz\n0, 0, 0, 1, 0, 0, 0\n0, 0, 0, 0.6, 0.8, 0, 0\n",
            "line 3: place 2 of the path is place 1 again, and the tool is turned there. ",
        ),
        ("x (m);y (m);z (m)\n0;0;0\n0;0,1;0\n", "line 1: semicolons separate its cells; write c"),
        ("x (m), y (m), z (m)\n0, 0, 0\n", "needs two places at least; there is 1"),
        ("x (m), y (m), z (m)\n0, 0, 0\n0, 0, 3\n", "leaves the workspace"),
        ("x (m), y (m), z (m)\n3, 0, 0\n3, 0, 3\n", "cannot be begun"),
        (
            "x (m), y (m), z (m), qw, qx, qy, qz\n0, 0, 0, 1, 1, 0, 0\n",
            "line 2: the quaternion's length is 1.414",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_line(tmp_path, text, message):
    with pytest.raises(InfeasibleMotion) as refused:
        plan(written(tmp_path, text))
    assert message in str(refused.value)


def test_a_file_that_is_not_there_is_said(tmp_path):
    with pytest.raises(InfeasibleMotion, match=r"nowhere\.csv"):
        plan(PosePath(file=str(tmp_path / "nowhere.csv")))
    with pytest.raises(ValueError, match="a file or points"):
        PosePath()


@pytest.mark.parametrize("name", ["equal links", "other wrist", "offsets"])
def test_other_arms_do_it_too(name):
    path = drawn(3)
    geometry = GEOMETRIES[name]
    assert plan(path, geometry).path_deviation < 1e-6


def test_a_law_that_plans_lines_says_which_ones_follow_it():
    with pytest.raises(InfeasibleMotion, match="look-ahead"):
        Esc(EscSettings(), GEOMETRY, PERIOD).prepare(drawn(0))


@pytest.mark.parametrize("seed", range(4))
def test_a_line_is_given_by_its_start_and_its_length(seed):
    rng = np.random.default_rng((62, seed))
    start = tuple(rng.uniform((-1, 0.2, 1.2, -1, 0.4, -1), (1, 0.5, 1.8, 1, 1.2, 1)).tolist())
    direction, length = rng.normal(size=3), float(rng.uniform(0.02, 0.1))
    path = StraightPath(start, tuple(direction.tolist()), length)
    for kind, settings in ((Esc, EscSettings()), (LookAhead, LookAheadSettings())):
        made = kind(settings, GEOMETRY, PERIOD).prepare(path)
        np.testing.assert_allclose(made.positions[0], start, atol=1e-12)
        first, _ = hand_of(GEOMETRY, start)
        last, _ = hand_of(GEOMETRY, made.positions[-1])
        way = length * direction / np.linalg.norm(direction)
        np.testing.assert_allclose(last - first, way, atol=1e-9)
        assert faults_of(GEOMETRY, path, made, EVERY, ()) == []


@pytest.mark.parametrize(
    ("law", "joint", "sense", "elsewhere"),
    [(LookAhead, 3, -1, False), (DampedLeastSquares, 5, 1, True)],
)
def test_a_whole_turn_away_is_no_reason_to_refuse(law, joint, sense, elsewhere):
    """Whatever the law: the motion is the same one, and the hand with it."""
    path = drawn(3)
    free = law(law.Settings(), GEOMETRY, PERIOD).prepare(path)
    least, most = free.positions.min(axis=0), free.positions.max(axis=0)
    low, high = list(WIDE["position_min"]), list(WIDE["position_max"])
    low[joint] = float(least[joint]) - 0.1 + sense * 2.0 * math.pi
    high[joint] = float(most[joint]) + 0.1 + sense * 2.0 * math.pi
    narrow = ArmGeometry(position_min=tuple(low), position_max=tuple(high))
    online = law(law.Settings(), narrow, PERIOD)
    made = online.prepare(path)
    away = np.zeros(6)
    away[joint] = sense * 2.0 * math.pi
    np.testing.assert_allclose(made.positions, free.positions + away, atol=1e-9)
    np.testing.assert_allclose(made.hand, free.hand, atol=1e-9)
    # The loop gets what was planned.
    online.reset(ArmState(0.0, tuple(made.positions[0]), (0.0,) * 6))
    commands = [online.update(None, made.at(0.0)).positions for _ in made.t]
    np.testing.assert_allclose(commands, made.positions, atol=1e-12)
    high[joint] -= 0.2
    narrow = ArmGeometry(position_min=tuple(low), position_max=tuple(high))
    online = law(law.Settings(), narrow, PERIOD)
    if elsewhere:  # another branch keeps the ranges
        made = online.prepare(path)
        assert made.notes[0].startswith("on the branch")
        assert (made.positions <= high).all()
        assert (made.positions >= low).all()
        return
    with pytest.raises(InfeasibleMotion, match=f"q{joint + 1} would be at"):
        online.prepare(path)


def test_a_path_over_the_same_ground_is_asked_no_more_often_where_it_is(monkeypatch):
    """A place on it is looked for in all its passes at once, not in each by itself."""

    def asked(lane):
        points = tuple((0.5 + 0.02 * (k % 2), k * lane, 0.1) for k in range(30))
        path = PosePath(points=points, near=radians(0, 20, 90, 0, 30, 0))
        made = path.trajectory(dimensions_of(GEOMETRY))
        places, calls = made._places, []

        def counted(*given):
            calls.append(given)
            return places(*given)

        counted.x = places.x
        monkeypatch.setattr(made, "_places", counted)
        made.foot((0.51, 0.0, 0.1))
        return len(calls)

    assert asked(1e-6) == asked(3e-3)


@pytest.mark.parametrize("seed", range(6))
def test_the_nearest_of_many_passes_is_found(seed):
    """By the least of a fine grid over the whole path."""
    rng = np.random.default_rng((0xF007, seed))
    points = tuple((0.5 + 0.02 * (k % 2), k * 1e-4, 0.1) for k in range(12))
    made = PosePath(points=points, near=radians(0, 20, 90, 0, 30, 0)).trajectory(
        dimensions_of(GEOMETRY)
    )
    at = np.array((0.51, 6e-4, 0.1)) + rng.uniform(-1.0, 1.0, 3) * (8e-3, 5e-4, 1e-3)
    grid = made._places(np.linspace(0.0, float(made._places.x[-1]), 400_001))
    least = float(np.linalg.norm(grid - at, axis=1).min())
    found = float(np.linalg.norm(np.array(made.foot(tuple(at))) - at))
    assert found == pytest.approx(least, abs=1e-9)
