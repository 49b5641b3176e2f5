"""Friction models on their own."""

import math

import numpy as np
import pytest

from drivers.sim.plants.friction import limit_bristle, step_bristle, stribeck_force
from drivers.sim.plants.pair_kernel import PAIR_PARAMETERS, PAIR_STATE, seat_friction
from drivers.sim.plants.regulator import bow, follow_with_play


def test_stribeck_curve_from_breakaway_to_coulomb():
    assert stribeck_force(0.0, 3.0, 4.5, 8e-3) == 4.5
    assert stribeck_force(8e-3, 3.0, 4.5, 8e-3) == pytest.approx(3.0 + 1.5 / math.e)
    assert stribeck_force(-0.5, 3.0, 4.5, 8e-3) == pytest.approx(3.0)


@pytest.mark.parametrize("speed", [1e-4, 1e-2, -1.0, 20.0])
def test_bristles_settle_at_the_friction_force_at_any_speed(speed):
    bristle = 0.0
    for _ in range(40_000):
        bristle = step_bristle(bristle, speed, 1.5e5, 3.0, 50e-6)
    assert 1.5e5 * bristle == pytest.approx(math.copysign(3.0, speed), rel=1e-3)


def test_bristles_are_a_spring_before_they_slip():
    bristle = 0.0
    for _ in range(1000):
        bristle = step_bristle(bristle, 1e-5, 1.5e5, 4.5, 50e-6)
    displacement = 1000 * 50e-6 * 1e-5
    assert bristle == pytest.approx(displacement, rel=0.02)


def test_a_seat_holds_no_more_than_its_load():
    assert limit_bristle(30e-6, 1e5, 2.0) == pytest.approx(20e-6)
    assert limit_bristle(-30e-6, 1e5, 2.0) == pytest.approx(-20e-6)
    assert limit_bristle(10e-6, 1e5, 2.0) == 10e-6


def test_play_makes_a_loop_of_its_width():
    up = follow_with_play(0.0, 10.0, 1.5)
    assert up == 8.5
    assert follow_with_play(up, 7.5, 1.5) == 8.5
    assert follow_with_play(up, 6.0, 1.5) == 7.5


def test_bow_is_exact_at_the_ends():
    assert bow(0.0, 5e5, 0.01) == 0.0
    assert bow(5e5, 5e5, 0.01) == pytest.approx(5e5)
    assert bow(2.5e5, 5e5, 0.01) == pytest.approx(2.5e5 + 5e3)


def test_a_seat_lets_go_of_what_its_load_no_longer_holds():
    pair = np.zeros(1, PAIR_STATE)
    parameters = np.zeros(1, PAIR_PARAMETERS)
    parameters["seat"], parameters["seat_stiffness"] = 0.1, 1e5
    pair["speed"] = 10e-3
    for _ in range(1000):
        held = seat_friction(pair[0], parameters[0], 40.0, 50e-6)
    assert held == pytest.approx(4.0, rel=1e-3)
    pair["speed"] = 0.0
    assert seat_friction(pair[0], parameters[0], 10.0, 50e-6) == pytest.approx(1.0)
    assert seat_friction(pair[0], parameters[0], 40.0, 50e-6) == pytest.approx(1.0)
