"""Each term of the friction laws on its own: the controllers' and the plant's."""

import math

import pytest

from controllers.friction import PreslidingFriction, SmoothFriction
from controllers.spherical_joint.ball_friction import slide
from drivers.sim.plants.friction import bristle_damping, step_bristle, stribeck_force

COULOMB, BREAKAWAY, STRIBECK, VISCOUS, ROUNDING = 6.0, 9.0, 8e-3, 50.0, 1e-3


@pytest.mark.parametrize("velocity", [-0.1, -8e-3, -1e-3, 0.0, 5e-4, 4e-3, 0.02, 0.3])
def test_smooth_friction_is_its_formula(velocity):
    friction = SmoothFriction(COULOMB, BREAKAWAY, STRIBECK, VISCOUS, ROUNDING)
    level = COULOMB + (BREAKAWAY - COULOMB) * math.exp(-((velocity / STRIBECK) ** 2))
    force = level * math.tanh(velocity / ROUNDING) + VISCOUS * velocity
    assert friction.force(velocity) == pytest.approx(force, rel=1e-12)


def test_presliding_friction_is_its_formula():
    period, distance = 1e-3, 40e-6
    friction = PreslidingFriction(COULOMB, distance, VISCOUS, period)
    share = 0.0
    for velocity in (0.01, 0.03, -0.002, 0.0, -0.5):
        moved = velocity * period / distance
        share = (share + moved) / (1.0 + abs(moved))
        force = COULOMB * share + VISCOUS * velocity
        assert friction.update(velocity) == pytest.approx(force, rel=1e-12)
    friction.reset()
    moved = 0.01 * period / distance
    assert friction.update(0.01) == pytest.approx(COULOMB * moved / (1.0 + moved) + VISCOUS * 0.01)


def test_a_ring_that_slides_on_shares_its_friction_by_its_direction():
    """Ring: 0.1 of 200 N; wires: 0.2 of 50 and of 150 N."""
    step, tension = 1e-3 / 40e-6, (50.0, 150.0)
    seat = wires = (0.0, 0.0)
    for _ in range(200):
        force, seat, wires = slide(0.1, 0.2, step, seat, wires, (0.03, -0.04), tension)
    assert force == pytest.approx((20.0 * 0.6 + 10.0, -20.0 * 0.8 - 30.0), rel=1e-3)
    first, _, _ = slide(0.1, 0.2, step, (0.0, 0.0), (0.0, 0.0), (1.0 / step, 0.0), tension)
    assert first == pytest.approx((20.0 * 0.5 + 10.0 * 0.5, 0.0))


@pytest.mark.parametrize("speed", [-0.02, -4e-3, 0.0, 4e-3, 0.02])
def test_the_plants_terms_are_their_formulas(speed):
    fade = math.exp(-((speed / STRIBECK) ** 2))
    assert stribeck_force(speed, COULOMB, BREAKAWAY, STRIBECK) == pytest.approx(
        COULOMB + (BREAKAWAY - COULOMB) * fade
    )
    assert bristle_damping(speed, 40.0, STRIBECK) == pytest.approx(40.0 * fade)
    stiffness, dt, z = 1.5e5, 50e-6, 3e-6
    after = step_bristle(z, speed, stiffness, COULOMB, dt)
    # dz/dt = v - sigma_0 |v| z / g, at the end of the step.
    assert (after - z) / dt == pytest.approx(
        speed - stiffness * abs(speed) * after / COULOMB, abs=1e-12
    )
