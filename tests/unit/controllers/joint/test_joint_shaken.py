"""What a pose controller makes of dither and pretension."""

import numpy as np
import pytest
from pose_bench import MODEL, build, circle, every, pressures_at, resting, rods_at

from controllers.spherical_joint.dither import DitherSettings, PathDitherSettings
from controllers.spherical_joint.poses import axis_from_tilt, natural_rotation
from controllers.spherical_joint.taut import pair_forces
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.types import JointState
from controllers.spherical_joint.wires import InverseKinematics


@every
def test_dither_shakes_the_tensions_and_turns_nothing(kind):
    axis = axis_from_tilt(0.5, 0.3)
    pressures = pressures_at(axis)
    state = JointState(0.0, rods_at(axis, pressures), pressures)
    plain = build(kind)
    shaken = build(kind, dither=DitherSettings(amplitude=30e3, frequency=20.0))
    for controller in (plain, shaken):
        controller.reset(state)
    added = np.array(
        [
            np.subtract(shaken.update(state, resting(axis)), plain.update(state, resting(axis)))
            for _ in range(500)
        ]
    )
    pose = TensionDistribution(MODEL.geometry).at(natural_rotation(axis))
    forces = [pair_forces(pose.first, pose.second, tuple(MODEL.area * row)) for row in added]
    assert np.ptp(added.sum(axis=1)) > 200e3
    assert np.abs(forces).max() < 0.02


@every
def test_path_dither_pulls_along_the_wanted_path_and_no_harder_together(kind):
    """Beside a controller without it, the forces of the pairs differ along the path alone."""
    plain = build(kind)
    shaken = build(kind, path_dither=PathDitherSettings(force=1.0, frequency=20.0))
    start = circle(0.0)
    pressures = pressures_at(start.axis)
    for controller in (plain, shaken):
        controller.reset(JointState(0.0, rods_at(start.axis, pressures), pressures))
    inverse = InverseKinematics(MODEL.geometry)
    along, across = [], []
    for k in range(400):
        goal = circle(1e-3 * k)
        state = JointState(1e-3 * k, rods_at(goal.axis, pressures), pressures)
        added = np.subtract(shaken.update(state, goal), plain.update(state, goal)) * MODEL.area
        pose = TensionDistribution(MODEL.geometry).at(natural_rotation(goal.axis))
        first, second = pair_forces(pose.first, pose.second, tuple(added))
        _, rates, _ = inverse.motion(goal.axis, goal.velocity, goal.acceleration)
        way = np.array([rates[0] - rates[2], rates[3] - rates[1]])
        way /= np.hypot(*way)
        along.append(first * way[0] + second * way[1])
        across.append(second * way[0] - first * way[1])
    assert np.ptp(along) > 1.0
    assert np.abs(across).max() < 0.05 * np.ptp(along)


@every
def test_no_wire_is_let_below_the_pretension(kind):
    axis = axis_from_tilt(0.3, 0.3)
    pressures = pressures_at(axis)
    state = JointState(0.0, rods_at(axis, pressures), pressures)
    far = resting(axis_from_tilt(0.35, 0.3))
    lowest = {}
    for pretension in (0.0, 25.0):
        controller = build(kind, pretension=pretension)
        controller.reset(state)
        commands = [controller.update(state, far) for _ in range(300)][-100:]
        lowest[pretension] = MODEL.area * min(min(command) for command in commands)
    assert lowest[0.0] < 20.0
    assert lowest[25.0] == pytest.approx(25.0, abs=0.1)
