"""From when on a fault can be seen: at once, or when the law or the setpoints show it."""

import random

import pytest

from drivers.sim.frame_faults import FrameFault, FrameFaults
from rig.faults.case import Break
from rig.faults.felt import Felt
from rig.faults.subject import Subject

PERIOD = 0.005
SUBJECT = Subject(
    rig="legs", experiments=("walk",), period=PERIOD, channels={}, knows={}, frames={}, on_bus={},
    hazards=(), connecting=1.0, reading_age=0.03,
)  # fmt: skip
LEAST = 0.03 + 4.0 * PERIOD
"""For so long setpoints must be gone to be missed, s."""


def broken(kind, lasts=float("inf"), magnitude=None):
    return Break(kind, "left-leg", magnitude, lasts)


@pytest.mark.parametrize("seed", range(5))
def test_setpoints_that_stand_while_they_are_lost_are_not_missed(seed):
    chance = random.Random(seed)
    made, lasts = chance.uniform(1.0, 5.0), chance.uniform(2.0 * LEAST, 1.0)
    felt = Felt(SUBJECT)
    felt.make(broken("setpoints_lost", lasts), made)
    assert (felt.times, felt.made_at, len(felt)) == ((None,), (made,), 1)
    felt.change(0, made + lasts - LEAST + 1e-6)
    assert felt.times == (None,), "too little is left of it to be seen"
    early = made + chance.uniform(0.0, lasts - LEAST - 1e-6)
    felt.change(0, early)
    felt.change(0, early + 1e-3)
    assert felt.times == (early,)


def test_a_law_is_felt_when_it_is_followed_and_all_else_at_once():
    felt = Felt(SUBJECT)
    assert not felt.spoil(0.5), "nothing has happened"
    felt.make(broken("controller_nan"), 1.0)
    felt.make(broken("drive_stuck"), 1.5)
    assert felt.times == (None, 1.5)
    assert felt.spoil(2.0), "the first one is felt from now on"
    assert not felt.spoil(2.5)
    assert felt.times == (2.0, 1.5)


@pytest.mark.parametrize("kind", ["drop", "delay"])
def test_a_disturbed_frame_tells_when_it_says_something_else(kind):
    faults, told = FrameFaults(), []
    fault = FrameFault(kind, 0x201, count=1 << 60, changed=lambda: told.append(1))
    for data in (b"\1", b"\2"):
        faults.apply(0x201, data)  # nothing is disturbed yet
    faults.add(fault)
    seen = []
    for data in (b"\3", b"\3", b"\4", b"\4", b"\5"):
        faults.apply(0x201, data)
        seen.append(len(told))
    assert seen == [0, 0, 1, 1, 2]
    faults.remove(fault)
    faults.apply(0x201, b"\6")
    faults.add(fault)
    faults.apply(0x201, b"\7")
    assert len(told) == 2, "what was before it happened again is forgotten"
