"""The compiled steps of a pose controller do what the joint's kinematics, friction and tensions
do one by one, as Python."""

import math
from dataclasses import replace

import pytest
from ball_sliding import BallFriction

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.pose_kernel import StepSettings
from controllers.spherical_joint.pose_step import PoseStep
from controllers.spherical_joint.poses import axis_from_tilt, move_axis, natural_rotation
from controllers.spherical_joint.taut import SlackWire, pair_forces, raised
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.wires import InverseKinematics

GEOMETRY = SphericalJointGeometry()
MEASURED = replace(
    GEOMETRY, anchor_angles=tuple(a + 5e-3 * k for k, a in enumerate(GEOMETRY.anchor_angles))
)
PERIOD, DISTANCE, BASE = 1e-3, 13e-6, 0.12e6
SETTINGS = StepSettings(
    area=181e-6,
    compliance=1.0 / 80e3,
    least=9.0,
    lowest=0.0,
    most=85.0,
    middle=0.2e6,
    decay=0.9,
    ahead=0.05,
    ring=0.08,
    wire=0.1,
    slide=PERIOD / DISTANCE,
)
RODS = (0.004, -0.002, -0.0036, 0.0021)
PRESSURES = (0.14e6, 0.11e6, 0.10e6, 0.13e6)


def circle(t, tilt=0.35, rate=3.0):
    """Return axis, velocity and acceleration of a circle."""
    s, c, x, y = math.sin(tilt), math.cos(tilt), math.cos(rate * t), math.sin(rate * t)
    axis = axis_from_tilt(tilt, rate * t)
    assert axis == pytest.approx((s * x, s * y, c))
    return axis, (-s * rate * y, s * rate * x, 0.0), (-s * rate**2 * x, -s * rate**2 * y, 0.0)


def pair(values):
    return 0.5 * (values[0] - values[2]), 0.5 * (values[3] - values[1])


def compiled_steps():
    steps = PoseStep(SETTINGS, GEOMETRY, InverseKinematics(GEOMETRY))
    steps.compile()
    return steps


@pytest.mark.parametrize("geometry", [GEOMETRY, MEASURED], ids=["regular", "measured"])
@pytest.mark.parametrize("kind", [("exact", "natural"), ("paper", "paper")], ids=["exact", "paper"])
@pytest.mark.parametrize("compiled", [True, False], ids=["compiled", "Python"])
def test_a_step_is_made_of_kinematics_friction_and_tensions(kind, geometry, compiled):
    inverse = InverseKinematics(geometry, *kind)
    steps = PoseStep(SETTINGS, geometry, inverse)
    if compiled:
        steps.compile()
    friction = BallFriction(SETTINGS.ring, SETTINGS.wire, DISTANCE, PERIOD)
    forward, tensions = ForwardKinematics(geometry), TensionDistribution(geometry)
    start = None
    for k in range(40):
        motion = circle(k * PERIOD)
        step = steps.before(*motion, RODS, PRESSURES, BASE, k % 4 == 0, start is None)
        if k % 4 == 0:
            pose = tensions.at(natural_rotation(motion[0]))
            later = tensions.shares(natural_rotation(move_axis(*motion, SETTINGS.ahead)))
        hold, held_later = (
            raised(tuple(4 * SETTINGS.area * BASE * s for s in shares), shares, SETTINGS.least)
            for shares in (pose.shares, later)
        )
        assert step.hold == pytest.approx(hold, rel=1e-12)
        position, rate, rise = inverse.motion(*motion)
        rates = pair(rate)
        rubbed = friction.update(rates, (hold[0] + hold[2], hold[3] + hold[1]))
        assert step.friction == pytest.approx(rubbed, rel=1e-9)
        pull = [SETTINGS.area * pressure for pressure in PRESSURES]
        share = sum(pull) / sum(hold)
        borne = [share * tension for tension in hold]
        for wire, force in ((0, rubbed[0]), (1, -rubbed[1]), (2, -rubbed[0]), (3, rubbed[1])):
            borne[wire] += 0.5 * force
        stretch = [SETTINGS.compliance * tension for tension in borne]
        wanted = [p + s for p, s in zip(position, stretch, strict=True)]
        assert step.rods == pytest.approx(wanted, abs=1e-12)
        for goal, *parts in zip(step.goals, pair(wanted), rates, pair(rise), strict=True):
            assert goal == pytest.approx(parts, rel=1e-6, abs=1e-9)
        found = forward.update(tuple(r - s for r, s in zip(RODS, stretch, strict=True)))
        assert step.axis == pytest.approx(found.axis, abs=1e-9)
        assert step.residuals == pytest.approx(found.residuals, abs=1e-9)
        forces = pair_forces(pose.first, pose.second, pull)
        for (place, agonist, antagonist), rod, force in zip(
            step.measured, pair(RODS), forces, strict=True
        ):
            assert place == rod
            assert SETTINGS.area * (agonist - antagonist) == pytest.approx(force, rel=1e-9)
            assert 0.5 * (agonist + antagonist) == pytest.approx(SETTINGS.middle)
        if start is None:  # what the chambers hold and nothing asks for
            start = [p - h for p, h in zip(pull, hold, strict=True)]
            for wire, force in ((0, forces[0]), (1, -forces[1]), (2, -forces[0]), (3, forces[1])):
                start[wire] -= 0.5 * force
        after = steps.after(3.0, -2.0, 1.5)
        asked = [h + s for h, s in zip(held_later, start, strict=True)]
        for wire, force in ((0, 3.0), (1, 2.0), (2, -3.0), (3, -2.0)):
            asked[wire] += 0.5 * force
        taut = pose.kept_taut(tuple(asked), SETTINGS.least)
        assert after == pytest.approx(
            [(t + 1.5 * s) / SETTINGS.area for t, s in zip(taut, pose.shares, strict=True)]
        )
        start = [SETTINGS.decay * value for value in start]


