"""A stop in quiet hours is a false trip, unless friction has grown and the rig says that."""

import math
from pathlib import Path

import pytest

import rig
from rig.assembly import Backend
from rig.assembly.simulated import friction_drawn
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.faults.quiet import GROWN, QuietEnding, QuietRun

CONFIGS = Path(rig.__file__).parents[1] / "configs"
RUN = QuietRun("cylinder", "cylinder-sine", ())
STICKS = "the pair sticks and slips at 0.9 Hz, 7 mm peak to peak, about its reference"
LAGS = "following error of the pair is 3.1 mm; it sticks, with more friction than the profile says"
HELD = (
    "regulators: the chamber of ch2 leaks behind its tube, or its monitor is off, or the ring is "
    "pushed or held, or has more friction than the profile says"
)
SUPPLY = "regulators: the supply pressure is lost: agonist, antagonist fall short"


@pytest.mark.parametrize("code", [0, 1])
@pytest.mark.parametrize("message", [STICKS, LAGS, SUPPLY, ""])
def test_what_runs_to_its_end_is_neither(code, message):
    ended = QuietEnding(RUN, 1.0, code, message, 0.3)
    assert (ended.is_trip, ended.is_right) == (False, False)


@pytest.mark.parametrize("code", [2, 3, 4, 70, None])
@pytest.mark.parametrize(
    ("message", "friction", "right"),
    [
        (STICKS, 0.25, True),
        (LAGS, math.nextafter(GROWN, 1.0), True),
        (LAGS, GROWN, False),
        (HELD, 0.29, True),
        (STICKS, -0.3, False),
        (SUPPLY, 0.3, False),
    ],
)
def test_a_stop_is_right_under_its_name_on_such_a_unit_alone(code, message, friction, right):
    ended = QuietEnding(RUN, 1.0, code, message, friction)
    assert (ended.is_right, ended.is_trip) == (right, not right)
    assert (ended.as_json()["right"], ended.as_json()["trip"]) == (right, not right)


@pytest.mark.parametrize("seed", range(2))
def test_the_friction_that_was_drawn_is_that_of_the_plant(tmp_path, seed):
    """One whose plant says so itself does the same to the last bit."""

    def tracking(*options):
        options = (f"simulation.seed={seed}", *options)
        plan = load_plan("cylinder-sine", options, configs=CONFIGS)
        result = run_experiment(plan, Backend.SIM, tmp_path, report=False)
        (found,) = [of.value for of in result.metrics if of.name == "tracking_rms"]
        return found, friction_drawn(plan.profile)

    found, drawn = tracking("simulation.perturbation={friction: 0.3}")
    assert 0.0 < abs(drawn) <= 0.3
    assert tracking(f"plant.friction_scale={1.0 + drawn!r}") == (found, 0.0)
    assert tracking()[0] != found
