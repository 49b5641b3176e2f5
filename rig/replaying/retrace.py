"""A run's loop without its rig: what the code at hand makes of the readings of a log."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rig.assembly.build import make_unconnected
from rig.experiment.plan import Plan
from rig.hal.columns import Column
from rig.replaying.recorded import Logged
from rig.runtime.cycle import RUN_COLUMNS
from rig.runtime.phases import Phase, Phases, Timings
from rig.runtime.states import RigState, StateMachine

if TYPE_CHECKING:
    from rig.replaying.frames import FramesRig


class Retrace:
    """Takes the cycles of a log one by one, in the place of a rig's readings.

    Everything between the readings and the devices is the loop's own: the phases, the reference,
    the controller, the limits, the brake of an orderly stop. Only what the loop heard from
    outside is taken from the log: readings, lateness, the request to stop, the fault.

    Parameters
    ----------
    plan : Plan
        Of the run; its controller and motion are used up.
    judged : bool
        Watch the readings for faults, as the loop does. Where another law is asked, the readings
        are not what its commands have led to, and would look broken.
    frames : FramesRig, optional
        Has the drivers read anew what the buses carried; else the log says what they read.

    Attributes
    ----------
    columns : tuple of Column
        What `step` returns.
    """

    def __init__(
        self, plan: Plan, *, judged: bool = True, frames: "FramesRig | None" = None
    ) -> None:
        self._judged = judged
        self._frames = frames
        mechanism = self._mechanism = (
            make_unconnected(plan.profile)[0] if frames is None else frames.mechanism
        )
        mechanism.attach(plan.controller, plan.motion)
        states = StateMachine()
        for state in (RigState.IDLE, RigState.RUNNING):
            states.move(state)
        self._run: Phases[object, object, object] = Phases(
            mechanism,
            plan.controller,
            states,
            plan.motion,
            Timings(approach=plan.experiment.approach),
            period=plan.profile.loop.period,
        )
        self.columns: Sequence[Column] = (*RUN_COLUMNS, *mechanism.columns)

    def step(self, logged: Logged) -> tuple[float, ...]:
        """Return what this cycle's row should say, by `columns`.

        Raises
        ------
        RigError
            The code at hand would not have gone on here.
        """
        run, mechanism, values = self._run, self._mechanism, logged.values
        clock, fault = values["clock"], values["fault"]
        # Every cycle that the loop did not skip has a row.
        run.missed = logged.cycle - run.cycles
        run.cycles += 1
        run.t = logged.t
        state = self._sense(values, clock, fault)
        if fault:
            reference, applied = mechanism.reference_of(state), mechanism.released_command()
            command = applied
        else:
            if self._judged:
                mechanism.check(state, clock)
            stops = int(values["phase"] == float(Phase.STOP))
            reference, command = run.step(logged.t, state, stops)
            applied = mechanism.limit(command)
            mechanism.write(applied)
            if self._frames is not None:
                self._frames.transmit(clock)
        row = mechanism.row(state, reference, command, applied)
        told = (values["phase"], values["reference.time"])
        phase, at = told if fault else (float(run.phase), run.reference_time)
        return (phase, clock, fault, at, *row)

    def _sense(self, values: dict[str, float], clock: float, fault: float) -> object:
        """Return the cycle's state: from the log, or read from the buses anew."""
        frames = self._frames
        if frames is None:
            return self._mechanism.recall(values)
        frames.receive(clock)
        state = self._mechanism.read(clock)
        if not fault:
            frames.check(clock)
        return state
