"""The pose controllers on the joint's plant, in virtual time, with the figures as numbers.

The loop is as over the bus: readings are quantised and one period old when they are used (but for
the bus's latency), a setpoint acts a latency after it was computed.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

from controllers.cylinder.cascade import CascadeSettings
from controllers.cylinder.feedforward import FeedforwardSettings
from controllers.minimum_jerk import minimum_jerk
from controllers.spherical_joint.camera_loop import CameraLoopSettings
from controllers.spherical_joint.geometry import PAIRS, SphericalJointGeometry
from controllers.spherical_joint.laws import (
    JointCascade,
    JointCascadeSettings,
    JointPid,
    JointPidFriction,
    JointSuperTwisting,
)
from controllers.spherical_joint.learning import LearningSettings
from controllers.spherical_joint.pose_control import JointLearningSettings
from controllers.spherical_joint.types import (
    CameraSample,
    JointModel,
    JointReference,
    JointState,
    Lap,
)
from drivers.sim.plants.spherical_joint import SphericalJointPlant
from drivers.sim.plants.spherical_joint_settings import SphericalJointPlantSettings

RATE = 1000
LATENCY = 0.3e-3
ENCODER = 1e-6
MONITOR = 0.5e6 / 0x7FFF
APPROACH = 1.5
FRAMES, EXPOSED_BEFORE, CAMERA_NOISE = 60.0, 40e-3, 10e-6
GEOMETRY = SphericalJointGeometry()

MODEL = {
    "standard": JointModel(),
    "low-speed": JointModel(
        coulomb=4.8,
        breakaway=5.0,
        stribeck_velocity=3e-3,
        viscous=30.0,
        ring_friction=0.04,
        wire_friction=0.06,
    ),
}
LOW_SPEED = CascadeSettings(
    position_rate=100.0,
    velocity_rate=370.0,
    integral=1.1e5,
    hold_integral=1e6,
    observer_bandwidth=1070.0,
    force_trust=0.2,
    lead_bandwidth=500.0,
    disturbance_gain=0.05,
    disturbance_bandwidth=105.0,
    trim_rate=0.76,
    differential_limit=300e3,
    feedforward=FeedforwardSettings(gain=1.03, distance=3e-6, learning_rate=2.9, error_rate=2.7),
)


class Run(NamedTuple):
    """What a run left behind, one row per cycle from the first lap on: m, m, N, m, m."""

    rod_errors: np.ndarray
    marker_errors: np.ndarray
    tensions: np.ndarray
    estimate_errors: np.ndarray
    radial_errors: np.ndarray
    controller: object

    @property
    def wire(self):
        """Root mean square of the pairs' errors, m."""
        errors = [0.5 * (self.rod_errors[:, a] - self.rod_errors[:, b]) for a, b in PAIRS]
        return math.sqrt(np.mean(np.square(errors)))

    def marker(self, part=slice(None)):
        """Root mean square distance of the true marker from its reference, m."""
        return math.sqrt(np.mean(np.sum(np.square(self.marker_errors[part]), axis=1)))


def circle(t, frequency, tilt):
    """Return the axis at `t` s: a tilt from rest, then round and round with a soft start."""
    if t < APPROACH:
        lean, turn = minimum_jerk(0.0, tilt, APPROACH, t)[0], 0.0
    else:
        into = t - APPROACH
        lean, rate = tilt, 2.0 * math.pi * frequency
        turn = rate * into * into if into < 0.5 else rate * (into - 0.25)
    return (math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn), math.cos(lean))


def reference(t, frequency, tilt):
    h = 1e-4
    back, here, ahead = (circle(t + k * h, frequency, tilt) for k in (-1, 0, 1))
    return JointReference(
        here,
        tuple((c - a) / (2.0 * h) for a, c in zip(back, ahead, strict=True)),
        tuple((c - 2.0 * b + a) / h**2 for a, b, c in zip(back, here, ahead, strict=True)),
    )


