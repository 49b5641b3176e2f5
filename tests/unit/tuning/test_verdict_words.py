"""What is said against gains: which plants they lose, and how far."""

import math
from pathlib import Path
from types import SimpleNamespace

from rig import tuning
from rig.hal.bench import Trial
from rig.hal.closed_loop import ClosedLoop
from rig.mechanisms.pneumatic.shaken_pair import UNTOLD
from rig.report.style import new_figure, paper_style
from rig.tuning.ensemble import Member
from rig.tuning.figure import _draw_margins, draw_tuning
from rig.tuning.verdict import EnsembleVerdict, in_short, objections, other_levers, trades


def verdict(*fates):
    members = tuple(Member(f"plant {k}", {}, 0) for k in range(len(fates)))
    trials = tuple(Trial({"sine": 1e-3}, 0.0, 0.0, strayed, lasted) for strayed, lasted in fates)
    margins = (SimpleNamespace(stable=True, sensitivity=1.5),)
    return EnsembleVerdict({}, members, trials, margins, 1.0)


def test_the_worst_of_the_lost_plants_are_named_with_what_became_of_them():
    now = verdict((0.1, 1.0), (1.25, 1.0), (math.inf, 0.62), (2.5, 1.0), (1.1, 1.0))
    before = verdict((0.1, 1.0))._replace(cost=2.0)
    (said,) = objections(now, before, "m")
    assert said.startswith(
        "they lose 4 of 5 plants, or would be stopped there (before: 0), the worst of them:"
    )
    assert said.endswith(
        "plant 2 (lost after 62 % of the motion); plant 3 (2.5 times the error that stops the "
        "rig); plant 1 (1.2 times the error that stops the rig)"
    )


def test_gains_that_lose_fewer_plants_than_those_in_force_are_put_in_force_and_say_so():
    before = verdict(*[(2.0, 1.0)] * 3, (0.1, 1.0))._replace(cost=2.0)
    now = verdict(*[(2.0, 1.0)] * 2, (0.1, 1.0), (0.1, 1.0))
    assert not objections(now, before, "m")
    assert trades(now, before, "m")[0].startswith(
        "no more than before, they lose 2 of 4 plants, or would be stopped there (before: 3), "
    )
    (said,) = objections(before._replace(cost=0.5), now, "m")
    assert said.startswith("they lose 3 of 4 plants, or would be stopped there (before: 2), ")


def test_nothing_is_said_of_plants_that_are_borne():
    assert verdict((0.99, 1.0), (0.5, 1.0)).losses == ""


def measured(hunting, error, worst, reversals=5.0, cost=1.0):
    members = (Member("", {}, 0), Member("stiff", {}, 0))
    trials = (
        Trial({"sine": error}, 0.0, reversals, 0.1, 1.0),
        Trial({"sine": worst}, hunting, 0.0, 0.1, 1.0),
    )
    margins = (SimpleNamespace(stable=True, sensitivity=1.5),)
    return EnsembleVerdict({}, members, trials, margins, cost)


def test_a_bound_that_is_missed_by_more_than_before_speaks_against_gains_that_cost_less():
    before = measured(1.568e-3, 1.2e-3, 2.8e-3, cost=1.1)
    now = measured(1.825e-3, 1.0e-3, 3.0e-3, cost=-0.3)
    (said,) = objections(now, before, "m")
    assert said == (
        "worse than before, bound missed: 1.825 mm of hunting on the worst plant, and at most "
        "0.1 mm is asked for (before: 1.568 mm)"
    )
    (traded,) = trades(now, before, "m")
    assert "worst hunting 1.568 mm to 1.825 mm" in traded
    assert "worst error, sine 2.8 mm to 3 mm" in traded
    assert "as told" not in traded


def test_a_bound_that_both_miss_is_said_and_refuses_nothing():
    before = measured(1.825e-3, 1.2e-3, 2.8e-3, reversals=31.0, cost=1.1)
    now = measured(1.568e-3, 1.0e-3, 3.0e-3, reversals=31.0, cost=-0.3)
    assert not objections(now, before, "m")
    hunting, reversals, _ = trades(now, before, "m")
    assert hunting.startswith("bound missed: 1.568 mm") and "31.0 reversals" in reversals


def test_more_of_what_stays_within_its_bound_refuses_nothing():
    before = measured(0.01e-3, 1.2e-3, 2.8e-3, reversals=1.0, cost=1.1)
    now = measured(0.09e-3, 1.0e-3, 2.8e-3, reversals=24.0, cost=-0.3)
    assert not objections(now, before, "m")


def test_gains_that_lost_plants_are_no_measure_of_hunting():
    before = measured(0.01e-3, 1.2e-3, 2.8e-3, cost=1000.0)
    lost = before.trials[1]._replace(lasted=0.1, strayed=2.0)
    before = before._replace(trials=(before.trials[0], lost))
    now = measured(0.3e-3, 1.0e-3, 2.8e-3, cost=-0.3)
    assert not objections(now, before, "m")
    assert trades(now, before, "m")[0].startswith("bound missed: 0.3 mm of hunting")


