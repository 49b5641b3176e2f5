"""What is said against gains: which plants they lose, and how far."""

import math
from types import SimpleNamespace

from rig.hal.bench import Trial
from rig.tuning.ensemble import Member
from rig.tuning.verdict import EnsembleVerdict, objections, trades


def verdict(*fates):
    members = tuple(Member(f"plant {k}", {}, 0) for k in range(len(fates)))
    trials = tuple(Trial({"sine": 1e-3}, 0.0, 0.0, strayed, lasted) for strayed, lasted in fates)
    margins = (SimpleNamespace(stable=True, sensitivity=1.5),)
    return EnsembleVerdict({}, members, trials, margins, 1.0)


def test_the_worst_of_the_lost_plants_are_named_with_what_became_of_them():
    now = verdict((0.1, 1.0), (1.25, 1.0), (math.inf, 0.62), (2.5, 1.0), (1.1, 1.0))
    before = verdict((0.1, 1.0))._replace(cost=2.0)
    (said,) = objections(now, before)
    assert said.startswith("they lose 4 of 5 plants, or would be stopped there, the worst of them:")
    assert said.endswith(
        "plant 2 (lost after 62 % of the motion); plant 3 (2.5 times the error that stops the "
        "rig); plant 1 (1.2 times the error that stops the rig)"
    )


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


def test_a_bound_that_is_missed_and_what_is_worse_are_said_of_gains_that_cost_less():
    before = measured(1.568e-3, 1.2e-3, 2.8e-3, cost=1.1)
    now = measured(1.825e-3, 1.0e-3, 3.0e-3, cost=-0.3)
    assert not objections(now, before)
    missed, traded = trades(now, before, "m")
    assert missed == (
        "bound missed: 1.825 mm of hunting on the worst plant, and at most 0.1 mm is asked for "
        "(before: 1.568 mm)"
    )
    assert "worst hunting 1.568 mm to 1.825 mm" in traded
    assert "worst error, sine 2.8 mm to 3 mm" in traded
    assert "as told" not in traded


def test_reversals_have_a_bound_too_and_gains_that_keep_it_all_are_not_talked_about():
    quiet = measured(0.05e-3, 1e-3, 2e-3)
    assert trades(quiet, quiet._replace(cost=2.0), "m") == []
    (missed,) = trades(measured(0.05e-3, 1e-3, 2e-3, reversals=26.0), quiet, "m")
    assert missed.startswith("bound missed: 26.0 reversals a second")
