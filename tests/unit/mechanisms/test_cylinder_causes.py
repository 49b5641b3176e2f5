"""Why the rods of a pair do what they do: a wire, a push, a mirrored encoder."""

import numpy as np
import pytest
from cylinder_rods import CHANGE, NAMES, WIDE, Rods
from pneumatic_fakes import (
    BASE,
    HOME,
    MISMATCH,
    PERIOD,
    REACH,
    SPEED,
    TINY,
    PairBench,
    pair_settings,
)

from controllers.cylinder.types import PairState
from rig.hal import DeviceFault, LimitExceeded, SafetyError
from rig.mechanisms.pneumatic.alarms.pressures import PressureOff
from rig.mechanisms.pneumatic.valves.settings import ValvesSettings

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


@pytest.mark.parametrize("channel", [0, 1])
@pytest.mark.parametrize(("out", "told"), [(20.1e-6, True), (19.9e-6, False)])
def test_friction_brakes_a_rod_that_ran_out_with_its_chamber(channel, out, told):
    """The wire of a strong chamber is cut as it draws the weak one's rod out: that turns round."""
    area, sliding = pair_settings().area, 0.5 * pair_settings().friction.coulomb
    pulls = [5.0 * sliding, 2.0 * sliding]  # four and one of it are left, or two on the way out
    ways = [np.repeat(-out, 13), np.repeat(out, 13)]
    ways[0][-2:] -= (1.4 * WAY, 1.4 * WAY)
    ways[1][-2:] -= (0.5 * WAY, 0.5 * WAY)
    if channel:
        pulls, ways = pulls[::-1], ways[::-1]
    rods = Rods()
    for places in zip(*(np.cumsum(way) for way in ways), strict=True):
        rods.cycle(*places, tuple(pull / area for pull in pulls))
    names = "agonist", "antagonist"
    assert f"wire of {names[channel if told else 1 - channel]} is" in str(rods.watch.explain(FAST))


@pytest.mark.parametrize("seed", range(4))
def test_a_run_is_what_the_last_four_cycles_added_to_the_four_before(seed):
    rng = np.random.default_rng(seed)
    area, sliding = pair_settings().area, 0.5 * pair_settings().friction.coulomb
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
            out = (np.diff(places[-5:], axis=0) > 20e-6).sum(axis=0)
            gains = ways / (area * BASE - sliding * (1.0 - 0.5 * out))
            assert f"wire of {('agonist', 'antagonist')[int(np.argmax(gains))]} " in str(said)
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
    return rods.watch.pressures._bounds.deviation


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


def test_a_pressure_that_is_off_while_an_encoder_scatters_has_that_for_its_cause():
    rods = Rods()
    for k in range(32):
        rods.cycle(0.0, TINY * (-1.0) ** k)
    off = PressureOff("regulators: the supply pressure is lost")
    assert rods.watch.explain(off) is off
    for k in range(64):
        rods.cycle(0.0, 50e-6 * (-1.0) ** k)
    said = rods.watch.explain(off)
    assert str(said) == f"{NAMES[1]} scatters by 0.082 mm, which shakes setpoints ({off})"
    other = SafetyError("something else")
    assert rods.watch.explain(other) is other


@pytest.mark.parametrize("name", NAMES)
def test_a_rod_that_nobody_has_seen_before_may_have_been_drawn_out_by_a_push(name):
    """Empty chambers hold nothing, and the other rod stays where it is: its wire gets slack."""
    jump = DeviceFault(name, "it jumps", value="+0.001445 m", bound="0.001 m")
    said = Rods().watch.explain(jump)
    assert isinstance(said, SafetyError)
    assert str(said) == (
        f"{name} is wrong, or the carriage was pushed or struck while empty chambers held it "
        f"({jump})"
    )
    seen = Rods()
    seen.cycle(0.0, 0.0)
    assert seen.watch.explain(jump) is jump
    other = DeviceFault("regulators", "it is gone", bound="1 s")
    for error in (DeviceFault(name, "it reports an alarm"), other, FAST):
        assert Rods().watch.explain(error) is error


def test_an_encoder_that_jumps_where_its_rod_ran_is_explained():
    ran = 0.3 * SPEED * PERIOD
    jumps = [DeviceFault(name, "it jumps") for name in NAMES]
    for way, explained in ((ran + TINY, True), (ran - TINY, False)):
        for sign in (1.0, -1.0):
            rods = suspicious(sign * way, 0.0)
            said = rods.watch.explain(jumps[0])
            assert (str(said).startswith("regulators: ")) is explained
            assert rods.watch.explain(jumps[1]) is jumps[1]  # its own stood
    assert Rods().watch.explain(jumps[0]) is jumps[0]  # nothing was read before
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


@pytest.mark.parametrize("jumped", [0, 1])
def test_a_push_is_seen_by_either_rod(jumped):
    """The chamber behind the one that runs in may be quicker than the wire of the other."""
    rods = Rods()
    for _ in range(4):
        rods.cycle(0.0, 0.0)
    rods.cycle(WAY, -WAY)
    said = str(rods.watch.explain(DeviceFault(NAMES[jumped], "it jumps")))
    assert said.startswith("the carriage was pushed or struck: it pulls the rod of agonist out")


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


def pushed(places):
    """Return whether a rod has run out for three cycles while the other one ran in."""
    steps = np.diff(places[-4:], axis=0)
    for k in range(2):
        goes = len(steps) == 3 and (steps[:, k] > 0.0).all() and (steps[:, 1 - k] < 0.0).all()
        if goes and steps[-1, k] > 0.3 * SPEED * PERIOD:
            return -steps[-1, 1 - k] >= 0.1 * steps[-1, k]
    return False


@pytest.mark.parametrize("pulled", range(2))
@pytest.mark.parametrize("cycles", [2, 3])
@pytest.mark.parametrize("size", [0.99, 1.01])
def test_a_blow_makes_rods_disagree_before_a_wire_has_passed_it_on(pulled, cycles, size):
    """One rod runs out cycle after cycle, and the other one in."""
    rods = Rods(change=CHANGE)
    rods.settle()
    out = size * 0.3 * SPEED * PERIOD
    ways = [-out, -out]
    ways[pulled] = out
    place = np.zeros(2)
    for _ in range(cycles):
        place = place + ways
        rods.cycle(*place)
    said = rods.watch._explain_blow()
    is_told = cycles == 3 and size > 1.0
    rod = ("agonist", "antagonist")[pulled]
    told = f"the carriage was pushed or struck: it pulls the rod of {rod} out"
    assert said == (told if is_told else None)


@pytest.mark.parametrize("stands", range(2))
def test_a_rod_that_stood_for_a_cycle_was_not_blown_along(stands):
    out = 0.4 * SPEED * PERIOD
    rods = Rods(change=CHANGE)
    rods.settle()
    places = np.array([[1.0, -1.0], [2.0, -2.0], [3.0, -3.0]]) * out
    places[1, stands] = places[0, stands]
    for place in places:
        rods.cycle(*place)
    assert rods.watch._explain_blow() is None


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.usefixtures("moved_by_hand")
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
            blow = pushed(np.array(places))
            assert ("the carriage was pushed" if blow else "drifts or has a wrong scale") in said
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
