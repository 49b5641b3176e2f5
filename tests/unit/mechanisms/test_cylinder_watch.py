"""What the two rods of a pair show: agreement, a frozen one, a run, a push, a mirrored one."""

import math

import numpy as np
import pytest
from pneumatic_fakes import (
    BASE,
    HOME,
    MISMATCH,
    PERIOD,
    REACH,
    SPEED,
    TINY,
    PairBench,
    pair_limits,
    pair_settings,
)

from controllers.cylinder.types import PairState
from rig.hal import DeviceFault, LimitExceeded, SafetyError
from rig.mechanisms.cylinder.settings import PairAlarmSettings, RodsAlarm
from rig.mechanisms.cylinder.watch import PairWatch
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm, SwappedAlarm
from rig.mechanisms.pneumatic.alarms.tracking import Strayed
from rig.mechanisms.pneumatic.valves.settings import ValvesSettings

NAMES = "encoder-agonist", "encoder-antagonist"
CHANGE = 2.0**-12
WIDE = 2.0**-5
"""A mismatch that no test here reaches."""
NEVER = FrozenAlarm(WIDE, 1e6)


class Rods:
    """The watch of a pair of which a test says where each rod is, from home, m."""

    def __init__(self, change=WIDE, mismatch=WIDE, frozen=NEVER, swapped=WIDE, **settings):
        alarms = PairAlarmSettings(
            frozen=frozen, rods=RodsAlarm(change), swapped=SwappedAlarm(distance=swapped)
        )
        limits = pair_limits(mismatch=mismatch, speed=SPEED)
        self.settings = pair_settings(limits, alarms=alarms, **settings)
        self.watch = PairWatch(self.settings, "regulators", NAMES)
        self.now = 0.0

    def cycle(self, agonist, antagonist, pressures=(BASE, BASE), step=PERIOD):
        self.now += step
        state = PairState(self.now, 0.0, *pressures)  # its speed is another test's
        self.watch.check(state, (HOME + agonist, HOME + antagonist), self.now)

    def settle(self, pressures=(BASE, BASE)):
        """Let the wires be taut for long enough that the rods' agreement is the usual one."""
        for _ in range(128):
            self.cycle(0.0, 0.0, pressures)


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
        "drifts or has a wrong scale)"
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


# A wire that lets go --------------------------------------------------------------------------

FAST = LimitExceeded("speed of the pair", 1.0, -SPEED, SPEED, "m/s")
WAY = 0.3 * SPEED * PERIOD * 2.0 * (1.0 + 1e-9)
"""By so much a rod runs in, in the last cycles."""


def run(*ways, before=9, pressures=(BASE, BASE)):
    """Return what is said of rods that stood, and ran in by this much (m) in the last cycle."""
    rods = Rods()
    for _ in range(before - 1):
        rods.cycle(0.0, 0.0)  # what counts is the pull now
    rods.cycle(*(-way for way in ways), pressures)
    return rods.watch.explain(FAST)


def test_rods_that_both_run_in_have_lost_a_wire():
    assert str(run(WAY, 0.5 * WAY)) == (
        f"the wire of agonist is slack or cut: its rod runs in ({FAST})"
    )
    assert "wire of antagonist" in str(run(0.5 * WAY, WAY))
    assert run(WAY * (1.0 - 2e-9), 0.5 * WAY) is FAST
    assert run(WAY, 0.0999 * WAY) is FAST
    assert "wire of agonist" in str(run(WAY, 0.1001 * WAY))
    assert run(WAY, -WAY) is FAST


def test_a_run_shows_after_nine_readings():
    assert run(WAY, WAY, before=8) is FAST
    assert run(WAY, WAY, before=9) is not FAST


