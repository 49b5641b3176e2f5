"""Rods that do not agree on a pose, and a count that stays: how far and for how long."""

import math
import re

import pytest
from joint_fakes import (
    GRACE,
    UPRIGHT,
    WireBench,
    off,
    residual_of,
    rods_at,
)

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm

TILTED = rods_at(0.3, 0.4)
WRONG = off(TILTED, 1, 2e-3)
NO_POSE = (0.06, 0.0, -0.06, 0.0)
CHECKS = round(GRACE / WireBench.STEP)
NEARLY = int(GRACE * WireBench().watch._limits.residual / residual_of(WRONG) / WireBench.STEP)
"""So many checks, and not one more, may WRONG be seen."""
TOWARDS_1 = 0.5 * math.pi
"""Azimuth of the first anchor."""


@pytest.mark.parametrize("share", [1.0 + 1e-6, 1.0 - 1e-6])
def test_the_rods_may_disagree_by_the_limit_for_ever(share):
    bench = WireBench(residual=residual_of(WRONG) * share)
    bench.check(TILTED)
    for _ in range(CHECKS - 1):
        bench.check(WRONG)
    if share < 1.0:
        with pytest.raises(SafetyError, match="the four wires disagree"):
            bench.check(WRONG)
        return
    for _ in range(3 * CHECKS):
        bench.check(WRONG)


@pytest.mark.parametrize(("times", "left"), [(1.5, 1 / 1.5), (2.0, 0.5), (4.0, 0.25), (9.0, 0.2)])
def test_the_further_the_rods_are_apart_the_sooner_it_is_a_fault(times, left):
    bench = WireBench(residual=residual_of(WRONG) / times)
    bench.check(TILTED)
    with pytest.raises(SafetyError, match=rf"here for {GRACE * left:.3g} s"):
        for _ in range(2 * CHECKS):
            bench.check(WRONG)
    waited = bench.now - bench.watch._agreed_at
    assert GRACE * left < waited <= GRACE * left + bench.STEP


def test_exactly_on_the_limit_the_rods_agree():
    bench = WireBench()
    bench.check(TILTED)
    bench.check(WRONG)
    bench = WireBench(residual=bench.watch.residual, grace=0.0)
    bench.check(TILTED)
    bench.check(WRONG)


def test_the_message_has_the_numbers_and_their_bounds():
    bench = WireBench()
    bench.check(TILTED)
    with pytest.raises(SafetyError) as caught:
        for _ in range(CHECKS + 1):
            bench.check(WRONG)
    assert re.search(
        r" \[the four wires disagree about the pose by 0\.99 mm for 0\.016 s, at most 0\.488281 mm "
        r"for 0\.03125 s, here for 0\.0154 s\]$",
        str(caught.value),
    )


def test_rods_that_agree_meanwhile_have_their_grace_again():
    bench = WireBench()
    for _ in range(5):
        bench.check(TILTED)
        for _ in range(NEARLY):
            bench.check(WRONG)


def test_rods_that_never_agreed_have_their_grace_from_the_first_check():
    bench = WireBench()
    for _ in range(NEARLY + 1):
        bench.check(WRONG)
    with pytest.raises(SafetyError, match=r"the four wires disagree .* for 0\.016 s"):
        bench.check(WRONG)


def test_rods_that_fit_no_pose_at_all_have_their_grace_too():
    bench = WireBench()
    bench.check(TILTED)
    axis = bench.watch.axis
    for _ in range(int(0.2 * GRACE / bench.STEP)):
        bench.check(NO_POSE)
        assert (bench.watch.axis, bench.watch.residual) == (axis, math.inf)
        assert bench.watch.axis_of(NO_POSE) == axis
    with pytest.raises(SafetyError, match="disagree about the pose by inf mm"):
        bench.check(NO_POSE)


def test_a_grace_that_is_just_over_is_not_passed():
    """A fifth of five thirty-seconds, for rods that fit no pose."""
    bench = WireBench(grace=5.0 / 32.0)
    bench.check(TILTED)
    for _ in range(8):
        bench.check(NO_POSE)
    assert bench.now - bench.watch._agreed_at == 1.0 / 32.0 == 0.2 * 5.0 / 32.0
    with pytest.raises(SafetyError):
        bench.check(NO_POSE)


def test_the_axis_is_the_one_that_the_rods_show():
    bench = WireBench()
    assert (bench.watch.axis, bench.watch.residual) == ((0.0, 0.0, 1.0), 0.0)
    bench.check(TILTED)
    axis = (
        math.sin(0.3) * math.cos(0.4),
        math.sin(0.3) * math.sin(0.4),
        math.cos(0.3),
    )
    assert bench.watch.axis == pytest.approx(axis, abs=1e-9)
    assert bench.watch.residual < 1e-12
    assert bench.watch.axis_of(UPRIGHT) == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    assert bench.watch.axis == pytest.approx(axis, abs=1e-9)  # only looked at


# A count that stays -------------------------------------------------------------------------

