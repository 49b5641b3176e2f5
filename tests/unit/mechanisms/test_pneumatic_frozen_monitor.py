"""A monitor that says the very same while its pressure was to move, and those that may."""

import math

import pytest

from rig.mechanisms.pneumatic.alarms.frozen import FrozenMonitors

STEP = 2.0**-10
TIME = 2.0**-6
CYCLES = round(TIME / STEP)
MOVED = 5e3
START = 100e3
LEAST = 10e3


class Shown:
    """Two monitors: one that is always well, and one that a test freezes."""

    def __init__(self, now=0.0):
        self.frozen = FrozenMonitors(TIME, MOVED, LEAST)
        self.frozen.begin((START, START), now)
        self.now, self.cycle, self.value = now, 0, START

    def pass_by(self, cycles, healthy=START, changes=lambda cycle: True):
        """Let time pass; return what is found in the last cycle."""
        found = None
        for _ in range(cycles):
            self.now += STEP
            self.cycle += 1
            if changes(self.cycle):
                self.value = START + self.cycle
            other = START + self.cycle % 2
            found = self.frozen.find((other, self.value), (START, healthy), self.now)
        return found

    def freeze(self, cycles, healthy):
        return self.pass_by(cycles, healthy, changes=lambda cycle: False)


def lively(**options):
    shown = Shown(**options)
    shown.pass_by(1024)
    return shown


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("now", [0.0, 8.0])
def test_it_is_found_as_soon_as_it_has_lasted_and_the_pressure_has_moved(way, now):
    shown = lively(now=now)
    assert shown.freeze(CYCLES, START + way * (MOVED + 1.0)) is None
    assert shown.freeze(1, START + way * (MOVED + 1.0)) == 1
    assert shown.frozen.gone(1) == MOVED + 1.0
    assert shown.frozen.since(1) == shown.now - TIME - STEP
    assert shown.frozen.gone(0) == 0.0


def test_a_pressure_that_hardly_moves_may_be_shown_by_one_number():
    shown = lively()
    assert shown.freeze(10 * CYCLES, START + MOVED) is None
    assert shown.freeze(1, START + MOVED + 0.125) == 1


def test_ways_up_and_down_add_up():
    shown = lively()
    shown.freeze(CYCLES, START + 0.6 * MOVED)
    assert shown.freeze(1, START - 0.3 * MOVED) is None
    assert shown.freeze(1, START - 0.5 * MOVED) == 1
    assert shown.frozen.gone(1) == pytest.approx(1.1 * MOVED)


def test_what_was_moved_before_the_last_value_does_not_count():
    shown = lively()
    shown.pass_by(1, START + 10.0 * MOVED)
    assert shown.freeze(10 * CYCLES, START + 10.0 * MOVED) is None


@pytest.mark.parametrize(
    ("every", "is_found"), [((1, 1), True), ((2, 3), True), ((1, 3), False), ((0, 1), False)]
)
def test_only_a_monitor_whose_noise_was_seen_is_frozen(every, is_found):
    """One without noise, or read more seldom than the loop goes round, repeats what it said."""
    of, among = every
    shown = Shown()
    shown.pass_by(3072, changes=lambda cycle: cycle % among < of)
    found = shown.freeze(2 * CYCLES, START + 2.0 * MOVED)
    assert (found == 1) == is_found


def test_noise_has_to_be_seen_for_a_while():
    """After 0.25 s at each cycle by 1 - 1/e: half of it comes after ln 2 of that."""
    cycles = math.ceil(math.log(2.0) / math.log1p(STEP / 0.25))
    for seen, is_found in ((cycles - 1, False), (cycles, True)):
        shown = Shown()
        shown.pass_by(seen)
        found = shown.freeze(2 * CYCLES, START + 2.0 * MOVED)
        assert (found == 1) == is_found


def test_one_that_was_silent_for_long_has_to_be_seen_anew():
    """Vented chambers show nothing but 0, and the first bit that differs is no noise yet."""
    shown = lively()
    shown.freeze(1024, START)
    shown.pass_by(1)
    assert shown.freeze(2 * CYCLES, START + 2.0 * MOVED) is None
    shown.pass_by(512, START + 2.0 * MOVED)
    assert shown.freeze(2 * CYCLES, START) == 1


def test_what_begins_anew_has_no_past():
    shown = lively()
    shown.freeze(2 * CYCLES, START)
    shown.frozen.begin((START, shown.value), shown.now)
    assert shown.freeze(2 * CYCLES, START + 2.0 * MOVED) is None
    assert shown.frozen.since(1) == shown.now - 2 * TIME


def test_of_several_each_is_looked_at():
    frozen = FrozenMonitors(TIME, MOVED, LEAST)
    frozen.begin((START,) * 3, 0.0)
    now = 0.0
    for cycle in range(1024):
        now += STEP
        assert frozen.find((START + cycle % 2,) * 3, (START,) * 3, now) is None
    for _ in range(2 * CYCLES):
        now += STEP
        found = frozen.find(
            (START + 1.0, now, START + 1.0), (START + 2.0 * MOVED, START, START), now
        )
    assert found == 0


@pytest.mark.parametrize(("value", "is_found"), [(LEAST, False), (LEAST + 1.0, True), (0.0, False)])
def test_an_empty_chamber_may_be_shown_by_one_number_until_air_has_come(value, is_found):
    shown = lively()
    shown.value = value
    assert shown.freeze(1, 0.0) is None
    assert shown.freeze(1024, 0.0) is None
    assert (shown.freeze(1, 2.0 * MOVED) == 1) == is_found