def test_reversals_have_a_bound_too_and_gains_that_keep_it_all_are_not_talked_about():
    quiet = measured(0.05e-3, 1e-3, 2e-3)
    assert trades(quiet, quiet._replace(cost=2.0), "m") == []
    (missed,) = objections(measured(0.05e-3, 1e-3, 2e-3, reversals=26.0, cost=0.5), quiet, "m")
    assert missed.startswith("worse than before, bound missed: 26.0 reversals a second")


def with_margin(now, of):
    """Return gains that keep the margin on so many of 200 plants."""
    kept, lost = (SimpleNamespace(stable=True, sensitivity=peak) for peak in (1.5, 1.9))
    return now._replace(margins=(kept,) * of + (lost,) * (200 - of))


def test_gains_that_lack_margin_by_less_than_those_in_force_are_put_in_force_and_say_so():
    """98 % of plants instead of 54 % is better, though 99 % are asked for."""
    before = with_margin(measured(1e-3, 1.2e-3, 2.8e-3, cost=1.1), 108)
    now = with_margin(measured(0.05e-3, 1.0e-3, 2.0e-3, cost=-0.3), 196)
    assert not objections(now, before, "m")
    assert trades(now, before, "m") == [
        "bound missed, though by less than before: only 196 of 200 drawn plants keep a "
        "sensitivity of at most 1.7, and 198 are asked for (before: 108)"
    ]
    (said,) = objections(now, with_margin(before, 198), "m")
    assert said.startswith("bound missed: only 196 of 200 drawn plants")
    assert objections(now, with_margin(before, 196), "m")
    assert not objections(with_margin(now, 198), with_margin(before, 200), "m")


def test_in_short_says_at_what_gains_are_better_and_at_what_worse():
    before = with_margin(measured(1e-3, 1.2e-3, 2.8e-3, cost=1.1), 6)
    now = with_margin(measured(0.5e-3, 1.3e-3, 2.0e-3, reversals=6.0, cost=0.3), 178)
    assert in_short(now, before, "m") == (
        "better in margin (6 to 178 of 200 drawn plants), hunting 1 mm to 0.5 mm, 1 of 2 errors; "
        "worse in reversals 5.0 to 6.0 a second, 1 of 2 errors; cost 1.100 to 0.300"
    )
    assert in_short(before, before, "m") == "neither better nor worse; cost 1.100 to 1.100"


def shaken(now, kept, told):
    """Return gains of which the shake told so many of 200 plants, that keep the margin or not."""
    good, bad = (SimpleNamespace(stable=True, sensitivity=peak) for peak in (1.5, 1.9))
    return now._replace(
        margins=(good,) * kept + (bad,) * (told - kept) + (UNTOLD,) * (200 - told), measured=True
    )


def test_plants_whose_loop_the_shake_does_not_tell_are_told_apart_from_those_that_are_too_near():
    before = shaken(measured(1e-3, 1.2e-3, 2.8e-3, cost=1.1), 1, 36)
    now = shaken(measured(0.5e-3, 1.3e-3, 2.0e-3, cost=0.3), 0, 20)
    assert (before.told, before.keeping, now.told, now.keeping) == (36, 1, 20, 0)
    (said,) = objections(now, before, "m")
    assert said == (
        "bound missed: of 200 drawn plants 20 were told, of which 0 keep a sensitivity of at most "
        "1.7 (the others catch, or swing by themselves, while they are shaken), and 198 are asked "
        "for (before: 1 of 36 that were told)"
    )
    *_, traded = trades(now, before, "m")
    assert "drawn plants with margin 1 to 0 of 200" in traded
    assert "drawn plants that were told 36 to 20" in traded
    assert "told 36 to 20" in in_short(now, before, "m")


def test_a_linear_model_that_says_unstable_tells_that():
    unstable = ClosedLoop(False, 20.0, -0.1, 0.0, math.inf)
    found = measured(1e-3, 1.2e-3, 2.8e-3)._replace(margins=(unstable,) * 3)
    assert (found.told, found.keeping) == (3, 0)


def test_what_else_is_a_lever_is_said_where_gains_miss_the_bound():
    found = measured(1e-3, 1.2e-3, 2.8e-3)
    assert other_levers(with_margin(found, 198)) == ""
    assert "less dead time" in other_levers(with_margin(found, 197))
    section = "Where no gains do it"
    assert section in other_levers(shaken(found, 0, 0))
    page = Path(tuning.__file__).with_name("README.md").read_text(encoding="utf-8")
    assert f"**{section}.**" in page


def test_the_figure_has_a_place_of_its_own_for_what_was_not_told(tmp_path):
    now = shaken(measured(0.5e-3, 1.3e-3, 2.0e-3), 100, 150)
    with paper_style():
        axes = new_figure(100.0, 60.0).subplots()
        _draw_margins(axes, now, shaken(now, 200, 200))
    assert [label.get_text() for label in axes.get_xticklabels()][-1] == "not\ntold"
    *_, line = axes.lines[:2]
    told = line.get_ydata()[line.get_xdata() <= 4.0]
    assert max(told) == 0.75 and max(line.get_ydata()) == 1.0
    assert draw_tuning(tmp_path / "tuning", [1.0, 0.5], now, now)
