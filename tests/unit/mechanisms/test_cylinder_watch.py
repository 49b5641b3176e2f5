"""What the two rods of a pair show: whether they agree, and one that says the same."""

import math

import numpy as np
import pytest
from cylinder_rods import CHANGE, NAMES, WIDE, Rods
from pneumatic_fakes import (
    BASE,
    MISMATCH,
    TINY,
    pair_settings,
)

from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.cylinder.watch import _Readings
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm

# Their agreement --------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_agreement_may_change_by_its_bound(sign):
    rods = Rods(change=CHANGE)
    rods.settle()
    rods.cycle(sign * CHANGE, sign * CHANGE)
    with pytest.raises(LimitExceeded) as caught:
        rods.cycle(sign * (CHANGE + TINY), sign * (CHANGE + TINY))
    error = caught.value
    slack = "a wire is slack, or " if sign < 0.0 else ""
    assert error.quantity == (
        f"change of the mismatch of the two rods ({slack}encoder-agonist or encoder-antagonist "
        "drifts or has a wrong scale, or wires are softer than the profile says; or the "
        "carriage was pushed)"
    )
    assert (error.lower, error.upper, error.unit) == (-CHANGE, CHANGE, "m")
    assert error.value == pytest.approx(sign * (CHANGE + TINY), rel=1e-9)


def test_what_the_pressures_stretch_is_no_change():
    """Half the area over a wire's stiffness for each pascal, by which a wire shortens the rest."""
    rods = Rods(change=CHANGE, wire_stiffness=8e3)
    rods.settle()
    give = 0.5 * rods.settings.area / 8e3
    more = (BASE + 30e3, BASE + 10e3)
    rods.cycle(-give * 40e3, -give * 40e3, more)
    with pytest.raises(LimitExceeded) as caught:
        rods.cycle(0.0, 0.0, more)
    assert caught.value.value == pytest.approx(give * 40e3)


def test_the_agreement_counts_once_the_wires_have_been_taut_for_a_while():
    taut = 0.5 * pair_settings().friction.breakaway / pair_settings().area
    for least, counts in ((taut, True), (math.nextafter(taut, 0.0), False)):
        for pressures in ((least, 9e4), (9e4, least)):
            rods = Rods(change=CHANGE, mismatch=WIDE)
            rods.settle(pressures)
            if counts:
                with pytest.raises(LimitExceeded, match="change of the mismatch"):
                    rods.cycle(2 * CHANGE, 2 * CHANGE, pressures)
            else:
                rods.cycle(2 * CHANGE, 2 * CHANGE, pressures)


def test_a_tenth_of_a_second_is_not_yet_a_while():
    rods = Rods(change=CHANGE)
    rods.cycle(0.5 * CHANGE, 0.5 * CHANGE, step=0.1)
    rods.cycle(0.0, 0.0)  # this one is the usual
    rods.cycle(CHANGE, CHANGE)
    with pytest.raises(LimitExceeded, match="change of the mismatch"):
        rods.cycle(CHANGE + TINY, CHANGE + TINY)


def test_wires_that_were_slack_have_a_new_agreement_after_their_while():
    rods = Rods(change=CHANGE)
    rods.settle()
    rods.cycle(2 * CHANGE, 2 * CHANGE, (0.0, BASE))
    for _ in range(100):
        rods.cycle(2 * CHANGE, 2 * CHANGE)
    rods.cycle(0.0, 0.0)  # it has not been a tenth of a second
    for _ in range(100):
        rods.cycle(2 * CHANGE, 2 * CHANGE)
    with pytest.raises(LimitExceeded, match="change of the mismatch"):
        rods.cycle(0.5 * CHANGE, 0.5 * CHANGE)


# A rod that says the same ---------------------------------------------------------------------

FROZEN = FrozenAlarm(2.0**-12, 2.0**-5)
HELD = 32
"""Cycles for which a rod may say the same."""


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("frozen", [0, 1])
def test_a_rod_may_say_the_same_while_the_other_moves_by_the_distance_and_for_the_time(frozen, way):
    def place(rods, moved):
        rods.cycle(*((0.0, moved) if frozen == 0 else (moved, 0.0)))

    distance = way * FROZEN.distance
    rods = Rods(frozen=FROZEN)
    rods.cycle(0.0, 0.0)
    for _ in range(HELD):
        place(rods, distance + way * TINY)  # far, and not for long
    for _ in range(3 * HELD):
        place(rods, distance)  # long, and not far
    name, channel = NAMES[frozen], ("agonist", "antagonist")[frozen]
    with pytest.raises(SafetyError) as caught:
        place(rods, distance + way * TINY)
    assert str(caught.value) == (
        f"{name} is frozen, or the rod of {channel} is jammed: the other one moved on by 0.24 mm "
        "while it said the same for 0.126 s [at most 0.244141 mm for 0.03125 s]"
    )


@pytest.mark.usefixtures("moved_by_hand")
def test_a_rod_that_moves_has_its_time_and_its_distance_again():
    rods = Rods(frozen=FROZEN)
    for k in range(4 * HELD):
        rods.cycle(-k * 2.0**-14, k * 2.0**-14)
    last = 4 * HELD * 2.0**-14
    for k in range(HELD):
        rods.cycle(-last, last + k * 2.0**-14)
    with pytest.raises(SafetyError, match=r"encoder-agonist is frozen.*for 0\.03"):
        for k in range(HELD, 2 * HELD):
            rods.cycle(-last, last + k * 2.0**-14)


def test_which_rod_stood_still_is_said_by_half_its_chambers_pull():
    """Beyond the bound of the agreement, and with more pull than the half of friction holds."""
    sliding = 0.5 * pair_settings().friction.coulomb
    area = pair_settings().area
    near = sliding / area * (1.0 + np.arange(-8, 9) * 2.0**-53)
    exact = next(float(p) for p in near if area * p == sliding)
    for pressure, words in (
        (1.001 * sliding / area, r"\(encoder-antagonist is frozen\)"),
        (exact, r"\(the rod of antagonist stays behind, as its chamber is empty"),
    ):
        for way in (1.0, -1.0):
            for before in (BASE, 0.0):  # what counts is its pull now
                rods = Rods(change=0.9 * MISMATCH, mismatch=MISMATCH)
                for _ in range(3):
                    rods.cycle(0.0, 0.0, (BASE, before))
                with pytest.raises(LimitExceeded, match=words):
                    rods.cycle(way * (2 * MISMATCH + 2 * TINY), 0.0, (BASE, pressure))
    # Less than the bound is no standing still: the agreement is judged by two rods.
    rods = Rods(change=2 * MISMATCH + 2 * TINY, mismatch=MISMATCH)
    rods.cycle(0.0, 0.0)
    with pytest.raises(LimitExceeded, match="drifts or has a wrong scale"):
        rods.cycle(2 * MISMATCH + 2 * TINY, 0.0)


@pytest.mark.parametrize(("way", "drag"), [(20e-6, 1.0), (21e-6, 0.0)])
def test_a_rod_that_moves_by_no_more_than_noise_is_braked_by_all_of_its_friction(way, drag):
    """To and fro from nought: of four late ways two lead out, each to the bound itself."""
    watch = Rods().watch
    watch._history.extend(_Readings((out, 0.0), (0.0, 0.0), 0.0) for out in (0.0, way) * 3)
    assert watch._drag(0) == pytest.approx(drag)
