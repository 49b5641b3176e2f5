"""Which wire or encoder is blamed when the rods do not agree, and in which words."""

import math

import numpy as np
import pytest
from joint_fakes import BASE, UPRIGHT, WireBench, off, residual_of, rods_at

from rig.hal import SafetyError

TILTED = rods_at(0.3, 0.4)
FAR = rods_at(0.8, 0.4)
NEAR = rods_at(0.02, 0.4)
OPPOSITE = {1: 3, 2: 4, 3: 1, 4: 2}
REST_EXTENSION = 30e-3
SLIPS = "the wire of ch1 or ch3 is slack, or softer than the profile says, or its anchor slips"


def swapped(rods, one, other):
    order = list(rods)
    order[one - 1], order[other - 1] = order[other - 1], order[one - 1]
    return tuple(order)


def blame(*history, pressures=(BASE,) * 4, rods=None, least_pull=55e3, watch=None):
    """Return what is said of the last of some rods, one check after the other."""
    bench = WireBench(grace=math.inf, residual=1e-6, least_pull=least_pull)
    if watch is not None:
        bench.watch._limits = bench.watch._limits._replace(**watch)
    for place in history:
        bench.check(place, pressures)
    last = history[-1] if rods is None else rods
    return bench.watch._explain(last, last, pressures)


# One wire or encoder ------------------------------------------------------------------------


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_rod_that_runs_in_has_a_slack_wire(number):
    wrong = off(TILTED, number, 2e-3)
    assert blame(TILTED, wrong) == f"the wire of ch{number} is slack or cut, by 2.00 mm"


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_rod_that_stays_out_has_a_wire_that_is_caught(number):
    names = sorted((number, OPPOSITE[number]))  # near upright opposite ones look the same
    assert blame(TILTED, off(TILTED, number, -2e-3)) == (
        " or ".join(f"the wire of ch{k}" for k in names)
        + " is caught, or "
        + " or ".join(f"e{k}" for k in names)
        + " is off, by 2.00 mm"
    )


@pytest.mark.parametrize(
    ("fullest", "pushed"), [(0.0, True), (54.9e3, True), (55e3, False), (BASE, False)]
)
def test_while_no_chamber_pulls_the_ring_may_have_been_pushed(fullest, pushed):
    said = blame(FAR, off(FAR, 4, -2e-3), pressures=(0.0, fullest, 0.0, 0.0), least_pull=55e3)
    assert said.startswith("the wire of ch4 is caught, or e4 is off, by 2.00 mm")
    assert said.endswith(", or the ring was pushed while its wires were slack") is pushed


@pytest.mark.parametrize(("speed", "pushed"), [(0.11, True), (0.09, False)])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_while_other_rods_run_the_ring_may_have_been_pushed(number, speed, pushed):
    """A push draws rods out faster than their chambers follow: what is caught moves alone."""
    caught = off(FAR, number, -2e-3)
    other = number % 4 + 1  # no opposite one, which may be as suspect
    before = off(caught, other, -speed * WireBench.STEP)
    said = blame(before, caught)
    assert "is caught, or " in said
    assert said.endswith("or the ring was pushed or struck") is pushed
    alone = off(caught, number, -speed * WireBench.STEP)
    assert "pushed" not in blame(alone, caught)


def test_another_rod_is_suspected_if_it_explains_more_than_half():
    """Far out the opposite rod leaves 0.53 of the residual, or 0.39 of another one."""
    assert blame(FAR, off(FAR, 4, -2e-3)).startswith("the wire of ch4 is caught")
    said = blame(FAR, off(FAR, 3, -2e-3))
    assert said.startswith("the wire of ch1 or the wire of ch3 is caught")
    assert said.endswith("by 2.00 mm"), "as far as the rod that explains more says"