def test_the_wire_is_that_of_the_rod_that_runs_faster_for_its_pull():
    area, sliding = pair_settings().area, 0.5 * pair_settings().friction.coulomb
    pulls = 3.0 * sliding, 2.0 * sliding  # two and one of it are left
    pressures = tuple(pull / area for pull in pulls)
    assert "wire of agonist" in str(run(2.1 * WAY, WAY, pressures=pressures))
    assert "wire of antagonist" in str(run(1.9 * WAY, WAY, pressures=pressures))
    # A chamber that cannot move its rod counts as a newton.
    weak = (sliding + 3.0) / area, 0.5 * sliding / area
    assert "wire of agonist" in str(run(3.1 * WAY, WAY, pressures=weak))
    assert "wire of antagonist" in str(run(2.9 * WAY, WAY, pressures=weak))


@pytest.mark.parametrize("seed", range(4))
def test_a_run_is_what_the_last_four_cycles_added_to_the_four_before(seed):
    rng = np.random.default_rng(seed)
    told = 0
    for _ in range(100):
        rods = Rods()
        places = np.cumsum(rng.uniform(-0.9, 0.4, (14, 2)), axis=0) * WAY
        for place in places:
            rods.cycle(*place)
        ways = (places[-5] - places[-1]) - (places[-9] - places[-5])
        runs = ways.max() >= WAY and ways.min() >= 0.1 * ways.max()
        said = rods.watch.explain(FAST)
        assert ("slack or cut" in str(said)) == runs
        if runs:
            told += 1
            assert f"wire of {('agonist', 'antagonist')[int(np.argmax(ways))]} " in str(said)
    assert 5 < told < 95


# A cause that the rest of the pair shows ------------------------------------------------------


def suspicious(*ways, **settings):
    """Return rods of which a pressure has just begun to be off, and that moved by this much."""
    rods = Rods(**settings)
    rods.watch.send((BASE, BASE))
    rods.cycle(0.0, 0.0)
    rods.cycle(0.0, 0.0)
    rods.cycle(*ways, pressures=(BASE, BASE - 0.6 * most_off(rods)))
    return rods


def most_off(rods):
    return rods.watch._pressures._bounds.deviation


def test_a_limit_that_is_passed_has_the_suspicion_of_a_regulator():
    said = suspicious(0.0, 0.0).watch.explain(FAST)
    assert isinstance(said, SafetyError)
    assert str(said).startswith("regulators: the regulator of antagonist is stuck")
    assert str(said).endswith(f" ({FAST})")


def test_what_feeds_a_chamber_may_be_a_valve():
    rods = suspicious(0.0, 0.0, valves=ValvesSettings())
    said = str(rods.watch.explain(FAST))
    assert said.startswith("regulators: the valve of antagonist is stuck")


def test_a_limit_that_was_explained_already_is_left_alone():
    rods = suspicious(0.0, 0.0)
    with pytest.raises(LimitExceeded) as caught:
        rods.cycle(2 * WIDE, 2 * WIDE, (BASE, BASE - 0.6 * most_off(rods)))
    assert rods.watch.explain(caught.value) is caught.value


def test_an_encoder_that_jumps_where_its_rod_ran_is_explained():
    ran = 0.3 * SPEED * PERIOD
    jumps = [DeviceFault(name, "it jumps") for name in NAMES]
    for way, explained in ((ran + TINY, True), (ran - TINY, False)):
        for sign in (1.0, -1.0):
            rods = suspicious(sign * way, 0.0)
            said = rods.watch.explain(jumps[0])
            assert (str(said).startswith("regulators: ")) is explained
            assert rods.watch.explain(jumps[1]) is jumps[1]  # its own stood
    other = DeviceFault("regulators", "it is gone")
    rods = suspicious(2 * ran, 2 * ran)
    assert rods.watch.explain(other) is other
    assert rods.watch.explain(ValueError("no")).args == ("no",)
    fresh = Rods()
    fresh.cycle(0.0, 0.0)
    assert fresh.watch.explain(jumps[0]) is jumps[0]


