"""What is usual for a regulator is learnt where its pressure rests, and nowhere above that."""

import math

import pytest

from rig.mechanisms.pneumatic.alarms.answers import ChannelAnswers
from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds

LOOP = 2.0**11
BOUNDS = PressureBounds(80e3, 0.05, 33e3, 5e-3, 11e3, 0.5, LOOP)


def learnt(pressure, lag, off=1024.0, usual=0.25, share=0.5, **before):
    channel = ChannelAnswers(2.0**14, 0.0)
    channel.off = off
    for name, value in before.items():
        setattr(channel, name, value)
    channel.learn(pressure, lag, usual, share, BOUNDS)
    return channel


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_it_is_learnt_at_rest(side):
    at_rest = learnt(2.0**15, side * math.nextafter(LOOP, 0.0), usual=0.25)
    assert (at_rest.usual, at_rest.rested, at_rest.unknown) == (256.0, 2.0**15, 0.0)
    again = learnt(2.0**13, 0.0, off=-512.0)
    assert (again.usual, again.rested) == (-128.0, 2.0**14), "lower is known as well"


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_nothing_is_learnt_while_it_moves(side):
    moving = learnt(2.0**14 + 2.0**15, side * LOOP)
    assert (moving.usual, moving.rested) == (0.0, 2.0**14)
    assert moving.unknown == 0.04 * 2.0**15


def test_linearity_is_one_per_cent_of_the_range_at_most_and_is_forgotten_as_deviations_are():
    assert learnt(2.0**20, LOOP).unknown == 2.0 * LOOP
    assert learnt(2.0**13, LOOP).unknown == 0.0
    assert learnt(2.0**13, LOOP, share=0.25, unknown=800.0).unknown == 600.0
    assert learnt(2.0**14 + 2.0**15, LOOP, share=0.25, unknown=800.0).unknown == 0.04 * 2.0**15


def test_it_hides_a_slow_regulator_as_hysteresis_does():
    channel = learnt(2.0**20, LOOP)
    channel.lag_power = 2.0**24
    assert channel.most_slow(BOUNDS) == 0.5 + 3.0 * LOOP / 2.0**12
