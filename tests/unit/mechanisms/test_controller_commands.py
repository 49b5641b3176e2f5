"""What a controller may ask of servo axes, and of chambers, before anything is clamped."""

import math
import random

import pytest
from servo_fakes import FOLLOWING, NAMES, PERIOD, RATES, Command, Reference, ServoBench

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.devices import check_asked_pressures
from rig.mechanisms.servo.asked import AskedPositions

REACH = tuple(2.0 * rate * PERIOD for rate in RATES)
CHANNELS = ("ch1", "ch2", "ch3", "ch4")
GREATEST = 400e3


def refer(*positions):
    return Reference(positions, (0.0,) * 3, True)


def started(seed):
    """Return a bench that has followed its reference for a while, where it is, and chance."""
    chance = random.Random(seed)
    bench = ServoBench()
    bench.start()
    here = [0.0, 0.0, 0.0]
    for _ in range(chance.randint(1, 8)):
        here = [p + chance.uniform(-1, 1) * r * PERIOD for p, r in zip(here, RATES, strict=True)]
        bench.axes.check_command(refer(*here), Command(tuple(here), (0.0,) * 3))
        bench.limit(*here)
    return bench, here, chance


@pytest.mark.parametrize("seed", range(20))
def test_a_jump_that_no_axis_can_make_names_the_controller_and_the_axis(seed):
    bench, here, chance = started(seed)
    k = chance.randrange(3)
    jump = chance.choice((-1, 1)) * math.exp(chance.uniform(math.log(0.2), math.log(1e9)))
    asked = list(here)
    asked[k] += jump
    with pytest.raises(SafetyError, match=f"the controller's command of {NAMES[k]} jumps by"):
        bench.axes.check_command(refer(*here), Command(tuple(asked), (0.0,) * 3))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("k", range(3))
def test_what_is_no_number_names_the_controller_and_the_axis(k, bad):
    bench, here, _ = started(k)
    asked = list(here)
    asked[k] = bad
    with pytest.raises(SafetyError, match=f"the controller's command of {NAMES[k]} is {bad} rad"):
        bench.axes.check_command(refer(*here), Command(tuple(asked), (0.0,) * 3))


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("k", range(3))
def test_twice_the_greatest_speed_is_clamped_and_more_is_a_fault(k, way):
    for share, faulty in ((0.999, False), (1.001, True)):
        bench, here, _ = started(7)
        bench.axes.check_command(refer(*here), Command(tuple(here), (0.0,) * 3))
        bench.axes.check_command(refer(*here), Command(tuple(here), (0.0,) * 3))
        asked = list(here)
        asked[k] += share * way * REACH[k]
        command = Command(tuple(asked), (0.0,) * 3)
        if faulty:
            with pytest.raises(SafetyError, match="jumps by"):
                bench.axes.check_command(refer(*here), command)
        else:
            bench.axes.check_command(refer(*here), command)


def test_a_step_of_the_reference_may_be_followed_now_or_a_period_later():
    for wait in (0, 1, 2):
        bench = ServoBench()
        bench.start()
        still = Command((0.0,) * 3, (0.0,) * 3)
        bench.axes.check_command(refer(0.0, 0.0, 0.0), still)
        there = refer(0.0, 0.4, 0.0)
        for _ in range(wait):
            bench.axes.check_command(there, still)
        asked = Command((0.0, 0.4, 0.0), (0.0,) * 3)
        if wait < 2:
            bench.axes.check_command(there, asked)
        else:
            with pytest.raises(SafetyError, match=r"command of b jumps by 0\.4 rad"):
                bench.axes.check_command(there, asked)


def test_the_first_command_may_start_from_where_the_axes_are():
    bench = ServoBench()
    bench.start()
    bench.limit(0.0, 0.0, 0.0)
    near = Command((0.9 * FOLLOWING, 0.0, 0.0), (0.0,) * 3)
    bench.axes.check_command(refer(*near.positions), near)
    bench.start()
    far = Command((1.1 * (FOLLOWING + REACH[0]), 0.0, 0.0), (0.0,) * 3)
    with pytest.raises(SafetyError, match="command of a jumps by"):
        bench.axes.check_command(refer(*far.positions), far)


@pytest.mark.parametrize("seed", range(20))
def test_pressures_far_outside_name_the_controller_and_the_chamber(seed):
    chance = random.Random(seed)
    fair = [chance.uniform(-9.9, 9.9) * GREATEST for _ in CHANNELS]
    check_asked_pressures(CHANNELS, fair, GREATEST)
    k = chance.randrange(4)
    fair[k] = chance.choice((math.nan, math.inf, -math.inf, 1e9, -1e9, 10.1 * GREATEST))
    with pytest.raises(SafetyError, match=f"the controller's command of {CHANNELS[k]} is"):
        check_asked_pressures(CHANNELS, fair, GREATEST)


P = 2.0**-7
SLACK = 2.0**-2


def asked(rate=1.0):
    return AskedPositions(("a",), (rate,), SLACK, P)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_bound_of_a_command_is_permitted_and_nothing_beyond(way):
    reach = 2.0 * P
    for first in (True, False):
        most = reach + SLACK if first else reach
        for jump, faulty in ((most, False), (math.nextafter(most, 1.0), True)):
            checked = asked()
            if not first:
                checked.check((0.0,), (0.0,))
            if faulty:
                with pytest.raises(SafetyError, match="of a jumps by"):
                    checked.check((0.0,), (way * jump,))
            else:
                checked.check((0.0,), (way * jump,))


@pytest.mark.parametrize("step", [0.5, -0.5])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_step_of_the_reference_counts_whichever_way_it_goes(step, way):
    checked = asked()
    checked.check((0.0,), (0.0,))
    checked.check((step,), (way * 0.5,))