@pytest.mark.parametrize(("tilt", "alike"), [(0.72, True), (0.76, False)])
def test_more_than_half_is_half_of_the_residual_over_two_lengths(tilt, alike):
    """The other rod would leave 0.487 and 0.511 of it."""
    rods = rods_at(tilt, 0.4)
    said = blame(rods, off(rods, 4, -2e-3))
    assert said.startswith("the wire of ch2 or the wire of ch4 is caught") is alike
    assert said.startswith("the wire of ch4 is caught") is not alike


def test_two_wrong_rods_are_explained_by_none():
    wrong = off(off(TILTED, 1, 2e-3), 2, 2e-3)
    assert blame(TILTED, wrong) == "more than one wire is slack, or the ring is twisted"


@pytest.mark.parametrize(("times", "clear"), [(1.51, True), (1.49, False)])
@pytest.mark.parametrize("number", [1, 3])
def test_of_two_suspects_the_one_that_gained_half_as_much_again_let_go(number, times, clear):
    """Both ran in near upright: what is off does not show which of them is too far in."""
    run = 1e-3
    gone = off(off(NEAR, number, times * run), OPPOSITE[number], run)
    said = blame(NEAR, NEAR, gone, pressures=(BASE,) * 4)
    if clear:
        assert said.startswith(f"the wire of ch{number} is slack or cut")
    else:
        assert said.startswith(SLIPS)


@pytest.mark.parametrize("number", [1, 3])
def test_where_no_rod_ran_what_is_off_does_not_tell_opposite_ones_apart(number):
    """While chambers fill, a rod may creep at 0.07 m/s, and so may the one that pulls the ring."""
    crept = off(NEAR, number, 0.09 * WireBench.STEP)
    wrong = off(NEAR, number, 0.18 * WireBench.STEP)
    said = blame(NEAR, NEAR, crept, wrong)
    assert said.startswith(f"{SLIPS}, by 0.70 mm")


@pytest.mark.parametrize("cut", [1, 2, 3, 4])
@pytest.mark.parametrize(("alone", "with_ring"), [(2e-3, 6e-3), (6e-3, 2e-3)])
def test_away_from_upright_the_rod_is_named_without_which_the_others_fit(cut, alone, with_ring):
    """Whichever ran faster: an opposite one whose chamber has more pressure pulls the ring over."""
    lean = 0.5 * math.pi * (cut - 1) + 0.3
    leans = rods_at(0.35, lean)
    pulled = rods_at(0.35 - with_ring / 25e-3, lean)
    gone = off(pulled, cut, alone + leans[cut - 1] - pulled[cut - 1])
    half = tuple([0.5 * (a + b) for a, b in zip(leans, gone, strict=True)])
    assert blame(leans, half, gone).startswith(f"the wire of ch{cut} is slack or cut")


@pytest.mark.parametrize(
    ("extension", "at_its_end"),
    [(1e-3 + 1e-9, False), (1e-3 - 1e-9, True), (0.0, True), (REST_EXTENSION, False)],
)
def test_a_rod_at_either_end_of_its_cylinder_has_lost_its_wire(extension, at_its_end):
    wrong = off(TILTED, 2, 2e-3)
    end = "the wire of ch2 is cut or has come off: its rod is at its end"
    inside = {"home": wrong[1] + extension, "stroke": 60e-3}
    assert (blame(TILTED, wrong, watch=inside) == end) is at_its_end
    outside = {"home": wrong[1] + REST_EXTENSION, "stroke": REST_EXTENSION + extension}
    assert (blame(TILTED, wrong, watch=outside) == end) is at_its_end


def settle(speed, pressure, least_pull=55e3):
    """Return what is said of ch1, whose rod has jumped and then goes on at a speed."""
    jumped = off(TILTED, 1, 2e-3)
    going = off(TILTED, 1, 2e-3 + speed * WireBench.STEP)
    pressures = (pressure, BASE, BASE, BASE)
    return blame(TILTED, jumped, going, pressures=pressures, least_pull=least_pull)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_rod_that_stands_under_pressure_pulls_on_something_again(way):
    slipped = "the anchor of ch1 has slipped, or its wire was slack, by"
    slack = "the wire of ch1 is slack or cut, by"
    assert settle(way * 0.0499, BASE).startswith(slipped)
    assert settle(way * 0.0501, BASE).startswith(slack)
    assert settle(0.0, 55e3).startswith(slipped)
    assert settle(0.0, 55e3 - 1e-6).startswith(slack)
    assert settle(0.0, BASE).endswith("by 2.00 mm; it is taut again")


