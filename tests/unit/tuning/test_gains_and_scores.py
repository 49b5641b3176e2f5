"""Gains as a search sees them, the plants that they must bear, and what they are worth."""

import math
import random
from collections import Counter
from functools import reduce
from itertools import combinations
from operator import getitem
from typing import get_type_hints

import numpy as np
import pytest

from controllers.cylinder.cascade import Cascade
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.pid import Pid
from controllers.cylinder.pid_friction import PidFriction
from controllers.cylinder.super_twisting import SuperTwisting
from controllers.cylinder.types import PairModel
from controllers.spherical_joint.laws import (
    JointCascade,
    JointPid,
    JointPidFriction,
    JointSuperTwisting,
)
from rig.hal.bench import Trial, Unknown
from rig.hal.closed_loop import ClosedLoop
from rig.mechanisms.pneumatic.cost import reversals_of
from rig.mechanisms.pneumatic.programme import lasting_error
from rig.tuning.ensemble import DRAWN as PLANTS
from rig.tuning.ensemble import Ensemble
from rig.tuning.gains import gains_at, nested, place_of, values_of, with_gains
from rig.tuning.score import LOST, UNSTABLE, score

REVERSAL = 25e3
DRAWN = random.Random(1919)
TOLD = {"force": 10.0, "rate": 40.0, "late": 2e-3, "mass": 0.2}
UNKNOWNS = (
    Unknown("friction", ("force",), "", (0.6, 1.6), (0.9, 1.1), "friction"),
    Unknown("bandwidth", ("rate",), "", (0.67, 1.5), (0.8, 1.2), "response"),
    Unknown("dead time", ("late",), "s", (-3e-3, 3e-3), (-1e-3, 1e-3), "response"),
)


LAWS = (Cascade, Pid, PidFriction, SuperTwisting)
JOINT_LAWS = (JointPid, JointPidFriction, JointCascade, JointSuperTwisting)


@pytest.mark.parametrize("number", range(28))
def test_gains_that_were_put_into_settings_come_out_again(number):
    law = (*LAWS, *JOINT_LAWS)[number % 8]
    rng = np.random.default_rng([77, number])
    place = rng.uniform(0.0, 1.0, len(law.tunables)).tolist()
    gains = gains_at(law.tunables, place)
    settings = with_gains(law.Settings(), gains)
    assert values_of(law.tunables, settings) == gains
    assert place_of(law.tunables, settings) == pytest.approx(place, abs=1e-3)
    for tunable in law.tunables:
        assert tunable.low * 0.999 <= gains[tunable.key] <= tunable.high * 1.001
    again = nested(gains)
    for key, gain in gains.items():
        assert reduce(getitem, key.split("."), again) == gain


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_a_search_and_a_person_stay_within_what_a_profile_may_say(law):
    """Both ends of every gain pass the bounds of the setting, and a law can be made of them."""
    model = PairModel(1.8e-4, 0.138, 0.12e6, 0.0, 0.5e6, 40.0, 1.0, 6.5, 6.7, 3e-3, 30.0)
    for gain in (*law.tunables, *law.online):
        for value in (gain.low, gain.high):
            settings = with_gains(law.Settings(), {gain.key: value})
            owner, name = settings, gain.key
            if "." in name:
                part, name = name.split(".")
                owner = getattr(settings, part)
            kind = get_type_hints(type(owner), include_extras=True)[name]
            for bound in kind.__metadata__:
                if hasattr(bound, "gt"):
                    assert value > bound.gt, gain
                for side, holds in (("ge", value.__ge__), ("le", value.__le__)):
                    if hasattr(bound, side):
                        assert holds(getattr(bound, side)), gain
            law(settings, model, 1e-3)


def test_what_no_search_may_change_of_a_law_stays():
    settings = CascadeSettings(pressure_floor=31e3, trim_rate=1.25)
    changed = with_gains(settings, {"integral": 5.0, "feedforward.gain": 0.5})
    assert (changed.pressure_floor, changed.trim_rate) == (31e3, 1.25)
    assert changed.feedforward.friction == settings.feedforward.friction
    assert (changed.integral, changed.feedforward.gain) == (5.0, 0.5)


