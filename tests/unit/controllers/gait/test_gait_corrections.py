"""Corrections of a posture: torques at rest against MuJoCo, bounds, and what is believed."""

import math

import numpy as np
import pytest

from controllers.gait.correction_settings import SagSettings, StabiliserSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.kinematics import waist_from_foot
from controllers.gait.laws import TrapezoidNormLaw
from controllers.gait.motions import WalkSettings
from controllers.gait.sag import standing_torques
from controllers.gait.sensing import FootLoad, Sensing, weighed_point
from controllers.gait.suspicion import Suspicion
from controllers.gait.types import GaitModel, LegsReference, LegsState

PERIOD = 0.005
GEOMETRY = LegGeometry()
WEIGHT = 9.80665 * GEOMETRY.masses.total
WALK = WalkSettings(landings=1, speed=5.0)
FOLLOW = LegsReference((0.0,) * 12, (0.0,) * 12, True)
STILL = (0.0, 0.0)


def law(**corrections):
    return TrapezoidNormLaw(TrapezoidNormLaw.Settings(), GaitModel(GEOMETRY, **corrections), PERIOD)


def felt(plan, sample, ahead=0.0, aside=0.0, share=1.0, lean=STILL, turning=STILL):
    """Return what the feet feel if they are pressed that far from where the plan has it."""
    x, y = plan.balance.zero_moment[sample]
    (rx, ry), (lx, ly) = plan.feet[sample, :, :2]
    half = 0.5 * share * WEIGHT
    loads = [
        FootLoad(half, (half * (x + ahead - fx), half * (y + aside - fy)))
        for fx, fy in ((rx, ry), (lx, ly))
    ]
    return Sensing((loads[0], loads[1]), lean, turning)


def followed(made, plan, feel, cycles):
    """Return the commanded joints of a walk in which the legs feel what `feel(sample)` says."""
    made.reset(None)
    rows = []
    for sample in range(cycles):
        state = LegsState(sample * PERIOD, (0.0,) * 12, (0.0,) * 12, feel(sample))
        rows.append(made.update(state, FOLLOW).positions)
    return np.array(rows)


def test_without_corrections_a_law_is_the_plan_to_the_bit():
    made = law()
    plan = made.prepare(WALK)
    told = followed(made, plan, lambda sample: None, 300)
    assert np.array_equal(told, plan.q[:300])


@pytest.mark.parametrize("t", [1.0, 1.5, 2.0])
def test_torques_on_one_foot_are_those_of_rigid_bodies(t):
    """MuJoCo, without friction and with servos that hardly give way, holds the same posture."""
    from dataclasses import replace

    from drivers.sim.plants.legs import LegsPlant
    from drivers.sim.plants.legs_settings import LegServoSettings, LegsPlantSettings

    plan = law().prepare(WALK)
    sample = round(t / PERIOD)
    posture = plan.q[sample]
    settings = LegsPlantSettings(
        servo=replace(LegServoSettings(), stiffness=2000.0, damping=20.0, friction=0.0),
        stand=tuple(posture.tolist()),
        initial_hip_height=float(plan.waist[0, 2]) - GEOMETRY.ankle_height,
        mass_spread=0.0,
        friction_spread=0.0,
    )
    plant = LegsPlant(settings, 0, GEOMETRY)
    for channel, angle in enumerate(posture.tolist()):
        plant.command_joint(channel, angle, 0.0, True)
    plant.advance(1.5)
    assert not plant.truth()[14]
    held = [plant.joint_torque(channel) for channel in range(12)]
    # In the plan the point of pressure still moves by the waist's acceleration.
    assert standing_torques(plan)[sample] == pytest.approx(held, abs=0.08)


def test_sag_is_brought_in_and_is_torque_over_stiffness():
    made = law(sag=SagSettings(stiffness=100.0, fade=0.2))
    plan = made.prepare(WALK)
    told = followed(made, plan, lambda sample: None, 300)
    added = told - plan.q[:300]
    assert np.abs(added[0]).max() < 0.05 * np.abs(added[60]).max()
    assert added[200] == pytest.approx(standing_torques(plan)[200] / 100.0, abs=1e-12)


def waist_of(joints):
    return np.array(waist_from_foot(GEOMETRY, 1, tuple(joints[6:]))[0])


