"""Drawn directions of the tool along a path, and drawn frames that a path is seen in."""

import math

import numpy as np
import pytest
from arm_cases import radians
from drawn_cases import WIDE, faults_of, hand_of
from scipy.spatial.transform import Rotation, RotationSpline
from test_arm_places import of_vector

from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.places.frames import TaughtFrame
from controllers.arm.places.turning import Pointed, Splined
from controllers.arm.pose_path import PosePath
from controllers.motion import InfeasibleMotion

GEOMETRY = ArmGeometry(**WIDE)
PERIOD = 5e-3
EVERY = range(6)
NEAR = radians(0, 20, 90, 0, 60, 0)
STEP = 1e-6


def plan(path):
    return LookAhead(LookAheadSettings(), GEOMETRY, PERIOD).prepare(path)


def drawn_directions(seed):
    """Return parameters, unit vectors at most 80 degrees apart, and spins."""
    rng = np.random.default_rng((81, seed))
    vectors = [rng.normal(size=3)]
    vectors[0] /= np.linalg.norm(vectors[0])
    for _ in range(int(rng.integers(1, 6))):
        turn = rng.normal(size=3)
        turn *= rng.uniform(0.0, 1.4) / np.linalg.norm(turn)
        vectors.append(of_vector(turn) @ vectors[-1])
    u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.02, 0.2, len(vectors) - 1))))
    tool = of_vector(rng.normal(size=3) * 2.0)
    return u, np.array(vectors), rng.uniform(-4.0, 4.0, len(u)), tool


def angular(turning, u):
    """Return the angular velocity over the parameter, from two rotations."""
    before, after = turning.at(u - STEP), turning.at(u + STEP)
    skew = (after - before) @ turning.at(u).T / (2.0 * STEP)
    return 0.5 * np.array(
        (skew[2, 1] - skew[1, 2], skew[0, 2] - skew[2, 0], skew[1, 0] - skew[0, 1])
    )


@pytest.mark.parametrize("spun", [False, True])
@pytest.mark.parametrize("seed", range(20))
def test_a_tool_points_where_it_is_told_and_spins_as_it_is_told(seed, spun):
    u, vectors, spins, tool = drawn_directions(seed)
    turning = Pointed(u, [tuple(v) for v in vectors], spins.tolist() if spun else None, tool)
    for at, vector in zip(u, vectors, strict=True):
        np.testing.assert_allclose(turning.at(at)[:, 2], vector, atol=1e-12)
    inner = np.linspace(u[0] + 1e-3, u[-1] - 1e-3, 101)
    for at in inner:
        turn = turning.at(at)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) > 0.0
        rate = angular(turning, at)
        scale = 1.0 + np.linalg.norm(rate)
        np.testing.assert_allclose(turning.rate(at), rate, atol=2e-5 * scale)
        if not spun:  # nothing turns about the tool's own axis
            assert abs(rate @ turn[:, 2]) < 2e-5 * scale


@pytest.mark.parametrize("seed", range(10))
def test_the_spin_is_counted_from_a_tool_that_is_carried_along(seed):
    u, vectors, spins, tool = drawn_directions(seed)
    carried = Pointed(u, [tuple(v) for v in vectors], None, tool)
    spun = Pointed(u, [tuple(v) for v in vectors], spins.tolist(), tool)
    for at, spin in zip(u, spins, strict=True):
        c, s = math.cos(spin), math.sin(spin)
        about = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        np.testing.assert_allclose(spun.at(at), carried.at(at) @ about, atol=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_it_begins_with_the_least_rotation_of_the_tool_that_is_given(seed):
    u, vectors, _, tool = drawn_directions(seed)
    first = Pointed(u, [tuple(v) for v in vectors], None, tool).at(u[0])
    angle = math.acos(min(max(0.5 * (np.trace(first @ tool.T) - 1.0), -1.0), 1.0))
    between = math.acos(min(max(float(tool[:, 2] @ vectors[0]), -1.0), 1.0))
    assert angle == pytest.approx(between, abs=1e-6)


def test_a_tool_that_is_to_point_backwards_is_turned_about_an_axis_across():
    turning = Pointed(np.array((0.0, 1.0)), [(0.0, 0.0, -1.0), (0.0, 1.0, -1.0)], None, np.eye(3))
    first = turning.at(0.0)
    np.testing.assert_allclose(first[:, 2], (0.0, 0.0, -1.0), atol=1e-12)
    assert np.linalg.det(first) == pytest.approx(1.0)


def test_directions_that_leave_the_way_open_are_refused():
    u = np.array((0.0, 0.1, 0.2))
    with pytest.raises(InfeasibleMotion, match=r"by 180\.0 deg from place 2 to place 3"):
        Pointed(u, [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)], None, np.eye(3))


def written(folder, places, directions, spins):
    names = ["x (m)", "y (m)", "z (m)", "tool_x", "tool_y", "tool_z", "spin (rad)"]
    rows = np.column_stack((places, directions, spins)).tolist()
    file = folder / "poses.yaml"
    file.write_text(f"columns: [{', '.join(names)}]\nrows: {rows}\n", encoding="utf-8")
    return str(file)


def drawn_poses(seed):
    """Return places and directions about the posture `NEAR`, and spins; in the base's axes."""
    rng = np.random.default_rng((82, seed))
    hand, tool = hand_of(GEOMETRY, NEAR)
    places = hand + np.cumsum(rng.normal(scale=0.03, size=(4, 3)), axis=0)
    directions = tool[:, 2] + rng.normal(scale=0.25, size=(4, 3))
    return places, directions, rng.uniform(-0.5, 0.5, 4)


