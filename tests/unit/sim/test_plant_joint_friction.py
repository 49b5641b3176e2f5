"""Friction on the ball, on its own: a wire round it and a ring on it."""

import math

import numpy as np
import pytest

from drivers.sim.plants.spherical_joint_friction import capstan_tension, step_seat

STIFFNESS, DAMPING, DT = 1.5e5, 40.0, 50e-6


def slide_wire(bristle, speed, duration, tension=20.0, angle=0.08):
    """Return the tension at the ring, the deflection and the work that friction took, J."""
    work = 0.0
    for _ in range(round(duration / DT)):
        behind, bristle = capstan_tension(tension, bristle, speed, angle, STIFFNESS, DAMPING, DT)
        work += (tension - behind) * speed * DT
    return behind, bristle, work


def test_a_sliding_wire_loses_what_the_capstan_equation_says():
    assert slide_wire(0.0, 5e-3, 0.1)[0] == pytest.approx(20.0 * math.exp(-0.08), rel=1e-3)
    assert slide_wire(0.0, -5e-3, 0.1)[0] == pytest.approx(20.0 * math.exp(0.08), rel=1e-3)


def test_a_wire_on_nothing_loses_nothing():
    assert slide_wire(0.0, 5e-3, 0.1, angle=0.0)[0] == pytest.approx(20.0, abs=1e-5)


def test_a_wire_sticks_before_it_slides():
    behind, bristle, _ = slide_wire(0.0, 1e-4, 10e-3)  # 1 µm
    assert bristle == pytest.approx(1e-6, rel=0.1)
    assert 20.0 - behind == pytest.approx(STIFFNESS * bristle, rel=0.1)


def test_a_wire_turned_round_keeps_its_tension_until_it_has_slipped_back():
    _, bristle, _ = slide_wire(0.0, 5e-3, 0.1)
    assert slide_wire(bristle, 0.0, 1e-3)[0] == pytest.approx(20.0 * math.exp(-0.08), rel=1e-3)
    assert slide_wire(bristle, -1e-3, 30e-3)[0] > 20.0


def test_a_wire_to_and_fro_only_takes_energy():
    bristle, total = 0.0, 0.0
    for speed, tension in ((5e-3, 20.0), (-5e-3, 40.0), (2e-3, 5.0), (-8e-3, 10.0)) * 3:
        _, bristle, work = slide_wire(bristle, speed, 20e-3, tension)
        total += work
        assert total > -0.5 * STIFFNESS * bristle**2
    assert total > 1e-3


def test_a_wire_that_slackens_keeps_no_more_friction_than_its_tension_holds():
    for speed, grip in ((5e-3, -0.08), (-5e-3, 0.08)):
        _, bristle, _ = slide_wire(0.0, speed, 0.1, tension=40.0)
        behind, bristle, _ = slide_wire(bristle, 0.0, DT, tension=5.0)
        assert behind == pytest.approx(5.0 * math.exp(grip), rel=1e-6)
        kept = slide_wire(bristle, 0.0, DT, tension=40.0)[0]
        assert 40.0 - kept == pytest.approx(5.0 - behind, rel=1e-6)  # it slipped for good


def test_a_slack_wire_has_no_friction():
    for speed in (5e-3, -5e-3):
        assert capstan_tension(0.0, 1e-5, speed, 0.08, STIFFNESS, DAMPING, DT) == (0.0, 0.0)


def slide_ring(rates, limit=0.1, stiffness=94.0):
    seat = np.zeros(3)
    torques = []
    for rate, bound in zip(rates, np.broadcast_to(limit, len(rates)), strict=True):
        seat = np.array(step_seat(*seat, *rate, stiffness, bound, DT)[:3])
        torques.append(stiffness * seat)
    return np.array(torques)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 0, -1), (1, 1, 0), (0.3, -0.5, 0.8)])
def test_a_sliding_ring_is_held_back_against_its_motion_alike_in_every_direction(direction):
    axis = np.asarray(direction) / np.linalg.norm(direction)
    torque = slide_ring(np.tile(2.0 * axis, (2000, 1)))[-1]
    np.testing.assert_allclose(torque, 0.1 * axis, atol=1e-4)


def test_friction_follows_a_motion_that_turns():
    angle = np.linspace(0, 2 * math.pi, 8000)
    rates = 2.0 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    torques = slide_ring(rates)[500:]
    along = np.sum(torques * rates[500:], axis=1) / 2.0
    assert np.linalg.norm(torques, axis=1).max() < 0.1 + 1e-9
    assert along.min() > 0.0995


def test_a_seat_lets_go_of_what_its_load_no_longer_holds():
    rates = np.zeros((1100, 3))
    rates[:1000] = (1.0, 1.0, 0.0)
    limits = np.full(1100, 0.1)
    limits[1000:] = 0.03
    torques = slide_ring(rates, limits)
    assert np.linalg.norm(torques[999]) == pytest.approx(0.1, rel=1e-3)
    assert np.linalg.norm(torques[1000]) == pytest.approx(0.03, rel=1e-6)