@pytest.mark.parametrize(("ahead", "aside"), [(0.01, 0.0), (-0.01, 0.0), (0.0, 0.01), (0.0, -0.01)])
def test_the_waist_goes_against_the_error_of_the_pressure(ahead, aside):
    made = law(stabiliser=StabiliserSettings())
    plan = made.prepare(WALK)
    told = followed(made, plan, lambda k: felt(plan, k, ahead, aside), 260)
    moved = waist_of(told[-1]) - waist_of(plan.q[259])
    assert moved[0] * ahead <= 0.0 and moved[1] * aside <= 0.0
    # In 1.3 s half of an error a second, less what fades in.
    assert math.hypot(*moved[:2]) == pytest.approx(0.0058, abs=0.0012)
    assert -0.005 < moved[2] < 1e-9  # lower, if at all


def test_a_lasting_error_is_bounded_and_does_not_wind_up():
    settings = StabiliserSettings(recovery=5.0, shift=0.02)
    made = law(stabiliser=settings)
    plan = made.prepare(WALK)
    bound = min(0.02, plan.static_margin - 0.005)
    told = followed(made, plan, lambda k: felt(plan, k, 0.05 if k < 400 else -0.05), 440)
    # On the standing leg, in mid-swing.
    moved = waist_of(told[380])[0] - waist_of(plan.q[380])[0]
    assert moved == pytest.approx(-bound, abs=1e-6)
    back = waist_of(told[439])[0] - waist_of(plan.q[439])[0]
    assert back > -bound + 0.005  # it turns back at once
    rates = np.abs(np.diff(told, axis=0)) / PERIOD
    assert rates.max() <= GEOMETRY.max_rate
    low, high = np.array(GEOMETRY.limits).T
    assert np.all((told >= low - 1e-9) & (told <= high + 1e-9))


def test_nothing_is_learnt_while_the_waist_turns():
    made = law(stabiliser=StabiliserSettings())
    plan = made.prepare(WALK)
    told = followed(made, plan, lambda k: felt(plan, k, 0.01, turning=(0.0, 0.9 * (-1) ** k)), 260)
    assert np.array_equal(told, plan.q[:260])


@pytest.mark.parametrize(
    ("lie", "words"),
    [
        ({"share": 2.0}, "the feet bear"),
        ({"share": 0.3}, "the feet bear"),
        ({"lean": (0.4, 0.0)}, "the waist leans by"),
        ({"turning": (0.0, -0.4)}, "the waist turns at"),
    ],
)
def test_what_cannot_be_true_ends_the_corrections_for_good(lie, words):
    made = law(stabiliser=StabiliserSettings(fade=0.2))
    plan = made.prepare(WALK)

    def feel(k):
        return felt(plan, k, 0.01, **lie if 100 <= k < 300 else {})

    told = followed(made, plan, feel, 480)
    assert words in made.corrections.doubt
    assert not np.array_equal(told[99], plan.q[99])
    assert np.array_equal(told[400:], plan.q[400:480])
    made.reset(None)
    assert made.corrections.doubt == ""


def test_sensors_that_stop_let_the_corrections_fade():
    made = law(stabiliser=StabiliserSettings(fade=0.2))
    plan = made.prepare(WALK)
    told = followed(made, plan, lambda k: felt(plan, k, 0.01) if k < 200 else None, 300)
    assert np.array_equal(told[245:], plan.q[245:300])
    assert np.abs(np.diff(told - plan.q[:300], axis=0)).max() < GEOMETRY.max_rate * PERIOD


def test_feet_in_the_air_press_nowhere():
    plan = law().prepare(WALK)
    nothing = felt(plan, 0, share=0.1)
    assert weighed_point(nothing, plan.feet[0].tolist(), 0.5 * WEIGHT) is None
    point = weighed_point(felt(plan, 300, 0.01, -0.02), plan.feet[300].tolist(), 1.0)
    assert np.array(point) - plan.balance.zero_moment[300] == pytest.approx((0.01, -0.02))


def test_a_moment_of_impact_is_no_suspicion():
    suspicion = Suspicion(WEIGHT, PERIOD)
    plan = law().prepare(WALK)
    for k in range(400):
        suspicion.see(felt(plan, 0, share=5.0 if k == 200 else 1.0))
    assert suspicion.why == ""