def test_a_wire_comes_before_a_regulator_and_a_regulator_before_a_push():
    jump = DeviceFault(NAMES[0], "it jumps")
    rods = suspicious(0.0, 0.0)
    low = (BASE, BASE - 0.6 * most_off(rods))
    for _ in range(9):
        rods.cycle(0.0, 0.0, low)
    assert rods.watch.explain(FAST) is not FAST
    rods.cycle(-WAY, -WAY, low)
    for error in (jump, FAST):
        assert "is slack or cut: its rod runs in" in str(rods.watch.explain(error))
    rods = suspicious(WAY, -WAY)
    assert str(rods.watch.explain(jump)).startswith("regulators: ")


def test_a_push_pulls_one_rod_out_and_the_other_runs_in_by_a_tenth():
    jump = DeviceFault(NAMES[0], "it jumps")
    for other, is_push in ((0.1, True), (0.1 - 1e-9, False)):
        rods = Rods()
        for _ in range(4):
            rods.cycle(0.0, 0.0)
        rods.cycle(WAY, -other * WAY)
        assert (rods.watch.explain(jump) is not jump) is is_push
    rods.cycle(WAY, -2.0 * WAY)
    assert rods.watch._explain_push(0) is None  # its rod stood


# An encoder that goes against the pull --------------------------------------------------------


def against(places, pulls, changes, least):
    """Return which rod goes against the pull, from its history alone."""
    small = np.flatnonzero(np.abs(changes[:-1]) < 0.2 * CHANGE)
    since = small[-1] if len(small) else 0
    moved = np.diff(places[since:], axis=0) * (-1.0, 1.0)
    pull = (pulls[since + 1 :, 0] - pulls[since + 1 :, 1])[:, None]
    work, way = (pull * moved).sum(axis=0), np.abs(moved).sum(axis=0)
    for k in range(2):
        if work[k] < -least * way[k] and work[1 - k] > least * way[1 - k]:
            return k
    return None


@pytest.mark.parametrize("seed", range(4))
def test_the_encoder_that_goes_against_the_pull_is_named(seed):
    """Drawn ways of both rods and drawn pressures, until the rods no longer agree."""
    rng = np.random.default_rng(seed)
    found = {0: 0, 1: 0, None: 0}
    for _ in range(80):
        rods = Rods(change=CHANGE)
        rods.settle()
        area, least = rods.settings.area, 0.25 * 10.0  # a quarter of Coulomb friction
        drift = rng.uniform(-0.15, 0.15) * CHANGE
        both = rng.uniform(-0.2, 0.2) * CHANGE
        noise = rng.uniform(0.0, 0.3) * CHANGE
        bias = rng.uniform(-1.0, 1.0) * 2.0 * least / area
        places, pressures, place = [np.zeros(2)], [np.full(2, BASE)], np.zeros(2)
        for _ in range(200):
            place = place + drift + both * np.array([-1.0, 1.0]) + rng.normal(0.0, noise, 2)
            spread = bias + rng.normal(0.0, 0.1) * least / area
            pressure = BASE + 0.5 * spread * np.array([1.0, -1.0])
            places.append(place)
            pressures.append(pressure)
            try:
                rods.cycle(*place, tuple(pressure))
            except LimitExceeded as error:
                said = error.quantity
                break
        else:
            continue
        if "is slack or cut" in said or np.abs(place).max() > REACH:
            continue
        changes = np.array([step.change for step in rods.watch._history][-len(places) :])
        k = against(np.array(places), np.array(pressures) * area, changes, least)
        found[k] += 1
        if k is None:
            assert "drifts or has a wrong scale" in said
        else:
            assert f"({NAMES[k]} is mirrored or drifts: it goes against the pull)" in said
    assert found[None] > 1
    assert found[0] + found[1] > 1


def test_a_quarter_of_a_second_is_remembered():
    rods = Rods()
    for _ in range(300):
        rods.cycle(0.0, 0.0)
    assert len(rods.watch._history) == 256