def test_an_ensemble_goes_to_its_bounds_and_never_beyond():
    ensemble = Ensemble(TOLD, UNKNOWNS, (), 3)
    corners = ensemble.corners()
    assert len(corners) == 28
    assert corners[0].numbers == corners[-1].numbers == TOLD
    assert [member.noisy for member in corners] == [False] * 27 + [True]
    assert corners[0].name == ""
    assert {m.numbers["force"] for m in corners} == {6.0, 10.0, 16.0}
    assert min(m.numbers["late"] for m in corners) == 0.0, "no dead time is negative"
    drawn = ensemble.draw(300)
    for name, (low, high) in {"force": (9, 11), "rate": (32, 48), "late": (1e-3, 3e-3)}.items():
        values = [member.numbers[name] for member in drawn]
        assert low <= min(values) < max(values) <= high
        assert np.ptp(values) > 0.9 * (high - low)
    assert {member.numbers["mass"] for member in (*corners, *drawn)} == {0.2}
    near = ensemble.near()
    assert (len(near), near[0].numbers) == (9, TOLD)
    assert {m.numbers["rate"] for m in near} == {32.0, 40.0, 48.0}
    assert [m.numbers for m in ensemble.draw(300)] == [m.numbers for m in drawn]


def test_every_drawn_plant_is_a_unit_that_no_corner_is():
    ensemble = Ensemble(TOLD, UNKNOWNS, (), 3)
    parts = [ensemble.draw(part=part) for part in range(4)]
    seeds = {unit.seed for part in parts for unit in part}
    assert len(seeds) == 4 * PLANTS
    assert len({unit.numbers["force"] for part in parts for unit in part}) == 4 * PLANTS
    assert [ensemble.drawn(number) for number in (3, 2 * PLANTS + 7)] == [parts[0][3], parts[2][7]]
    assert not seeds & {m.seed for m in ensemble.corners()}


def test_what_was_measured_varies_less_and_nothing_else():
    ensemble = Ensemble(TOLD, UNKNOWNS, ("response",), 3)
    assert ensemble.bounds == {
        "friction": (0.6, 1.6), "bandwidth": (0.8, 1.2), "dead time": (-1e-3, 1e-3),
    }  # fmt: skip


def test_the_first_corners_have_every_pair_of_extremes_once():
    ensemble = Ensemble(TOLD, UNKNOWNS, (), 3)
    *corners, noisy = [ensemble.corners()[number] for number in ensemble.first()[1:]]
    assert len(corners) == 4
    assert noisy.noisy
    for one, other in combinations(("force", "rate", "late"), 2):
        met = Counter((m.numbers[one], m.numbers[other]) for m in corners)
        assert set(met.values()) == {1}


def trial(error=1e-3, hunting=0.0, reversals=0.0, strayed=0.5, lasted=1.0):
    return Trial({"slow": error, "fast": 2 * error}, hunting, reversals, strayed, lasted)


STABLE = ClosedLoop(True, 50.0, 1.0, 0.01, 1.4)


@pytest.mark.parametrize("seed", range(10))
def test_less_error_less_hunting_and_more_margin_are_never_worse(seed):
    rng = np.random.default_rng([5, seed])
    error, hunting, reversals = rng.uniform([1e-4, 0, 0], [1e-3, 1e-3, 60])
    sensitivity = rng.uniform(1.2, 3.0)
    here = score([trial(error, hunting, reversals)] * 2, [STABLE._replace(sensitivity=sensitivity)])
    for better in (
        score([trial(0.9 * error, hunting, reversals)] * 2,
              [STABLE._replace(sensitivity=sensitivity)]),
        score([trial(error, 0.9 * hunting, reversals)] * 2,
              [STABLE._replace(sensitivity=sensitivity)]),
        score([trial(error, hunting, 0.9 * reversals)] * 2,
              [STABLE._replace(sensitivity=sensitivity)]),
        score([trial(error, hunting, reversals)] * 2,
              [STABLE._replace(sensitivity=0.95 * sensitivity)]),
    ):  # fmt: skip
        assert better.cost <= here.cost


def test_ten_times_the_error_costs_the_same_more_on_any_rig():
    at = [score([trial(error)] * 3, [STABLE]).cost for error in (1e-5, 1e-4, 1e-3)]
    assert at[1] - at[0] == pytest.approx(at[2] - at[1])


