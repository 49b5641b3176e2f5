"""A pull that no monitor shows is told from friction, whatever the pair does."""

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.balance import Instant, missing_pull
from rig.mechanisms.pneumatic.settings import SealFriction

FRICTION = SealFriction(coulomb=10.4, breakaway=13.4, stribeck_velocity=8e-3, viscous=50.0)
MASS = 0.138


def slide(shown, true, friction_scale, start, period):
    """Return the history of a pair that slides under a pull of which monitors show a part, N."""
    history, place, speed, fine = [], 0.0, start, period / 50.0
    for k in range(round(0.03 / period)):
        history.append(Instant(k * period, place, shown))
        for _ in range(50):
            drag = friction_scale * (
                FRICTION.coulomb * np.tanh(speed / 1e-4) + FRICTION.viscous * speed
            )
            speed += fine * (true - drag) / MASS
            place += fine * speed
    return history


@pytest.mark.parametrize("seed", range(20))
def test_a_chamber_that_empties_while_the_pair_slides_is_found(seed):
    rng = np.random.default_rng(seed)
    sign = rng.choice([-1.0, 1.0])
    shown, unseen = sign * rng.uniform(0.0, 15.0), sign * rng.uniform(25.0, 45.0)
    history = slide(
        shown, shown + unseen, rng.uniform(0.85, 1.5), sign * 0.02, rng.choice([1e-3, 2e-3])
    )
    missing = missing_pull(history, MASS, FRICTION)
    assert np.sign(missing) == sign
    assert abs(missing) < abs(unseen) * 1.2


@pytest.mark.parametrize("seed", range(20))
def test_what_the_monitors_show_needs_no_other_cause(seed):
    rng = np.random.default_rng([1, seed])
    sign = rng.choice([-1.0, 1.0])
    pull = sign * rng.uniform(12.0, 60.0)
    history = slide(pull, pull, rng.uniform(0.7, 1.6), sign * rng.uniform(0.0, 0.3), 1e-3)
    assert missing_pull(history, MASS, FRICTION) == 0.0


def test_seals_hold_so_much_and_no_more():
    def held(pull):
        return [Instant(1e-3 * k, 5e-3, pull) for k in range(40)]

    most = 1.6 * FRICTION.breakaway
    assert missing_pull(held(most), MASS, FRICTION, sticks=True) == 0.0
    assert missing_pull(held(-most - 20.0), MASS, FRICTION, sticks=True) == pytest.approx(20.0)
    moving = slide(0.0, 40.0, 1.0, 0.02, 1e-3)
    assert missing_pull(moving, MASS, FRICTION) > 0.0
    assert missing_pull(moving, MASS, FRICTION, sticks=True) == 0.0


def test_too_short_a_past_tells_nothing():
    assert missing_pull([], MASS, FRICTION) == 0.0
    assert missing_pull([Instant(1e-3 * k, 0.0, 90.0) for k in range(6)], MASS, FRICTION) == 0.0
