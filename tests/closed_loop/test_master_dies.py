"""The master dies in mid-motion: its last setpoints stay, and no rig is thrown into its stops."""

import random

import numpy as np
import pytest
from stop_bench import CONFIGS, WATCHED

from rig.assembly import Backend, build_rig
from rig.experiment.plan import load_plan
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

DRAWN = random.Random(2718)
SINE = ("reference.amplitude=10 mm", "reference.tones=[{frequency: 1 Hz, periods: 3}]")
CIRCLE = ("reference.tones=[{frequency: 0.5 Hz, laps: 1}]",)


class Killed(BaseException):
    """The process is no more."""


def kill(experiment, options, at):
    """Kill a run at an instant of its motion, s; return the plant's truth from then on."""
    plan = load_plan(experiment, [*options, "metrics={}", "figures=[]"], configs=CONFIGS)
    states = StateMachine()
    states.move(RigState.IDLE)

    class Recorder:
        def write(self, cycle, t, row):
            if row[1] >= at:
                raise Killed

    period = plan.profile.loop.period
    with build_rig(plan.profile, Backend.VIRTUAL) as rig:
        rig.mechanism.attach(plan.controller, plan.motion)
        plan.motion.attach(rig.devices)
        rig.arm()
        loop = Loop(
            clock=rig.clock, period=period, buses=tuple(rig.buses.values()),
            devices=tuple(rig.devices.values()), mechanism=rig.mechanism,
            controller=plan.controller, states=states,
        )  # fmt: skip
        loop.make_safe = lambda *_: ()
        with pytest.raises(Killed):
            loop.run(
                plan.motion,
                recorder=Recorder(),
                events=lambda *_: None,
                stop=StopRequests(),
                timings=Timings(approach=0.5),
            )
        start, rows = rig.clock.now(), []
        for tick in range(round(WATCHED / period)):
            rig.clock.sleep_until(start + tick * period)
            rows.append(rig.truth())
        names = [column.name.removeprefix("truth.") for column in rig.truth_columns]
        return dict(zip(names, np.array(rows).T, strict=True))


def draw(count, experiments, last):
    return [
        (DRAWN.choice(experiments), DRAWN.randrange(1000), DRAWN.uniform(0.1, last))
        for _ in range(count)
    ]


@pytest.mark.parametrize(
    ("experiment", "seed", "at"), draw(8, ["cylinder-sine", "cylinder-ideal-sine-low-speed"], 2.9)
)
def test_cylinder_does_not_reach_its_end(experiment, seed, at):
    truth = kill(experiment, (*SINE, f"simulation.seed={seed}"), at)
    assert np.abs(truth["position"]).max() < 24e-3  # a tenth of its range beyond its limits
    assert max(truth["pressure_agonist"][-1], truth["pressure_antagonist"][-1]) < 20e3


FASTEST = [("joint-range", 26.40), ("joint-wide", 18.77), ("joint-poses", 14.85)]
"""When frozen setpoints act soonest, as `rig check` says, s."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("experiment", "seed", "at"),
    [(name, DRAWN.randrange(1000), at + DRAWN.uniform(-0.1, 0.1)) for name, at in FASTEST],
)
def test_ring_stays_within_its_limits_in_the_fastest_motions(experiment, seed, at):
    truth = kill(experiment, (f"simulation.seed={seed}",), at)
    assert np.degrees(np.arccos(truth["axis_z"])).max() < 66.0  # a tenth beyond its limit
    assert max(truth[f"pressure_ch{k}"][-1] for k in (1, 2, 3, 4)) < 20e3


@pytest.mark.parametrize(("experiment", "seed", "at"), draw(4, ["joint-circle"], 3.9))
def test_ring_is_not_thrown_over(experiment, seed, at):
    truth = kill(experiment, (*CIRCLE, f"simulation.seed={seed}"), at)
    assert np.degrees(np.arccos(truth["axis_z"])).max() < 60.0
    assert max(truth[f"pressure_ch{k}"][-1] for k in (1, 2, 3, 4)) < 20e3
