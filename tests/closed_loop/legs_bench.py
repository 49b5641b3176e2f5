"""Walks of the legs in virtual time, with something that happens in their midst."""

from functools import cache
from pathlib import Path

import numpy as np

from rig.assembly import Backend, build_rig
from rig.experiment.plan import load_plan
from rig.runtime.cycle import RUN_COLUMNS, TIMING_COLUMNS
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

CONFIGS = Path(__file__).parents[2] / "configs"
TIMINGS = Timings(energise=0.1, approach=0.5)
BRISK = ("reference.landings=1", "reference.speed=5")
"""One landing: shift 0 until 0.6 s, swing right 1 until 2.4 s, shift 1 until 3.6 s."""
IN_MID_SWING, IN_MID_SHIFT = 1.4, 2.9


@cache
def make_plan(experiment="legs-walk", *options):
    """Return a plan, made once."""
    return load_plan(experiment, list(options), configs=CONFIGS)


class Walk:
    """One run of a plan, up to its end whatever that is, and what the robot does then.

    Parameters
    ----------
    plan : Plan
        What to walk.
    at : float
        Time of the walk at which `happen` is called, s.
    happen : callable
        Takes the world and the requests to stop.
    clock : callable, optional
        Takes the rig's clock and returns the loop's.
    after : float
        How long to look at the robot when the rig is closed, s.
    timings : Timings
        Of the run.
    """

    def __init__(
        self,
        plan,
        at=None,
        happen=None,
        *,
        backend=Backend.VIRTUAL,
        clock=lambda rig_clock: rig_clock,
        after=1.5,
        timings=TIMINGS,
    ):
        self.plan = plan
        self.period = plan.profile.loop.period
        self.states = StateMachine()
        rows, stop = [], StopRequests()
        self.happened = None
        if at is not None:
            self.happened = round((timings.energise + timings.approach + at) / self.period)

        class Recorder:
            def write(_, cycle, t, row):
                rows.append(row)
                if cycle == self.happened:
                    happen(rig.clock.world, stop)

        rig = build_rig(plan.profile, backend)
        # The drives live on when the program has ended; the emulated end of their bus stays open.
        release, rig._release = rig._release, lambda: None
        with rig:
            rig.mechanism.controller, rig.mechanism.motion = plan.controller, plan.motion
            self.states.move(RigState.IDLE)
            loop = Loop(
                clock=clock(rig.clock),
                period=self.period,
                buses=tuple(rig.buses.values()),
                devices=tuple(rig.devices.values()),
                mechanism=rig.mechanism,
                controller=plan.controller,
                states=self.states,
                truth=rig.truth,
            )
            rig.arm()
            self.outcome = loop.run(
                plan.motion,
                recorder=Recorder(),
                events=lambda *_: None,
                stop=stop,
                timings=timings,
            )
        self.rig = rig
        columns = (*RUN_COLUMNS, *rig.mechanism.columns, *TIMING_COLUMNS, *rig.truth_columns)
        self._columns = {column.name: k for k, column in enumerate(columns)}
        self._rows = np.array(rows)
        rig.clock.world.advance(rig.clock.now() + after)
        release()
        names = [column.name for column in rig.truth_columns]
        self.truth_after = dict(zip(names, rig.truth(), strict=True))

    def column(self, name):
        """Return a column of the log."""
        return self._rows[:, self._columns[name]]

    def joints(self, prefix):
        """Return a vector of all twelve joints, shape (n, 12)."""
        first = self._columns[f"{prefix}_right_hip_yaw"]
        return self._rows[:, first : first + 12]

    @property
    def detected_after(self):
        """Cycles from what happened to the one that found it."""
        return len(self._rows) - 1 - self.happened
