"""What is said against gains: which plants they lose, and how far."""

import math
from types import SimpleNamespace

from rig.hal.bench import Trial
from rig.tuning.ensemble import Member
from rig.tuning.verdict import EnsembleVerdict, objections


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