@pytest.mark.parametrize("turned", [1.0, -1.0])
@pytest.mark.parametrize("seed", range(3))
def test_rods_that_move_against_their_pull_are_swapped(seed, turned):
    """By a quarter of the friction's work over a millimetre, of both rods together."""
    rng = np.random.default_rng(seed)
    rods, work, gone = Rods(swapped=1e-3), 0.0, 0.0
    ways = np.array([-1.0, rng.uniform(0.8, 1.2)]) * 2.0**-15 * turned
    pressures = np.array([60e3, 150e3])[:: int(turned)]
    place = np.zeros(2)
    rods.cycle(*place, tuple(pressures))
    with pytest.raises(SafetyError, match="are swapped") as caught:
        for _ in range(100):
            place = place + ways
            moved = 0.5 * (ways[1] - ways[0])
            work += float(pressures[0] - pressures[1]) * rods.settings.area * moved
            gone += 0.5 * float(np.abs(ways).sum())
            rods.cycle(*place, tuple(pressures))
    said = f"[work {work * 1e3:.1f} mJ over {gone * 1e3:.2f} mm, "
    assert said in str(caught.value)


def test_what_has_drifted_for_longer_than_is_remembered_is_judged_by_what_is():
    rods = Rods(change=CHANGE)
    rods.settle()
    for _ in range(300):
        rods.cycle(0.5 * CHANGE, 0.5 * CHANGE)
    with pytest.raises(LimitExceeded, match="drifts or has a wrong scale"):
        rods.cycle(1.5 * CHANGE, 1.5 * CHANGE)


def test_the_speed_starts_anew_after_a_restart():
    """And is judged by the position, both ways."""
    watch = Rods().watch
    for k, position in enumerate((0.0, REACH, -REACH)):
        watch.restart()
        state = PairState(0.1 * k, position, BASE, BASE)
        watch.check(state, (HOME, HOME), 0.1 * k)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("k", [0, 1])
def test_rods_that_disagree_when_they_are_first_read_are_a_fault(k, way):
    bench = PairBench()
    off = [0.0, 0.0]
    off[k] = way * 2.1 * MISMATCH
    bench.place(*off)
    with pytest.raises(LimitExceeded, match="mismatch of the two rods"):
        bench.cycle(0.0)


# A pull that no monitor shows -------------------------------------------------------------------


def pulled(cycles, apart=400e3):
    """Return rods that stand still under a pull that no seal could hold."""
    rods = Rods()
    rods.settle()
    for _ in range(cycles):
        rods.cycle(0.0, 0.0, (BASE + apart, BASE))
    return rods


def test_a_pair_that_should_move_and_sticks_is_told_with_its_chamber():
    told = pulled(32).watch.explain_held()
    assert "the chamber of agonist leaks behind its tube" in told
    assert "the carriage is pushed or held" in told
    assert pulled(32, 0.0).watch.explain_held() is None


@pytest.mark.parametrize("off", [5e-3, -5e-3])
def test_a_pair_that_strays_from_its_reference_is_told_with_the_chamber_that_should_pull_it(off):
    error = Strayed("following error of the pair for 0.3 s", off, -3e-3, 3e-3, "m")
    apart = math.copysign(150e3, -off)  # 27 N: less than seals may hold, more than they take
    said = str(pulled(32, apart).watch.explain(error))
    weak = "antagonist" if off > 0.0 else "agonist"
    assert said.startswith(f"regulators: the chamber of {weak} leaks behind its tube")
    assert said.endswith(f"N pull it back ({error})")
    assert pulled(32, -apart).watch.explain(error) is error
    other = LimitExceeded("position of the pair", off, -3e-3, 3e-3, "m")
    assert pulled(32, apart).watch.explain(other) is other


def test_a_pair_that_slides_is_not_held_whatever_its_monitors_say():
    rods = pulled(0)
    for k in range(32):
        way = 1e-4 * k
        rods.cycle(-way, way)
    assert rods.watch._balance.explain() is not None
    assert rods.watch.explain_held() is None


def test_what_held_it_before_a_new_start_is_forgotten():
    rods = pulled(32)
    rods.watch.restart()
    assert rods.watch.explain_held() is None