def test_setpoints_stay_within_what_may_be_asked_for():
    steps = compiled_steps()
    steps.before(*circle(0.0), RODS, PRESSURES, BASE, True, True)
    setpoints = steps.after(1e3, 0.0, 0.0)
    assert max(setpoints) == SETTINGS.most / SETTINGS.area
    assert min(setpoints) >= SETTINGS.lowest / SETTINGS.area


def test_rods_that_no_pose_explains_are_refused_and_the_search_starts_again():
    steps = compiled_steps()
    first = steps.before(*circle(0.0), RODS, PRESSURES, BASE, True, True)
    with pytest.raises(ValueError, match="no pose of the ring explains the shortenings"):
        steps.before(*circle(0.0), (0.2, 0.2, -0.2, -0.2), PRESSURES, BASE, False, False)
    again = steps.before(*circle(0.0), RODS, PRESSURES, BASE, True, True)
    assert again.axis == pytest.approx(first.axis, abs=1e-3)


def test_a_pose_without_force_closure_is_refused_by_its_wire():
    steps = compiled_steps()
    axis = axis_from_tilt(1.45, 0.8)
    with pytest.raises(SlackWire, match="would have to push"):
        steps.before(axis, (0.0,) * 3, (0.0,) * 3, RODS, PRESSURES, BASE, True, True)


def test_a_pose_that_leads_to_one_without_force_closure_is_refused_too():
    steps = compiled_steps()
    axis = axis_from_tilt(1.2, 0.8)
    fast = (0.0, 0.0, -5.0)
    with pytest.raises(SlackWire, match="would have to push"):
        steps.before(axis, fast, (0.0,) * 3, RODS, PRESSURES, BASE, True, True)


def test_an_anchor_opposite_its_adjust_point_is_refused_by_its_wire():
    steps = compiled_steps()
    tilt = GEOMETRY.ring_half_angle + math.atan2(GEOMETRY.adjust_radius, GEOMETRY.adjust_depth)
    axis = axis_from_tilt(tilt, GEOMETRY.anchor_angles[2])
    with pytest.raises(ValueError, match="in line with ball and adjust point"):
        steps.before(axis, (0.0,) * 3, (0.0,) * 3, RODS, PRESSURES, BASE, True, True)
