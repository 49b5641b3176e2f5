"""The cylinder rig as a benchmark runs it: the whole loop, with its log, without a console."""

import contextlib
from typing import NamedTuple

from rig.assembly import REGISTRY, build_rig, make_controller
from rig.config import find_configs, load_profile
from rig.mechanisms.cylinder.references import Sine, SineTone
from rig.runtime.cycle import RUN_COLUMNS, TIMING_COLUMNS
from rig.runtime.loop import Loop, Outcome
from rig.runtime.phases import Timings
from rig.runtime.recorder import LogRecorder
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

AMPLITUDE = 8.727e-3  # of the sine, m
PERIODS = 2


class Run(NamedTuple):
    """What a run took: cycles, and seconds on the rig's clock."""

    outcome: Outcome
    duration: float


def cylinder_profile():
    return load_profile("cylinder", REGISTRY, ["loop.rate=500 Hz"], find_configs())


@contextlib.contextmanager
def armed_rig(backend, profile=None):
    """Yield the cylinder rig, ready to run."""
    with build_rig(profile or cylinder_profile(), backend) as rig:
        rig.arm()
        yield rig


def columns_of(rig):
    return (*RUN_COLUMNS, *rig.mechanism.columns, *TIMING_COLUMNS, *rig.truth_columns)


def frequency_of(seconds):
    """Return the frequency of the sine, Hz, in a run of so many seconds."""
    return PERIODS / (seconds - sum(Timings()))


def run(rig, log, seconds, *, clock=None):
    """Run the cascade through one slow sine, in so many seconds, recorded to `log`."""
    controller = make_controller(rig.profile, "cascade")
    rig.mechanism.controller = controller
    clock = clock or rig.clock
    states = StateMachine()
    states.move(RigState.IDLE)
    loop = Loop(
        clock=clock,
        period=rig.profile.loop.period,
        buses=tuple(rig.buses.values()),
        devices=tuple(rig.devices.values()),
        mechanism=rig.mechanism,
        controller=controller,
        states=states,
        truth=rig.truth,
    )
    motion = Sine(AMPLITUDE, (SineTone(frequency_of(seconds), PERIODS),))
    events = []
    with LogRecorder(log, columns_of(rig)) as recorder:
        start = clock.now()
        outcome = loop.run(
            motion,
            recorder=recorder,
            events=lambda *event: events.append(event),
            stop=StopRequests(),
        )
        duration = clock.now() - start
    assert outcome.fault is None, outcome.fault
    assert not outcome.missed
    return Run(outcome, duration)