def test_a_pose_of_three_rods_is_looked_for_sixty_times_at_most(monkeypatch):
    """The fourth is so far off that its opposite one could be put right after 300 rounds only."""
    watch = WireBench().watch
    solve, tried = watch._diagnosis.update, []
    monkeypatch.setattr(watch._diagnosis, "update", lambda rods: tried.append(rods) or solve(rods))
    left, _ = watch._without(off(rods_at(0.79, 0.5 * math.pi), 1, 14e-3), 1)
    assert len(tried) == 60
    assert 5e-3 < left < 9e-3


def test_after_a_single_check_no_speed_is_known():
    wrong = off(FAR, 1, 2e-3)
    assert blame(wrong).startswith("the anchor of ch1 has slipped")


# Encoders that are swapped -----------------------------------------------------------------


@pytest.mark.parametrize(("one", "other"), [(1, 2), (1, 4), (2, 3), (3, 4)])
def test_neighbours_that_are_swapped_are_told_by_what_the_pressures_did(one, other):
    """Two swaps fit, and of one of them the rods would have moved against their pull."""
    pressures = (2.0 * BASE, 0.4 * BASE, 0.6 * BASE, 3.0 * BASE)  # the ring follows them
    for first in (0, -10):  # from upright, or from where it leant the other way
        way = [swapped(rods_at(0.03 * k, 0.6), one, other) for k in range(first, 5)]
        assert blame(*way, pressures=pressures) == f"e{one} and e{other} are swapped"


@pytest.mark.parametrize(("checks", "names"), [(256, "e1 and e2"), (257, "e3 and e4")])
def test_what_the_pressures_did_is_remembered_for_256_checks(checks, names):
    """Without it one of two possible swaps is as good as the other: it takes the last."""
    there = swapped(rods_at(0.3, 0.6), 1, 2)
    history = [UPRIGHT, *[there] * (checks - 1)]
    assert blame(*history, pressures=(2 * BASE, BASE, BASE, 2 * BASE)) == f"{names} are swapped"


def test_opposite_ones_show_no_residual():
    for one, other in ((1, 3), (2, 4)):
        assert residual_of(swapped(TILTED, one, other)) < 1e-9


@pytest.mark.parametrize(("error", "told"), [(1.5e-3, True), (1.65e-3, False)])
def test_a_swap_must_leave_less_than_its_share_of_the_residual(error, told):
    wrong = off(swapped(TILTED, 2, 3), 1, error)
    assert 0.32 < residual_of(swapped(wrong, 2, 3)) / residual_of(wrong) < 0.39
    assert ("swapped" in blame(wrong)) is told


@pytest.mark.parametrize(("tilt", "told"), [(0.0199, False), (0.0201, True)])
def test_near_home_the_order_of_the_rods_does_not_show(tilt, told):
    """The longest way is 0.5 mm there."""
    rods = swapped(rods_at(tilt, 0.5 * math.pi), 1, 2)
    assert residual_of(rods) > 0.3e-3
    assert (WireBench().watch.explain_swap(rods) is not None) is told


@pytest.mark.parametrize(("longest", "told"), [(0.5e-3, True), (0.4999999e-3, False)])
def test_the_longest_way_may_be_just_that(longest, told):
    rods = swapped(rods_at(0.0198, 0.5 * math.pi), 1, 2)
    rods = tuple([math.copysign(longest, rod) if abs(rod) > 0.4e-3 else rod for rod in rods])
    assert (WireBench().watch.explain_swap(rods) is not None) is told


