"""What the scenes draw is where the mechanisms' own kinematics say that it is."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward, wrist_centre
from controllers.gait import kinematics as gait
from controllers.gait.geometry import AXIS_NAMES as LEG_AXES
from controllers.gait.geometry import LEGS, LegGeometry
from controllers.gait.types import BalanceSettings
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.wires import InverseKinematics
from rig.mechanisms.arm.boundary import meridian
from rig.mechanisms.arm.scene import ArmScene
from rig.mechanisms.joint.scene import JointScene
from rig.mechanisms.legs.scene import LegsScene

ROWS = 40


def place(scene, columns):
    """Return the points of the shapes by their names, the last of each."""
    placed = scene.place(lambda name: np.asarray(columns[name], float))
    return {shape.name: points for shape, points in zip(scene.shapes, placed, strict=True)}


@pytest.mark.parametrize("seed", range(3))
def test_the_hand_of_the_arm_is_where_it_is(seed):
    chance = np.random.default_rng(seed)
    geometry = ArmGeometry(
        base_height=chance.uniform(0.0, 0.3), elbow_offset=0.02, shoulder_offset=0.05
    )
    settings = SimpleNamespace(geometry=geometry, limits=SimpleNamespace(reading_age=0.03))
    q = {kind: chance.uniform(-2.0, 2.0, (ROWS, 6)) for kind in ("reading", "reference")}
    columns = {
        f"{kind}.position_{name}": q[kind][:, k] for kind in q for k, name in enumerate(AXIS_NAMES)
    }
    for name in ("plan.path", "reading.hand"):
        columns |= {f"{name}_{axis}": np.zeros(ROWS) for axis in "xyz"}
    shown = place(ArmScene(settings), columns)
    arm = dimensions_of(geometry)
    for row in range(ROWS):
        for kind, name in (("reading", "links"), ("reference", "wanted pose")):
            pose = forward(arm, tuple(q[kind][row]))
            assert shown[name][row, -1] == pytest.approx(pose.position, abs=1e-12)
        tool = shown["tool"][row, 1] - shown["tool"][row, 0]
        pose = forward(arm, tuple(q["reading"][row]))
        assert tool / np.linalg.norm(tool) == pytest.approx(pose.rotation[2], abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_wires_of_the_joint_are_as_long_as_they_are(seed):
    chance = np.random.default_rng(seed)
    geometry = SphericalJointGeometry()
    limits = SimpleNamespace(
        tilt=1.0, pressure=(0.0, 5e5), tension=(5.0, 90.0), residual=1e-3, reading_age=0.01
    )
    tilt, way = chance.uniform(0.0, 0.5, ROWS), chance.uniform(-math.pi, math.pi, ROWS)
    axis = np.stack([np.sin(tilt) * np.cos(way), np.sin(tilt) * np.sin(way), np.cos(tilt)], axis=1)
    marker = geometry.marker_height * axis
    columns = {
        f"{name}_{letter}": marker[:, k]
        for name in ("estimate.encoder_marker", "reference.marker")
        for k, letter in enumerate("xyz")
    }
    scene = JointScene(SimpleNamespace(geometry=geometry, limits=limits))
    placed = scene.place(lambda name: columns[name])
    names = [shape.name for shape in scene.shapes]
    ring = placed[names.index("ring")]
    assert np.linalg.norm(ring, axis=2) == pytest.approx(geometry.ball_radius)
    assert np.einsum("npj,nj->np", ring, axis) == pytest.approx(geometry.ring_height)
    exact = InverseKinematics(geometry, "exact", "natural")
    wires = [points for name, points in zip(names, placed, strict=True) if "wires" in name]
    for number, points in enumerate(wires):
        assert (np.linalg.norm(points, axis=2) >= geometry.ball_radius - 1e-9).all()
        drawn = np.linalg.norm(np.diff(points[:, :-1], axis=1), axis=2).sum(axis=1)
        home = drawn_home(scene, geometry, names, number)
        for row in range(ROWS):
            shortening = exact.shortening(axis[row])[number]
            assert home - drawn[row] == pytest.approx(shortening, abs=1e-4)  # chords of an arc


def drawn_home(scene, geometry, names, number):
    columns = {
        f"{name}_{letter}": np.array([geometry.marker_height * (letter == "z")])
        for name in ("estimate.encoder_marker", "reference.marker")
        for letter in "xyz"
    }
    placed = scene.place(lambda name: columns[name])
    points = [points for name, points in zip(names, placed, strict=True) if "wires" in name]
    return float(np.linalg.norm(np.diff(points[number][0, :-1], axis=0), axis=1).sum())


@pytest.mark.parametrize("seed", range(3))
def test_the_legs_stand_where_the_robot_stands(seed):
    """The bearing foot lies flat on its print, and the waist is where that leg has it."""
    chance = np.random.default_rng(seed)
    geometry = LegGeometry()
    settings = SimpleNamespace(
        geometry=geometry, balance=BalanceSettings(), limits=SimpleNamespace(reading_age=0.03)
    )
    angles = chance.uniform(-0.4, 0.4, (ROWS, 12))
    columns = {f"reading.position_{name}": angles[:, k] for k, name in enumerate(LEG_AXES)}
    bearing = chance.integers(0, 2, ROWS)
    prints = chance.uniform(-0.1, 0.1, (ROWS, 2, 3))
    prints[:, :, 2] = 0.03
    prints[np.arange(ROWS), bearing, 2] = 0.0
    for leg, name in enumerate(LEGS):
        for k, axis in enumerate("xyz"):
            columns[f"reference.{name}_foot_{axis}"] = prints[:, leg, k]
        for angle in ("roll", "pitch", "yaw"):
            columns[f"reference.{name}_foot_{angle}"] = np.zeros(ROWS)
        columns[f"plan.stands_{name}"] = (bearing == leg) * 1.0
    for name in ("plan.mass", "plan.zero_moment"):
        columns |= {f"{name}_{axis}": np.zeros(ROWS) for axis in "xy"}
    scene = LegsScene(settings)
    placed = scene.place(lambda name: columns[name])
    names = [shape.name for shape in scene.shapes]
    soles = [points for name, points in zip(names, placed, strict=True) if name == "soles"]
    waist, support = placed[names.index("waist")], placed[names.index("support polygon")]
    for row, leg in enumerate(bearing):
        q = tuple(angles[row, 6 * leg : 6 * leg + 6])
        expected, _ = gait.waist_from_foot(geometry, int(leg), q)
        assert waist[row, 0] == pytest.approx(prints[row, leg] + expected, abs=1e-12)
        corners = {tuple(np.round(corner, 9)) for corner in soles[leg][row]}
        assert {corner[2] for corner in corners} == {0.0}
        assert {tuple(np.round(corner, 9)) for corner in support[row]} == corners


@pytest.mark.parametrize("seed", range(3))
def test_the_stretched_arm_ends_on_the_outline_of_its_reach(seed):
    chance = np.random.default_rng(seed)
    geometry = ArmGeometry(
        a1=chance.uniform(0.0, 0.2), elbow_offset=-0.03, shoulder_offset=chance.uniform(-0.2, 0.2)
    )
    outline = meridian(geometry.reach, geometry.a1, geometry.shoulder_offset, 4000)
    for lean in chance.uniform(0.0, math.pi, 20):
        q = (chance.uniform(-3.0, 3.0), lean, -geometry.elbow_angle, 0.0, 0.0, 0.0)
        x, y, z = wrist_centre(dimensions_of(geometry), q)
        for side in (1.0, -1.0):
            apart = np.linalg.norm(outline - (side * math.hypot(x, y), z), axis=1)
            assert apart.min() < 1e-3
