"""The motion that shows a loop: it never turns round, never jumps, and is periodic where judged."""

import random

import numpy as np
import pytest

from rig.mechanisms.cylinder.probe import Probe

DRAWN = random.Random(1791)
STEP = 1e-4


def drawn():
    speed, period = DRAWN.uniform(15e-3, 45e-3), DRAWN.choice([0.3, 0.4, 0.5, 0.8])
    settle, turn = DRAWN.uniform(0.2, 0.4), DRAWN.uniform(0.1, 0.3)
    glide = turn + settle + period + DRAWN.uniform(0.1001, 0.3)
    return Probe(
        travel=0.5 * speed * glide, speed=speed, shake=DRAWN.uniform(0.1, 0.9), period=period,
        settle=settle, turn=turn, repeats=2,
    )  # fmt: skip


@pytest.fixture(params=range(6))
def probe(request):
    return drawn()


def sampled(probe, low, high):
    t = np.arange(low, high, STEP)
    return t, np.array([probe.at(float(one)) for one in t])


def test_velocity_and_acceleration_are_those_of_the_position(probe):
    _, motion = sampled(probe, 0.0, probe.duration)
    position, velocity, acceleration = motion.T
    assert np.abs(np.gradient(position, STEP) - velocity)[1:-1].max() < 2e-3 * probe.speed
    largest = np.abs(acceleration).max()
    # A glide's turn begins and ends with a jump of the acceleration: a few instants differ there.
    off = np.abs(np.gradient(velocity, STEP) - acceleration)[1:-1]
    assert np.count_nonzero(off > 0.02 * largest) <= 3 * 2 * 4 * probe.repeats


def test_it_begins_and_ends_at_rest_within_its_travel(probe):
    for t in (0.0, probe.duration):
        position, velocity, _ = probe.at(t)
        assert (abs(position), velocity) == (
            pytest.approx(probe.travel),
            pytest.approx(0.0, abs=1e-9),
        )
    _, motion = sampled(probe, 0.0, probe.duration)
    assert np.abs(motion[:, 0]).max() <= probe.travel * (1.0 + 1e-9)


def test_a_glide_never_turns_round_and_is_judged_over_one_period_of_its_shake(probe):
    shaken = []
    for number, segment in enumerate(probe.segments):
        assert segment.end - segment.start == pytest.approx(probe.period)
        t, motion = sampled(probe, segment.start, segment.end - 0.5 * STEP)
        sign = -1.0 if number % 2 else 1.0
        least = (1.0 - probe.shake) * probe.speed
        assert (sign * motion[:, 1]).min() >= 0.999 * least
        shaken.append(motion[:, 0] - sign * probe.speed * (t - t[0]) - motion[0, 0])
        angles = 2.0 * np.pi * np.outer(t - t[0], np.array(probe.harmonics) / probe.period)
        basis = np.column_stack([np.ones_like(t), t, np.cos(angles), np.sin(angles)])
        left = motion[:, 0] - basis @ np.linalg.lstsq(basis, motion[:, 0], rcond=None)[0]
        assert np.abs(left).max() < 1e-9  # nothing but a straight line and its harmonics
    # The same shake in every glide, whichever way it goes.
    assert np.abs(np.diff([one[:100] for one in shaken], axis=0)).max() < 1e-8


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"travel": 5e-3}, "travel farther, or slower"),
        ({"travel": 18e-3, "harmonics": (3, 2, 5)}, "each is larger"),
    ],
)
def test_what_cannot_be_done_is_refused(settings, said):
    with pytest.raises(ValueError, match=said):
        Probe(**settings)