DISTANCE, TIME = 0.4e-3, 2.0**-4
HELD = round(TIME / WireBench.STEP)
PER_RADIAN = 25e-3
"""By so much the wire that a ring leans to gets shorter, m/rad."""


def leaning(bench, *gone, azimuth=TOWARDS_1, frozen=1, pause=HELD):
    """Let the ring lean on check by check while a rod's count stays as it was upright.

    `gone` is how far the count should be by now, in shares of the permitted distance; before
    the ring starts, the count has been the same for a while.
    """
    for _ in range(pause):
        bench.check(UPRIGHT)
    for share in gone:
        rods = list(rods_at(share * DISTANCE / PER_RADIAN, azimuth))
        rods[frozen - 1] = 0.0
        bench.check(tuple(rods))


def frozen_bench(distance=DISTANCE, time=TIME):
    return WireBench(residual=1.0, frozen=FrozenAlarm(distance, time))


@pytest.mark.parametrize("frozen", [1, 2, 3, 4])
def test_a_count_that_stays_while_the_others_move_on_is_named(frozen):
    azimuth = {1: 0.5, 2: 1.0, 3: 1.5, 4: 0.0}[frozen] * math.pi
    bench = frozen_bench()
    leaning(bench, 0.3, 0.6, 0.9, 0.98, azimuth=azimuth, frozen=frozen)
    with pytest.raises(SafetyError) as caught:
        leaning(bench, 1.02, azimuth=azimuth, frozen=frozen, pause=0)
    assert str(caught.value) == (
        f"e{frozen} is frozen, or the rod of ch{frozen} is jammed: the other three moved on by "
        "0.41 mm while it said the same for 0.078 s [at most 0.4 mm for 0.0625 s]"
    )


def test_a_count_may_stay_for_its_time():
    slow = [0.25 + 0.05 * k for k in range(15)]
    bench = frozen_bench()
    leaning(bench, *slow, 1.1, pause=1)  # fifteen steps after the first check, and one
    with pytest.raises(SafetyError, match=r"for 0\.066 s \["):
        leaning(bench, 1.1, pause=0)


def test_a_count_that_changes_has_its_time_again():
    bench = frozen_bench()
    leaning(bench, 0.3, 0.6, 0.9)
    # It moves by one count while it is read, at once where it was again.
    rods = list(rods_at(0.9 * DISTANCE / PER_RADIAN, TOWARDS_1))
    rods[0] = 1e-9
    bench.check(tuple(rods))
    leaning(bench, *[0.9] * HELD, 1.5, pause=0)  # further by 0.6 since then
    with pytest.raises(SafetyError, match=r"moved on by 0\.4"):
        leaning(bench, 1.7, 1.95, pause=0)


def test_a_count_that_followed_until_now_has_the_whole_time():
    bench = frozen_bench()
    for k in range(2 * HELD):
        bench.check(rods_at(1e-4 * k, TOWARDS_1))
    stays = rods_at(1e-4 * (2 * HELD - 1), TOWARDS_1)[0]
    began = bench.now
    with pytest.raises(SafetyError, match=r"e1 is frozen.* for 0\.066 s \["):
        for k in range(2 * HELD):
            rods = rods_at(1e-4 * 2 * HELD + min(k, 8) * 4e-3, TOWARDS_1)
            bench.check((stays, *rods[1:]))
    assert bench.now - began == TIME + bench.STEP


def test_what_jumps_within_two_checks_is_another_rod():
    for gone, another in (
        ((1.2,), True),
        ((0.6, 1.2), True),
        ((0.23, 0.6, 1.2), True),  # at 0.23 it was not on its way yet
        ((0.27, 0.6, 1.2), False),
        ((0.4, 0.8, 1.2), False),
    ):
        bench = frozen_bench()
        if another:
            leaning(bench, *gone)
            leaning(bench, *[gone[-1]] * 50, pause=0)  # it stays where it is, and is forgiven
        else:
            with pytest.raises(SafetyError, match="e1 is frozen"):
                leaning(bench, *gone)


def test_two_and_a_half_checks_are_too_long_for_a_jump():
    bench = frozen_bench()
    leaning(bench)
    for share, steps in ((0.6, 1.5), (1.2, 1.0)):
        rods = list(rods_at(share * DISTANCE / PER_RADIAN, TOWARDS_1))
        rods[0] = 0.0
        if share < 1.0:
            bench.check(tuple(rods), steps=steps)
            continue
        with pytest.raises(SafetyError, match="e1 is frozen"):
            bench.check(tuple(rods), steps=steps)


def test_a_jump_is_forgiven_once_and_then_counts_from_there():
    bench = frozen_bench()
    leaning(bench, 1.2)
    leaning(bench, *[1.2] * 3, 1.6, 1.9, 2.15, pause=0)
    with pytest.raises(SafetyError, match=r"moved on by 0\.4"):
        leaning(bench, 2.25, pause=0)


def test_rods_that_all_move_are_well():
    bench = frozen_bench()
    for k in range(200):
        bench.check(rods_at(0.002 * k, 0.4))
