"""An experiment in simulation without a run folder: what was asked for, answered and logged."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rig.assembly import Backend, build_rig
from rig.experiment.plan import Plan, load_plan
from rig.hal import Column, Mechanism
from rig.hal.controller import Law
from rig.runtime.cycle import RUN_COLUMNS
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

AnyLaw = Law[object, object, object]
AnyMechanism = Mechanism[object, object, object, object]


class Asked(NamedTuple):
    """One cycle of a law: what it was given, and what it made of it."""

    state: object
    reference: object
    command: object


class Noting:
    """A law that stands for another one, and notes what passes through it."""

    def __init__(self, law: AnyLaw, mechanism: AnyMechanism) -> None:
        self.law = law
        self.asked: list[Asked] = []
        self.started: object = None
        self.applied: object = None
        self._mechanism = mechanism

    def reset(self, state: object) -> None:
        """Reset the law."""
        self.started = state
        self.applied = self._mechanism.energised_command(state)
        self.law.reset(state)

    def update(self, state: object, reference: object) -> object:
        """Have the law answer."""
        command = self.law.update(state, reference)
        self.asked.append(Asked(state, reference, command))
        return command


class Rehearsal(NamedTuple):
    """An experiment over the first cycles of its way.

    Attributes
    ----------
    plan : Plan
        The experiment.
    mechanism : Mechanism
        As it was left.
    started : object
        The state in which the law took over.
    asked : sequence of Asked
        Its cycles.
    applied : object
        The command that energised the rig, from which the law took over.
    columns : sequence of Column
        Of the mechanism.
    rows : sequence of tuple of float
        What the mechanism logged, cycle by cycle.
    truth : sequence of tuple of float
        What the plant truly did.
    """

    plan: Plan
    mechanism: AnyMechanism
    started: object
    asked: Sequence[Asked]
    applied: object
    columns: Sequence[Column]
    rows: Sequence[tuple[float, ...]]
    truth: Sequence[tuple[float, ...]]


class _Rows:
    """Keeps the rows, and asks for the end after so many."""

    def __init__(self, stop: StopRequests, most: int) -> None:
        self.rows: list[tuple[float, ...]] = []
        self._stop = stop
        self._most = most

    def write(self, cycle: int, t: float, row: Sequence[float]) -> None:
        self.rows.append(tuple(row))
        if len(self.rows) == self._most:
            self._stop.request()


def rehearse(
    configs: Path | None, experiment: str, options: Sequence[str] = (), seconds: float = 2.0
) -> Rehearsal:
    """Go through the beginning of an experiment on `sim`.

    Parameters
    ----------
    configs : Path, optional
        The folder of the configurations; None: those in the working directory, and our own.
    experiment : str
        Its name.
    options : sequence of str
        ``a.b=c``, as on the command line.
    seconds : float
        How much of it, after the law has taken over.
    """
    plan = load_plan(experiment, options, configs=configs)
    period = plan.profile.loop.period
    stop, states = StopRequests(), StateMachine()
    states.move(RigState.IDLE)
    timings = Timings(approach=1.0, release=0.0, brake=0.0, settle=0.0)
    rows = _Rows(stop, round((seconds + timings.energise) / period))
    with build_rig(plan.profile, Backend.SIM) as rig:
        mechanism: AnyMechanism = rig.mechanism
        law = Noting(plan.controller, mechanism)
        mechanism.attach(plan.controller, plan.motion)
        plan.motion.attach(rig.devices)
        rig.arm(torque=plan.motion.has_torque)
        loop: Loop[object, object, object] = Loop(
            clock=rig.clock,
            period=period,
            buses=(),
            devices=tuple(rig.devices.values()),
            mechanism=mechanism,
            controller=law,
            states=states,
            truth=rig.truth,
        )
        outcome = loop.run(
            plan.motion, recorder=rows, events=lambda *_: None, stop=stop, timings=timings
        )
        if outcome.fault is not None:
            raise outcome.fault
        columns = mechanism.columns
    first = len(RUN_COLUMNS)
    end = first + len(columns)
    return Rehearsal(
        plan,
        mechanism,
        law.started,
        law.asked,
        law.applied,
        columns,
        [row[first:end] for row in rows.rows],
        [row[-len(rig.truth_columns) :] for row in rows.rows],
    )


def numbers_of(value: object) -> list[float]:
    """Return every number of a state, reference or command, in their order."""
    if isinstance(value, bool | int | float):
        return [float(value)]
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [number for item in value for number in numbers_of(item)]
    return []


def place_of(reference: object) -> list[float]:
    """Return where a reference wants the mechanism to be: the numbers of its first member."""
    return numbers_of(reference[0] if isinstance(reference, tuple) else reference)


__all__ = ["Asked", "Rehearsal", "numbers_of", "place_of", "rehearse"]
