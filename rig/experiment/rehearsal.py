"""The first cycles of a run, gone through in simulation before a real rig is opened.

What a cycle calls for the first time is compiled or imported then, which takes from some ten
milliseconds to seconds: on a rig the loop would have stalled. Simulated time does not mind.
"""

import copy
import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from rig.assembly import Backend, build_rig
from rig.experiment.plan import Plan
from rig.experiment.watcher import Watcher
from rig.hal import MotionRefused
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

CYCLES = 50
"""So many cycles are rehearsed."""
_TIMINGS = Timings(energise=0.01, approach=60.0, release=0.0, brake=0.0, settle=0.0)
"""Control takes over at once and has not come to the motion when the rehearsal ends."""

_LOG = logging.getLogger(__name__)


def rehearse(plan: Plan, watcher: Watcher | None = None) -> None:
    """Let the plan's controller hold a simulated rig for a moment.

    A rehearsal that fails is no reason to refuse the rig itself, which may well be another than
    the simulated one; it is logged.

    Parameters
    ----------
    plan : Plan
        A copy of its controller holds the simulated rig; what both share is reset when control of
        the rig itself begins.
    watcher : Watcher, optional
        Is told of the simulated rig.
    """
    watcher = watcher or Watcher()
    stop = StopRequests()
    fault: Exception | None
    try:
        fault = _run(plan, _TIMINGS, stop, _Silent(stop, CYCLES), watcher)
    except Exception as error:  # a rig's computer may lack what simulation takes
        fault = error
    if fault is not None:
        _LOG.warning("the rehearsal in simulation ended early: %s", fault)


def play_through(plan: Plan) -> None:
    """Go through a whole plan on a simulated rig in which nothing breaks; nothing is left behind.

    Raises
    ------
    MotionRefused
        It ended in a fault.
    """
    healthy = replace(plan.profile, simulation=replace(plan.profile.simulation, faults=()))
    timings = Timings(approach=plan.experiment.approach)
    stop = StopRequests()
    fault = _run(plan._replace(profile=healthy), timings, stop, _Silent(stop), Watcher())
    if fault is not None:
        raise MotionRefused(f"in rehearsal on the simulated rig: {fault}") from fault


def _run(
    plan: Plan, timings: Timings, stop: StopRequests, silent: "_Silent", watcher: Watcher
) -> Exception | None:
    """Run a plan on a simulated rig; return the fault that ended it."""
    states = StateMachine()
    states.move(RigState.IDLE)
    # What it believes of the simulated rig stays with the copy, and out of the other rig's log.
    controller = copy.copy(plan.controller)
    with build_rig(plan.profile, Backend.SIM) as rig:
        rig.mechanism.attach(controller, plan.motion)
        plan.motion.attach(rig.devices)
        watcher.rehearsing(rig)
        rig.arm(torque=plan.motion.has_torque)
        loop: Loop[Any, Any, Any] = Loop(
            clock=rig.clock,
            period=plan.profile.loop.period,
            buses=tuple(rig.buses.values()),
            devices=tuple(rig.devices.values()),
            mechanism=rig.mechanism,
            controller=watcher.employed(controller),
            states=states,
        )
        return loop.run(
            plan.motion, recorder=silent, events=_unheard, stop=stop, timings=timings
        ).fault


class _Silent:
    """Records nothing; may ask for the end after some cycles."""

    def __init__(self, stop: StopRequests, cycles: int | None = None) -> None:
        self._stop = stop
        self._cycles = cycles

    def write(self, cycle: int, t: float, row: Sequence[float]) -> None:
        if self._cycles is not None and cycle >= self._cycles:
            self._stop.request()


def _unheard(*_: object) -> None:
    pass