@pytest.mark.parametrize("seed", range(4))
def test_the_arm_points_its_tool_along_a_drawn_path(seed, tmp_path):
    places, directions, spins = drawn_poses(seed)
    made = plan(PosePath(file=written(tmp_path, places, directions, spins), near=NEAR, speed=0.2))
    assert made.path_deviation < 1e-6
    assert made.twist_residual < 1e-4
    for row, k in ((0, 0), (-1, -1)):
        at, turn = hand_of(GEOMETRY, made.positions[row])
        np.testing.assert_allclose(at, places[k], atol=1e-9)
        wanted = directions[k] / np.linalg.norm(directions[k])
        np.testing.assert_allclose(turn[:, 2], wanted, atol=1e-9)
    path = PosePath(points=((0, 0, 0), (1, 1, 1)), near=NEAR, speed=0.2)
    assert faults_of(GEOMETRY, path, made, EVERY, EVERY) == []


def drawn_frame(seed):
    rng = np.random.default_rng((83, seed))
    origin, vector = rng.uniform(-0.5, 0.5, 3), rng.normal(size=3)
    return origin, vector, of_vector(vector), rng


def three_points(origin, turn, rng):
    """Return points as a hand would be led to: along X, and aside on the side of Y."""
    on_x = origin + float(rng.uniform(0.02, 0.5)) * turn[:, 0]
    aside = float(rng.uniform(-0.3, 0.3)) * turn[:, 0] + float(rng.uniform(0.02, 0.5)) * turn[:, 1]
    return tuple(on_x), tuple(origin + aside)


@pytest.mark.parametrize("seed", range(20))
def test_three_points_say_the_frame_that_a_rotation_says(seed):
    origin, vector, turn, rng = drawn_frame(seed)
    on_x, in_xy = three_points(origin, turn, rng)
    np.testing.assert_allclose(TaughtFrame(tuple(origin), tuple(vector)).axes, turn, atol=1e-12)
    taught = TaughtFrame(tuple(origin), on_x=on_x, in_xy=in_xy)
    np.testing.assert_allclose(taught.axes, turn, atol=1e-12)


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2, 3))])
def test_a_path_is_the_same_one_in_any_frame(seed, tmp_path):
    places, directions, spins = drawn_poses(seed)
    origin, vector, turn, rng = drawn_frame(seed)
    made = plan(PosePath(file=written(tmp_path, places, directions, spins), near=NEAR))
    seen = written(tmp_path, (places - origin) @ turn, directions @ turn, spins)
    on_x, in_xy = three_points(origin, turn, rng)
    for frame in (
        TaughtFrame(tuple(origin), tuple(vector)),
        TaughtFrame(tuple(origin), on_x=on_x, in_xy=in_xy),
    ):
        path = PosePath(file=seen, frame="fixture", near=NEAR).seen_in({"fixture": frame})
        # The times to reach a place may differ by the last digits of the places.
        other = plan(path)
        assert other.duration == pytest.approx(made.duration, rel=1e-6)
        np.testing.assert_allclose(other.positions[0], made.positions[0], atol=1e-9)
        np.testing.assert_allclose(other.positions[-1], made.positions[-1], atol=1e-9)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"on_x": (0.1, 0.0, 0.0)}, "belong together"),
        ({"in_xy": (0.1, 0.0, 0.0)}, "belong together"),
        (
            {"rotation": (0.1, 0.0, 0.0), "on_x": (0.1, 0.0, 0.0), "in_xy": (0.0, 0.1, 0.0)},
            "and not both",
        ),
        ({"on_x": (5e-4, 0.0, 0.0), "in_xy": (0.0, 0.1, 0.0)}, "on_x is 0.5 mm from the origin"),
        ({"on_x": (0.1, 0.0, 0.0), "in_xy": (-0.3, 0.0, 9e-4)}, "in_xy is 0.9 mm from the line"),
    ],
)
def test_points_that_say_no_frame_are_refused(settings, said):
    with pytest.raises(ValueError, match=said):
        TaughtFrame(**settings)


def test_a_frame_that_the_rig_has_not_is_named_with_those_that_it_has():
    path = PosePath(points=((0, 0, 0), (0.1, 0, 0)), frame="tabel")
    with pytest.raises(InfeasibleMotion, match=r"'tabel'.*of the rig table; did you mean table\?"):
        path.seen_in({"table": TaughtFrame()})
    with pytest.raises(InfeasibleMotion, match="of the rig none"):
        plan(path)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0])
def test_a_spline_of_rotations_is_that_of_scipy(size):
    """Turns below and above where a series stands for sine and cosine, and at the knots."""
    rng = np.random.default_rng(11)
    turns = Rotation.from_rotvec(size * rng.normal(size=(7, 3)))
    u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.05, 0.3, 6))))
    before = Rotation.random(rng=rng)
    made = Splined(u, [tuple(q) for q in np.roll(turns.as_quat(), 1, axis=1)], before.as_matrix())
    theirs = RotationSpline(u, before * turns)
    for at in [*np.linspace(0.0, u[-1], 200).tolist(), *u.tolist()]:
        np.testing.assert_allclose(made.at(at), theirs(at).as_matrix(), atol=4e-15)