@pytest.mark.parametrize(("tilt", "told"), [(0.0265, False), (0.0267, True)])
def test_a_swap_needs_a_residual_beyond_friction_and_stretch(tilt, told):
    """It is 0.25 mm there."""
    rods = swapped(rods_at(tilt, 0.4), 2, 3)
    assert max(map(abs, rods)) > 0.6e-3
    assert residual_of(rods) == pytest.approx(0.25e-3, rel=0.01)
    assert (WireBench().watch.explain_swap(rods) is not None) is told


def test_a_swap_comes_before_a_wire_in_the_alarm():
    bench = WireBench()
    bench.check(UPRIGHT)
    with pytest.raises(SafetyError, match=r"^e\d and e\d are swapped \[the four wires"):
        for _ in range(20):
            bench.check(swapped(TILTED, 2, 3))


# A rod that runs too fast ------------------------------------------------------------------


def test_a_rod_that_runs_in_ahead_of_the_others_has_a_cut_wire():
    watch = WireBench().watch
    wrong = off(TILTED, 4, 2e-3)
    assert watch.explain_run(wrong, (BASE,) * 4, 3) == (
        "the wire of ch4 is slack or cut, or its anchor slips: its rod runs in, 2.00 mm ahead of "
        "where the other three put it"
    )
    behind = off(TILTED, 4, -2e-3)
    assert watch.explain_run(behind, (BASE,) * 4, 3) is None


@pytest.mark.parametrize("share", [1.0 + 1e-6, 1.0 - 1e-6])
def test_a_rod_that_runs_with_the_others_has_its_wire(share):
    wrong = off(TILTED, 4, 0.4e-3)
    watch = WireBench(residual=2.0 * residual_of(wrong) * share).watch
    assert (watch.explain_run(wrong, (BASE,) * 4, 3) is None) is (share > 1.0)


def test_a_rod_exactly_on_half_of_the_limit_has_its_wire():
    wrong = off(TILTED, 4, 0.4e-3)
    watch = WireBench(residual=1.9 * residual_of(wrong)).watch
    on_it = WireBench(residual=2.0 * watch._residual_of(wrong)).watch
    assert watch.explain_run(wrong, (BASE,) * 4, 3) is not None
    assert on_it.explain_run(wrong, (BASE,) * 4, 3) is None


@pytest.mark.parametrize("share", [1.0 + 1e-3, 1.0 - 1e-3])
def test_however_wide_a_limit_is_a_rod_that_is_a_quarter_of_a_millimetre_ahead_has_no_wire(share):
    """A calibration permits more while it looks for what the limit rests on."""
    far = 2e-3
    for _ in range(20):  # residuals grow with what is off, but not quite in proportion
        far *= 0.25e-3 * share / residual_of(off(TILTED, 4, far))
    watch = WireBench(residual=math.inf).watch
    found = watch.explain_run(off(TILTED, 4, far), (BASE,) * 4, 3)
    assert (found is not None) is (share > 1.0)


def test_a_rod_that_fits_no_pose_at_all_is_far_ahead():
    rods = (0.06, 0.0, -0.06, 0.0)
    assert ", far ahead of where" in WireBench().watch.explain_run(rods, (BASE,) * 4, 0)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("cut", [0, 1, 2, 3])
def test_of_two_opposite_rods_that_run_in_the_first_one_let_go(cut, seed):
    """The other one is pulled by more and is faster soon: both are asked about."""
    rng = np.random.default_rng([seed, cut])
    bench = WireBench()
    step, other = 2.0**-10, (cut + 2) % 4
    acceleration, delay = rng.uniform(150.0, 400.0), rng.uniform(1e-3, 2e-3)
    rods = UPRIGHT
    for _ in range(8):
        bench.watch.follow(rods, bench.now)
        bench.now += step
    began = bench.now - rng.uniform(0.0, step)
    faster = rng.uniform(1.0, 1.4)
    for _ in range(6):
        t = bench.now - began
        way = 0.5 * faster * acceleration * max(t - delay, 0.0) ** 2  # of the other one: the ring's
        turned = rods_at(way / 25e-3, 0.5 * math.pi * other)
        rods = off(turned, cut + 1, 0.5 * acceleration * t**2 - turned[cut])
        bench.watch.follow(rods, bench.now)
        bench.now += step
    for asked in (cut, other):
        said = bench.watch.explain_run(rods, (BASE,) * 4, asked)
        assert said.startswith(f"the wire of ch{cut + 1} is slack or cut")


