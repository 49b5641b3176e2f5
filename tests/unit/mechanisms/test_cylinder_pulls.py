"""Why a pair is where it should not be: a chamber that pulls less than its monitor says."""

import math

import numpy as np
import pytest
from cylinder_rods import Rods
from pneumatic_fakes import BASE, PERIOD, pair_settings

from rig.hal import LimitExceeded
from rig.mechanisms.pneumatic.alarms.balance import UNSTABLE
from rig.mechanisms.pneumatic.alarms.tracking import Gone, Shifted, Strayed

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
    gone = Strayed("following error that its own motion brought about", off, -6e-3, 6e-3, "m")
    gone.ran = True  # whatever its pressures say: nothing that lags behind goes away
    for pull in (-apart, 0.0):
        said = str(pulled(32, pull).watch.explain(gone))
        assert said.startswith(f"regulators: the chamber of {weak} leaks behind its tube")
        assert said.endswith(f"{UNSTABLE} ({gone})")
        assert "or the carriage is pushed or held; " in said
    other = LimitExceeded("position of the pair", off, -3e-3, 3e-3, "m")
    assert pulled(32, apart).watch.explain(other) is other


@pytest.mark.parametrize(("sign", "weak"), [(1.0, "antagonist"), (-1.0, "agonist")])
def test_a_pair_that_lags_after_it_crept_against_its_pull_has_lost_air(sign, weak):
    off = -sign * 4e-3
    error = Strayed("following error of the pair for 0.3 s", off, -3e-3, 3e-3, "m")
    for pull, crept in ((-60e3, True), (60e3, False)):
        rods = Rods()
        for way in np.linspace(0.0, 0.6e-3, 13):
            place = sign * way
            rods.cycle(-place, place, (BASE + sign * pull, BASE), step=0.1)
        said = str(rods.watch.explain(error))
        assert said.startswith(f"regulators: the chamber of {weak} leaks") is crept, said


@pytest.mark.usefixtures("moved_by_hand")
def test_a_pair_that_slides_is_not_held_whatever_its_monitors_say():
    rods = pulled(0)
    for k in range(32):
        way = 0.9e-4 * k
        rods.cycle(-way, way)
    assert rods.watch._balance.explain() is not None
    assert rods.watch.explain_held() is None


def test_what_held_it_before_a_new_start_is_forgotten():
    rods = pulled(32)
    rods.watch.restart()
    assert rods.watch.explain_held() is None


# A way while the chambers fill ------------------------------------------------------------------


def filled(*pressures):
    """Return what is said of a pair that moved while its chambers had got so far, and the error."""
    rods = Rods()
    for earlier in (BASE, BASE, 0.0, BASE):
        rods.cycle(0.0, 0.0, (earlier, earlier))
    rods.cycle(0.0, 0.0, pressures)
    error = Shifted("way of the pair while nothing controls it", 4.1e-3, -4e-3, 4e-3, "m")
    return rods, error


@pytest.mark.parametrize("slow", [0, 1])
def test_a_pair_that_moves_while_it_fills_is_told_with_the_chamber_that_has_less(slow):
    names = ("agonist", "antagonist")
    pressures = (3e3, 40e3) if slow == 0 else (40e3, 3e3)
    rods, error = filled(*pressures)
    assert str(rods.watch.explain(error)) == (
        f"regulators: the regulator of {names[slow]} is stuck, slow or off: its chamber has 3 kPa "
        f"while both fill, and that of {names[1 - slow]} 40 kPa ({error})"
    )
    other = LimitExceeded("position of the pair", 21e-3, -20e-3, 20e-3, "m")
    assert rods.watch.explain(other) is other, "it is controlled then"


@pytest.mark.parametrize("slow", [0, 1])
def test_chambers_that_differ_by_less_than_half_of_what_seals_take_moved_nothing(slow):
    half = 0.5 * pair_settings().friction.coulomb / pair_settings().area
    for apart, is_told in ((half * (1.0 - 1e-9), False), (half * (1.0 + 1e-9), True)):
        rods, error = filled(*((20e3, 20e3 + apart) if slow == 0 else (20e3 + apart, 20e3)))
        assert (rods.watch.explain(error) is not error) is is_told
    pulls = rods.watch._history[-1].pulls
    rods.watch._sliding = abs(pulls[1] - pulls[0])
    assert rods.watch.explain(error) is not error, "just so much may move it"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_pair_is_driven_to_where_its_pressures_pull_it(sign):
    watch = pulled(32, sign * 150e3).watch
    assert watch.drives(0, sign * 5e-3)
    assert not watch.drives(0, -sign * 5e-3)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("speed", [0.0, 0.2])
def test_a_pair_that_is_gone_was_let_go_by_a_chamber_if_it_ran_or_nothing_drove_it(side, speed):
    """Its own pressures pull it out: only what has run at once has another cause."""
    gone = Gone("position of the pair", side * 20.1e-3, -20e-3, 20e-3, "m")
    rods = Rods()
    for k in range(40):
        place = side * speed * k * PERIOD
        rods.cycle(-place, place, (BASE + side * 80e3, BASE))
    said = rods.watch.explain(gone)
    weak = "antagonist" if side > 0.0 else "agonist"
    assert str(said).startswith(f"regulators: the chamber of {weak} leaks") is (speed > 0.0)
    rods.watch.restart()
    assert rods.watch.explain(gone) is gone, "nothing is known"
