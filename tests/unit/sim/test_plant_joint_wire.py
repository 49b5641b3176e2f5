"""The plant's wire against a string, against finite differences and against MuJoCo."""

import math

import numpy as np
import pytest
from joint_bench import Geometry, exact_lengths, joint, points, rotation, wire_lengths

from drivers.sim.plants.spherical_joint_wire import wire_path

RADIUS = 0.025


def poses(count, most, seed=0, twist=0.0):
    """Return random tilts of up to `most` rad, with some twist."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        azimuth, tilt, spin = rng.uniform((0, 0, -twist), (2 * math.pi, most, twist))
        axis = (-math.sin(azimuth), math.cos(azimuth), 0.0)
        yield rotation(axis, tilt) @ rotation((0, 0, 1), spin)


def lengths(matrix, geometry=None):
    anchors, adjusts = points(geometry)
    ends = anchors @ matrix.T
    return np.array([wire_path(*a, *b, RADIUS)[0] for a, b in zip(ends, adjusts, strict=True)])


def string(end, adjust, count=257, sweeps=600):
    """Shorten a string of points on the ball's outside; it knows nothing of great circles.

    From few points to many, each drawn to the middle of its neighbours and out of the ball.
    """
    share = np.linspace(0.0, 1.0, 5)[:, None]
    line = (1 - share) * end + share * adjust
    while True:
        for _ in range(sweeps):
            for first in (1, 2):
                inner = 0.5 * (line[first - 1 : -2 : 2] + line[first + 1 :: 2])
                distance = np.linalg.norm(inner, axis=1, keepdims=True)
                line[first:-1:2] = inner * np.maximum(RADIUS / distance, 1.0)
        if len(line) >= count:
            return np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        finer = np.empty((2 * len(line) - 1, 3))
        finer[::2], finer[1::2] = line, 0.5 * (line[:-1] + line[1:])
        line = finer


@pytest.mark.parametrize("tilt", [0.0, 0.35, 0.8, 1.2])
def test_as_long_as_a_string_pulled_tight(tilt):
    anchors, adjusts = points()
    matrix = rotation((1.0, 0.4, 0.0), tilt)
    ends = anchors @ matrix.T
    for wire in (0, 1, 2):
        length = wire_path(*ends[wire], *adjusts[wire], RADIUS)[0]
        assert string(ends[wire], adjusts[wire]) == pytest.approx(length, rel=3e-6)


def test_as_long_as_the_closed_form_says():
    for matrix in poses(50, 0.6, twist=0.2):
        np.testing.assert_allclose(lengths(matrix), wire_lengths(matrix), rtol=0, atol=1e-14)


def test_home_wire_of_the_default_joint():
    alpha = math.asin(0.8)
    assert lengths(np.eye(3)) == pytest.approx(RADIUS * (1 + math.pi / 2 - alpha))


def test_free_wires_are_straight_and_the_change_is_smooth():
    """On the tilt side the wire leaves the ball at 36.9 degrees."""
    leaves = math.acos(0.8)
    before, at, after = (lengths(rotation((-1, 0, 0), leaves + d))[0] for d in (-1e-6, 0, 1e-6))
    assert after - at == pytest.approx(at - before, rel=1e-3)
    matrix = rotation((-1, 0, 0), 1.0)
    anchors, adjusts = points()
    end = matrix @ anchors[0]
    length, wrap, *_ = wire_path(*end, *adjusts[0], RADIUS)
    assert wrap == 0.0
    assert length == pytest.approx(np.linalg.norm(end - adjusts[0]), rel=1e-14)


def test_anchors_off_the_ball_have_two_tangents():
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(200):
        end, adjust = (
            v / np.linalg.norm(v) * s
            for v, s in zip(
                rng.standard_normal((2, 3)), rng.uniform(1.001, 2.5, 2) * RADIUS, strict=True
            )
        )
        length, wrap, *_ = wire_path(*end, *adjust, RADIUS)
        assert length == pytest.approx(exact_lengths(end[None], adjust[None], RADIUS)[0], rel=1e-9)
        seen.add(wrap > 0.0)
    assert seen == {True, False}


def test_arm_is_the_slope_of_the_length():
    anchors, adjusts = points()
    for matrix in poses(30, 1.4, seed=1, twist=0.5):
        ends = anchors @ matrix.T
        for a, b in zip(ends, adjusts, strict=True):
            arm = wire_path(*a, *b, RADIUS)[2:]
            for k in range(3):
                axis = np.eye(3)[k]
                ahead, behind = (
                    wire_path(*(rotation(axis, turn) @ a), *b, RADIUS)[0] for turn in (1e-6, -1e-6)
                )
                assert arm[k] == pytest.approx(-(ahead - behind) / 2e-6, abs=2e-8)


def test_a_wire_across_the_ball_has_no_arm():
    _, wrap, *arm = wire_path(0.0, 0.0, RADIUS, 0.0, 0.0, -2 * RADIUS, RADIUS)
    assert wrap == pytest.approx(math.pi - math.acos(0.5))
    assert arm == [0.0, 0.0, 0.0]


def test_lengths_of_sphere_wrapped_tendons_in_mujoco():
    mujoco = pytest.importorskip("mujoco")
    anchors, adjusts = points()
    sites = "".join(f'<site name="b{k}" pos="{x} {y} {z}"/>' for k, (x, y, z) in enumerate(adjusts))
    ends = "".join(f'<site name="a{k}" pos="{x} {y} {z}"/>' for k, (x, y, z) in enumerate(anchors))
    tendons = "".join(
        f'<spatial><site site="b{k}"/><geom geom="ball"/><site site="a{k}"/></spatial>'
        for k in range(4)
    )
    # The ball is a little smaller, since MuJoCo wraps nothing round a sphere that a site is in.
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><compiler angle="radian"/><worldbody>
        <geom name="ball" type="sphere" size="{RADIUS * (1 - 1e-9)}"/>{sites}
        <body><joint type="ball"/>{ends}<geom type="sphere" size="0.001" mass="0.1"/></body>
        </worldbody><tendon>{tendons}</tendon></mujoco>"""
    )
    data = mujoco.MjData(model)
    for matrix in poses(100, 1.3, seed=2, twist=0.4):
        mujoco.mju_mat2Quat(data.qpos, matrix.flatten())
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(lengths(matrix), data.ten_length, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ring_radius": 0.025}, "a ring of 0.025 m does not sit"),
        ({"anchor_angles": (0.0, 1.0, 2.0)}, "3 anchor angles; 4 are needed"),
        ({"adjust_radius": 0.01, "adjust_depth": 0.02}, "not outside a ball"),
    ],
)
def test_a_joint_that_cannot_be_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        joint(geometry=Geometry(**changes))


def test_tolerances_keep_anchors_on_the_ball_and_wires_taut_at_home():
    plant = joint(5, tolerance=1e-4)
    w = plant.wire_parameters
    anchors = np.stack([w["anchor_x"], w["anchor_y"], w["anchor_z"]], 1)
    adjusts = np.stack([w["adjust_x"], w["adjust_y"], w["adjust_z"]], 1)
    np.testing.assert_allclose(np.linalg.norm(anchors, axis=1), RADIUS, rtol=1e-12)
    nominal, ideal = points()
    assert 2e-5 < np.abs(anchors - nominal).max() < 1.5e-4
    assert 2e-5 < np.abs(adjusts - ideal).max() <= 1e-4
    np.testing.assert_allclose(exact_lengths(anchors, adjusts, RADIUS), w["free"] + 0.030)
