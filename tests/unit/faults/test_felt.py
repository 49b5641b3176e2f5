"""From when on a fault can be seen: at once, or when the law or the setpoints show it."""

import random
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from drivers.sim.frame_faults import FrameFault, FrameFaults
from rig.faults.case import Break
from rig.faults.felt import Felt
from rig.faults.kind import Sizes
from rig.faults.lagging import lags, moves
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


def slow_chamber(way, took, begins=1.0, ends=4.0):
    """Return times and the rows of two chambers of which the second goes `way` in `took`, Pa."""
    times = np.arange(0.0, ends, 1e-3)
    pressure = 60e3 + way * np.clip((times - begins) / took, 0.0, 1.0)
    return times, np.column_stack([np.full_like(times, 60e3), pressure])


@pytest.mark.parametrize(
    ("way", "took", "until", "shows"),
    [
        (0.0, 0.3, 4.0, False), (5e3, 0.05, 4.0, False), (75e3, 2.0, 4.0, False),
        (75e3, 0.3, 4.0, True), (75e3, 0.3, 1.4, False), (-75e3, 0.3, 4.0, True),
    ],
    ids=["rests", "moves little", "moves slowly", "moves", "too late", "falls"],
)  # fmt: skip
def test_a_slow_regulator_is_felt_when_its_pressure_moves(way, took, until, shows):
    known = [f"{channel}.{fault}" for channel in ("agonist", "antagonist")
             for fault in ("regulator_slow", "leak")]  # fmt: skip
    felt = Felt(replace(SUBJECT, knows={"plant": tuple(known)}))
    felt.make(Break("regulator_slow", "plant antagonist", 3.0, inf), 0.5)
    felt.make(Break("regulator_slow", "plant agonist", 3.0, inf), 0.5)
    felt.make(Break("leak", "plant agonist", 2e-8, inf), 0.6)
    columns = ["pressure_agonist", "pressure_antagonist"]
    moved, rested, leaked = felt.shown(columns, *slow_chamber(way, took), until)
    assert (rested, leaked) == (None, 0.6)
    assert (moved is not None) is shows
    if moved is not None:
        # (3 - 1) 50 ms times 250 kPa/s are 25 kPa; 0.23 s of it in a second are 12 kPa rms.
        assert moved == pytest.approx(1.23, abs=2e-3)
        assert felt.shown(["position", "velocity"], *slow_chamber(way, took), until)[0] == 0.5


def test_a_slow_regulator_whose_time_ends_at_once_is_not_felt():
    times = np.array([1.0])
    assert lags(Sizes(6.0, inf), times, np.array([[60e3]])) is None


@pytest.mark.parametrize(
    ("moving", "way", "until", "shows"),
    [
        ("ch4", 0.9e-3, 4.0, False), ("ch4", 1.1e-3, 1.76, True), ("ch2", -1.1e-3, 4.0, True),
        ("ch4", 1.1e-3, 1.74, False), ("ch1", 7e-3, 4.0, False), ("ch3", -7e-3, 4.0, False),
    ],
    ids=["gives", "its opponent pulls", "gives way", "too late", "another pair", "another again"],
)  # fmt: skip
def test_a_tube_that_is_off_is_felt_when_a_rod_of_its_pair_moves(moving, way, until, shows):
    channels = ("ch1", "ch2", "ch3", "ch4")
    knows = {"plant": tuple(f"{channel}.leak" for channel in channels)}
    felt = Felt(replace(SUBJECT, knows=knows, channels={"plant": channels}))
    felt.make(Break("leak", "plant ch2", 3e-8, inf), 0.5)
    times = np.arange(0.0, 4.0, 1e-3)
    rods = np.column_stack([0.02 + way * ((channel == moving) & (times > 1.25))
                            for channel in channels])  # fmt: skip
    (found,) = felt.shown([f"extension_{channel}" for channel in channels], times, rods, until)
    assert (found is not None) is shows
    if found is not None:
        assert found == pytest.approx(1.251, abs=1.1e-3)


@pytest.mark.parametrize(
    ("stops", "again", "felt_at"),
    [
        (1.8, None, 1.251), (1.6, None, None), (1.6, 2.0, 2.001), (1.6, 3.6, None),
        (1.2, None, 1.251), (inf, None, 1.251),
    ],
    ids=["long before", "just before", "in the stop", "at its end", "begins in it", "no stop"],
)  # fmt: skip
def test_what_moves_just_before_a_stop_is_felt_if_it_moves_in_it(stops, again, felt_at):
    knows = {"plant": ("agonist.leak", "antagonist.leak")}
    felt = Felt(replace(SUBJECT, knows=knows))
    felt.make(Break("leak", "plant agonist", 3e-8, inf), 0.5)
    times = np.arange(0.0, 4.0, 1e-3)
    way = 2e-3 * (times > 1.25) + 2e-3 * (times > (again or inf))
    rods = np.column_stack([0.02 + way, 0.02 - way])
    (found,) = felt.shown(["extension_agonist", "extension_antagonist"], times, rods, 4.0, stops)
    assert found == (None if felt_at is None else pytest.approx(felt_at, abs=1.1e-3))


def test_nothing_moves_in_no_time():
    assert moves(Sizes(3e-8, inf), np.empty(0), np.empty((0, 2))) is None
