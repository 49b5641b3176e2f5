"""A pair that starts while it should stand, or is beyond its range."""

import math

import numpy as np
import pytest
from cylinder_rods import Rods
from pneumatic_fakes import BASE
from test_pneumatic_tracking_alarm import ALARM, FOLLOWING, PERIOD, watch

from rig.assembly import REGISTRY
from rig.config import find_configs, load_profile
from rig.mechanisms.pneumatic.alarms.tracking import START, Gone, Shifted, Strayed, TrackingWatch


def stands(places, watched=None):
    """Return what is raised of a rod that should stand and is at these places, m, and when."""
    watched = watched or watch(names=("the pair", "another"))
    for k, place in enumerate(places):
        try:
            watched.check_still((0.0, 0.0), (0.0, place), k * PERIOD)
        except Shifted as fault:
            return k, fault
    return None


@pytest.mark.parametrize("seed", range(12))
def test_what_starts_while_it_should_stand_is_told_before_it_is_a_millimetre_off(seed):
    drawn = np.random.default_rng([33, seed])
    sign, since = float(drawn.choice([-1.0, 1.0])), int(drawn.integers(5, 60))
    pull = float(drawn.uniform(20.0, 90.0))  # m/s2
    noise = drawn.normal(0.0, 2e-6, 200)
    places = [sign * 0.5 * pull * (PERIOD * max(k - since, 0)) ** 2 + noise[k] for k in range(200)]
    k, fault = stands(places)
    assert fault.ran and fault.rod == 1
    assert "way of another in 10 ms while nothing controls it" in str(fault)
    assert abs(places[k - 1]) < 0.51e-3
    assert math.copysign(1.0, fault.value) == sign


def test_a_pair_whose_chambers_are_measured_themselves_may_start():
    """What leaks shows there. Vented, a pair that is pushed flies; held, it is brought back."""
    regulators, valves = (
        load_profile(name, REGISTRY, [], find_configs(None)).mechanism_settings.start
        for name in ("cylinder", "cylinder-valves")
    )
    assert (regulators, valves) == (START, math.inf)
    held = TrackingWatch(("the pair", "another"), FOLLOWING, ALARM, valves)
    run = [0.2 * PERIOD * k for k in range(15)]
    assert stands(run, held) is None
    assert stands(run) is not None


def test_what_creeps_is_no_start_and_an_encoder_that_jumps_is_not_one_either():
    assert stands([0.049 * PERIOD * k for k in range(60)]) is None
    assert stands([0.0] * 30 + [2.9e-3] * 30) is None
    _, fault = stands([0.0] * 30 + [3.1e-3])
    assert not fault.ran


def test_the_bounds_of_a_start_are_allowed_and_what_is_older_is_forgotten():
    start = 0.5e-3
    for sign in (1.0, -1.0):
        ramp = [sign * start * k / 8 for k in range(9)]
        assert stands(ramp) is None
        assert stands([*ramp, math.nextafter(ramp[-1], sign)]) is not None
    for last, seen in ((10, True), (11, False)):  # cycles of 1 ms that it takes
        watched = watch(names=("the pair", "another"))
        places = [1.05 * start * k / last for k in range(last + 1)]
        assert (stands(places, watched) is not None) is seen
    # An encoder that jumps by just six tenths of the way has run.
    assert stands([0.0, 0.6 * 1e-3, 1e-3]) is not None
    assert stands([0.0, 0.61e-3, 1e-3]) is None


@pytest.mark.parametrize("kind", [Shifted, Strayed])
def test_errors_that_say_no_more_are_of_the_first_rod_which_did_not_run(kind):
    error = kind("way of a rod", 1.0, -0.5, 0.5, "m")
    assert (error.rod, error.ran) == (0, False)


def test_what_was_seen_before_a_new_start_is_no_start():
    watched = watch(names=("the pair", "another"))
    assert stands([0.0] * 5, watched) is None
    watched.restart()
    assert stands([0.4e-3, 0.8e-3, 1.2e-3], watched) is not None
    watched.restart()
    assert stands([1.2e-3] * 5, watched) is None


@pytest.mark.parametrize(("apart", "told"), [(0.0, True), (150e3, False)])
def test_a_pair_beyond_its_range_is_told_with_its_chamber_unless_its_pressures_put_it_there(
    apart, told
):
    rods = Rods()
    error = Gone("position of the pair", 21e-3, -20e-3, 20e-3, "m")
    assert rods.watch.explain(error) is error
    for _ in range(40):
        rods.cycle(0.0, 0.0, (BASE + apart, BASE))
    said = rods.watch.explain(error)
    assert ("the chamber of antagonist leaks" in str(said)) is told, said


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_start_that_nothing_else_explains_is_a_leak_or_a_push(sign):
    rods = Rods()
    for _ in range(40):
        rods.cycle(0.0, 0.0)
    error = Shifted.by(0, "way of the pair in 10 ms", sign * 0.6e-3, 0.5e-3, ran=True)
    weak = "antagonist" if sign > 0.0 else "agonist"
    assert f"the chamber of {weak} leaks behind its tube" in str(rods.watch.explain(error))
    slow = Shifted.by(0, "way of the pair", sign * 4e-3, 3e-3)
    assert rods.watch.explain(slow) is slow