def run(controller, seals, frequency, *, laps=1.0, tilt=20.0, seed=0, camera=False):
    plant = SphericalJointPlant(SphericalJointPlantSettings(seals=seals), seed, GEOMETRY)
    plant.set_supply(True)
    for channel in range(4):
        plant.set_pressure_setpoint(channel, 0.12e6)
    start, period, home = 1.0, 1.0 / RATE, plant.settings.home
    plant.advance(start)
    generator = np.random.default_rng(seed)

    def sample(t):
        rods = tuple(home - round(plant.position(c) / ENCODER) * ENCODER for c in range(4))
        return t, rods, tuple(round(plant.pressure(c) / MONITOR) * MONITOR for c in range(4))

    truths = [name for name, _ in plant.truth_columns]
    marker, tension = truths.index("marker_x"), truths.index("tension_ch1")
    reading, waiting, seen, rows = sample(start), [], None, []
    settled, ticks = int((APPROACH + 1.0) * RATE), round(RATE / frequency)
    lean = math.radians(tilt)
    for k in range(settled + round(laps * ticks)):
        t = start + k * period
        plant.advance(t)
        while waiting and waiting[0][0] <= t:
            seen = waiting.pop(0)[1]
        state = JointState(*reading, seen)
        if k == 0:
            controller.reset(state)
        goal = reference(k * period, frequency, lean)
        if k >= settled:
            goal = goal._replace(lap=Lap((k - settled) // ticks, (k - settled) % ticks, ticks))
        command = controller.update(state, goal)
        plant.advance(t + LATENCY)
        for channel, pressure in enumerate(command):
            plant.set_pressure_setpoint(channel, pressure)
        reading = sample(t + LATENCY)
        truth = plant.truth()
        true = np.array(truth[marker : marker + 3])
        if camera and k * FRAMES // RATE != (k - 1) * FRAMES // RATE:
            noisy = tuple((true + CAMERA_NOISE * generator.standard_normal(3)).tolist())
            waiting.append((t + LATENCY + EXPOSED_BEFORE, CameraSample(noisy, t + LATENCY)))
        if k >= settled:
            wanted = np.array(GEOMETRY.marker(circle(k * period + LATENCY, frequency, lean)))
            rows.append(
                (
                    np.subtract(reading[1], controller.estimate.rods),
                    true - wanted,
                    truth[tension : tension + 4],
                    np.subtract(controller.estimate.marker, true),
                    math.hypot(*true[:2]) - math.hypot(*wanted[:2]),
                )
            )
    return Run(*(np.array(column) for column in zip(*rows, strict=True)), controller)


def low_speed(**changes):
    settings = JointCascadeSettings(
        pair=LOW_SPEED, ball_friction=0.95, friction_distance=10e-6, **changes
    )
    return JointCascade(settings, MODEL["low-speed"], 1.0 / RATE)


@pytest.mark.parametrize(("frequency", "laps"), [(0.1, 0.6), (0.2, 1.0), (0.5, 2.0)])
def test_joint_circle_with_standard_seals(frequency, laps):
    controller = JointCascade(JointCascadeSettings(), MODEL["standard"], 1.0 / RATE)
    found = run(controller, "standard", frequency, laps=laps, seed=1)
    assert found.wire <= 0.11e-3
    assert found.marker() <= 0.35e-3
    assert found.tensions.min() >= 5.0
    assert found.tensions.max() <= 90.0


@pytest.mark.parametrize(("frequency", "laps"), [(0.1, 0.6), (0.5, 2.0)])
def test_joint_circle_with_low_speed_seals(frequency, laps):
    found = run(low_speed(), "low-speed", frequency, laps=laps)
    assert found.wire <= 0.05e-3
    assert found.marker() <= 0.15e-3
    assert found.tensions.min() >= 5.0


def test_learning_and_camera_take_a_third_off_the_error_of_a_circle():
    learning = JointLearningSettings(axis=LearningSettings(gain=0.5, bandwidth=5.0, advance=0.0))
    controller = low_speed(camera=CameraLoopSettings(gain=1.0), learning=learning)
    found = run(controller, "low-speed", 0.5, laps=6, camera=True, seed=1)
    lap = RATE * 2
    assert found.marker(slice(-lap, None)) <= 0.07e-3
    assert found.marker(slice(-lap, None)) <= 0.7 * found.marker(slice(lap))
    assert math.sqrt(np.mean(np.square(found.radial_errors[-lap:]))) <= 0.03e-3
    assert found.tensions.min() >= 5.0


def test_fused_estimate_is_nearer_to_the_marker_than_the_encoders():
    found = run(low_speed(), "low-speed", 0.1, laps=0.5, camera=True, seed=3)
    alone = run(low_speed(), "low-speed", 0.1, laps=0.5, seed=3)
    fused, encoders = (
        math.sqrt(np.mean(np.sum(np.square(each.estimate_errors), axis=1)))
        for each in (found, alone)
    )
    assert fused <= 0.05e-3
    assert fused < 0.8 * encoders


def test_wide_circle_at_60_degrees_keeps_every_wire_taut():
    found = run(low_speed(), "low-speed", 0.2, laps=0.6, tilt=60.0)
    assert found.wire <= 0.15e-3
    assert found.tensions.min() >= 5.0


@pytest.mark.parametrize(
    ("kind", "wire"),
    [(JointPid, 0.3e-3), (JointPidFriction, 0.2e-3), (JointSuperTwisting, 0.25e-3)],
)
def test_other_laws_follow_the_circle(kind, wire):
    found = run(kind(kind.Settings(), MODEL["standard"], 1.0 / RATE), "standard", 0.2, laps=0.4)
    assert found.wire <= wire
    assert found.tensions.min() >= 5.0