def test_a_margin_that_is_missed_costs_by_its_ratio_and_one_that_is_kept_nothing():
    at = {
        near: score([trial()], [STABLE, STABLE._replace(sensitivity=near)]).cost
        for near in (1.0, 1.6, 2.0, 2.4, math.inf)
    }
    assert at[1.0] == at[1.6] < at[2.0] < at[2.4] < at[math.inf] < LOST
    assert at[2.4] - at[2.0] == pytest.approx(20.0 * math.log(1.2))


@pytest.mark.parametrize("share", [0.9, 0.7, 0.6])
def test_a_third_less_error_buys_no_gains_that_are_beyond_the_margin(share):
    """Drawn plants scatter about the few that were shaken: most of them would be beyond it."""
    kept = score([trial()] * 8, [STABLE._replace(sensitivity=1.69)]).cost
    assert kept < score([trial(share * 1e-3)] * 8, [STABLE._replace(sensitivity=1.75)]).cost


def test_one_plant_of_thirty_that_hunts_is_not_hidden_by_the_others():
    quiet, bolder = [trial()] * 30, [trial(0.7e-3)] * 29
    assert score(quiet, [STABLE]).cost < score([*bolder, trial(0.7e-3, 1.5e-3)], [STABLE]).cost


def test_gains_that_lose_a_plant_or_are_not_stable_are_behind_all_others():
    bad = score([trial(1.0, 1.0, 500.0)], [STABLE._replace(sensitivity=9.0)]).cost
    assert bad < LOST <= score([trial(), trial(lasted=0.5)], [STABLE]).cost < UNSTABLE
    assert score([trial()], [STABLE._replace(stable=False)]).cost >= UNSTABLE


def turned_round(values):
    """Count turns of a `REVERSAL` and more from extreme to extreme: slow, plain."""
    moved = [
        k for k in range(len(values)) if max(values[: k + 1]) - min(values[: k + 1]) > REVERSAL
    ]
    if not moved:
        return 0
    start = moved[0]  # where it went first is no turn yet
    direction = 1 if values[start] == max(values[: start + 1]) else -1
    count, best = 0, values[start]
    for value in values[start:]:
        best = max(best, value) if direction > 0 else min(best, value)
        if direction * (best - value) > REVERSAL:
            count, direction, best = count + 1, -direction, value
    return count


@pytest.mark.parametrize("number", range(12))
def test_reversals_are_those_that_a_plain_count_finds(number):
    rng = np.random.default_rng([9, number])
    walk = np.cumsum(rng.normal(0, DRAWN.uniform(1e3, 20e3), 3000))
    values = np.round(walk / 500) * 500 if number % 2 else walk
    assert reversals_of(values) == turned_round(values.tolist())


@pytest.mark.parametrize("number", range(8))
def test_an_error_lasts_as_long_as_a_plain_count_says(number):
    rng = np.random.default_rng([10, number])
    errors = np.cumsum(rng.normal(0, 1e-4, 800))
    cycles = int(rng.integers(2, 301))
    lasting = lasting_error(errors, cycles)
    runs = [np.abs(errors[k : k + cycles]).min() for k in range(len(errors) - cycles + 1)]
    assert lasting == max(runs)


def test_a_setpoint_that_never_moves_never_turns_round():
    assert reversals_of(np.full(100, 1.2e5)) == 0
    assert reversals_of(np.linspace(0, 3e5, 100)) == 0


def test_the_ranges_of_an_ensemble_carry_their_units():
    unknowns = (
        Unknown("friction", ("coulomb",), "", (0.6, 1.6), (0.9, 1.1), "friction"),
        Unknown("dead time", ("dead_time",), "s", (-3e-3, 3e-3), (-1e-3, 1e-3), "response"),
        Unknown("load", ("mass",), "kg", (0.0, 2.5), (0.0, 0.1), "mass"),
    )
    ensemble = Ensemble({"coulomb": 1, "dead_time": 0, "mass": 1}, unknowns, {"response"}, 0)
    assert ensemble.ranges() == {
        "friction": "x 0.6 to x 1.6", "dead time": "-1 ms to +1 ms", "load": "+0 kg to +2.5 kg",
    }  # fmt: skip
