import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.friction import PreslidingFriction, SmoothFriction

speeds = st.floats(-0.5, 0.5)


@given(speeds)
def test_smooth_friction_is_odd(velocity):
    friction = SmoothFriction(6.0, 9.0, 8e-3, 50.0, 1e-3)
    assert friction.force(-velocity) == -friction.force(velocity)
    assert friction.force(velocity) * velocity >= 0.0


def test_smooth_friction_rises_to_breakaway_and_falls_to_coulomb():
    friction = SmoothFriction(6.0, 9.0, 8e-3, 0.0, 1e-4)
    assert friction.force(0.0) == 0.0
    assert friction.force(1e-3) == pytest.approx(6.0 + 3.0 * math.exp(-1 / 64), rel=1e-6)
    assert friction.force(50e-3) == pytest.approx(6.0, rel=1e-9)


def test_viscous_friction_is_what_remains_beyond_coulomb():
    friction = SmoothFriction(6.0, 6.0, 8e-3, 50.0, 1e-3)
    assert friction.force(0.1) - friction.force(0.05) == pytest.approx(2.5)


@given(st.lists(speeds, max_size=50))
def test_presliding_friction_is_odd_and_bounded(velocities):
    one = PreslidingFriction(6.0, 40e-6, 0.0, 1e-3)
    other = PreslidingFriction(6.0, 40e-6, 0.0, 1e-3)
    for velocity in velocities:
        force = one.update(velocity)
        assert other.update(-velocity) == -force
        assert abs(force) <= 6.0


def slide(friction, distance, velocity, period=1e-3):
    force = 0.0
    for _ in range(round(abs(distance / velocity) / period)):
        force = friction.update(math.copysign(velocity, distance))
    return force


def test_presliding_friction_turns_over_its_distance_and_not_over_time():
    forces = []
    for velocity in (1e-4, 2e-4):
        friction = PreslidingFriction(6.0, 40e-6, 0.0, 1e-3)
        assert slide(friction, 1e-3, velocity) == pytest.approx(6.0, rel=1e-6)
        forces.append(slide(friction, -40e-6, velocity))
    # Dahl: F = Fc (2 exp(-x / distance) - 1) after a reversal.
    assert forces == pytest.approx([6.0 * (2 * math.exp(-1) - 1)] * 2, rel=0.02)


def test_presliding_friction_keeps_its_force_at_a_stop():
    friction = PreslidingFriction(6.0, 40e-6, 30.0, 1e-3)
    slide(friction, 1e-3, 1e-3)
    held = [friction.update(0.0) for _ in range(100)]
    assert held == pytest.approx([6.0] * 100, rel=1e-6)
    friction.reset()
    assert friction.update(0.0) == 0.0