def pulled(rng, cut, pressures, moves):
    """Return a watch of a moving ring near upright of which a wire is cut.

    The rod of that wire moves itself alone, the opposite one the ring as well, each with what its
    chamber pulls more than its seals hold; `moves`: how fast the ring was, m/s.
    """
    bench, other = WireBench(), (cut + 2) % 4
    step, rods = 2.0**-10, list(rods_at(0.02, rng.uniform(0.0, 6.0)))
    speeds = [0.0] * 4
    speeds[cut], speeds[other] = moves, -moves
    began = bench.now + (8.0 - rng.uniform(0.0, 1.0)) * step
    for _ in range(12):
        t = bench.now - began
        for k, mass in ((cut, 1.0), (other, 2.6)):
            rods[k] += speeds[k] * step
            if t > 0.0:
                pull = max(pressures[k] - 55e3, 0.0) * 181e-6 / 0.045 / mass
                rods[k] += pull * (t * step - 0.5 * step**2)
        bench.watch.follow(tuple(rods), bench.now)
        bench.now += step
    return bench.watch


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("cut", [0, 1, 2, 3])
def test_the_rod_that_gains_more_for_its_pull_let_go(cut, seed):
    """Whichever way the ring moved, and whichever chamber has more pressure."""
    rng = np.random.default_rng([9, seed, cut])
    pressures = tuple(rng.uniform(90e3, 300e3, 4))
    watch = pulled(rng, cut, pressures, rng.uniform(-0.06, 0.06))
    for asked in (cut, (cut + 2) % 4):
        said = watch.explain_run(off(rods_at(0.0, 0.0), cut + 1, 2e-3), pressures, asked)
        assert said.startswith(f"the wire of ch{cut + 1} is slack or cut")


@pytest.mark.parametrize("cut", [0, 1, 2, 3])
def test_far_from_upright_what_is_off_tells_which_rod_let_go(cut):
    """Though the other one gained more."""
    rng = np.random.default_rng([10, cut])
    other = (cut + 2) % 4
    watch = pulled(rng, other, (200e3,) * 4, 0.0)
    leans = rods_at(0.9, 0.5 * math.pi * cut + 0.8)
    said = watch.explain_run(off(leans, cut + 1, 6e-3), (200e3,) * 4, other)
    assert said.startswith(f"the wire of ch{cut + 1} is slack or cut")


# Before it has lasted -------------------------------------------------------------------------


def suspected(rods, residual, pressures=(BASE,) * 4):
    """Return what is suspected of rods, the bound of whose residual is given, m."""
    bench = WireBench(grace=math.inf, residual=residual, least_pull=55e3)
    bench.check(TILTED)
    return bench.watch.suspicion(rods, rods, pressures)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
@pytest.mark.parametrize("way", [2e-3, -2e-3])
def test_one_rod_that_does_not_agree_is_suspected_from_half_of_the_bound_on(number, way):
    rods = off(TILTED, number, way)
    found = residual_of(rods)
    said = suspected(rods, 1.99 * found)
    assert said is not None and f"ch{number}" in said
    assert suspected(rods, 2.01 * found) is None
    assert WireBench().watch.suspicion(rods, rods, (BASE,) * 4) is None, "nothing was checked yet"


def test_whose_chamber_cannot_pull_is_not_suspected_and_two_are_none():
    rods = off(FAR, 4, 2e-3)
    for pressure, told in ((55e3, True), (54.9e3, False)):
        said = suspected(rods, 1e-6, (BASE, BASE, BASE, pressure))
        assert (said is not None) is told
    assert suspected(off(off(TILTED, 1, -3e-3), 2, 3e-3), 1e-6) is None
