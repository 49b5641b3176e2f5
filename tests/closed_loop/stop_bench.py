"""Runs that the operator stops, watched by the plant's truth until well after their end."""

from pathlib import Path

import numpy as np

from rig.assembly import build_rig
from rig.experiment.plan import load_plan
from rig.runtime.loop import Loop
from rig.runtime.phases import Phase, Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

CONFIGS = Path(__file__).parents[2] / "configs"
WATCHED = 1.5
"""For how long the plant is watched after the end of the program, s."""
AFTER = 3
"""The phase of the time after the program's end, beside those of `Phase`."""


class Stopped:
    """A run with one request to stop at an instant of its motion, s; None: at its end.

    Another controller may stand before the plan's: what `spoil` makes of it. `each` is called in
    every cycle with the rig and the reference's time, s.
    """

    def __init__(self, experiment, options, backend, at, spoil=lambda controller: controller,
                 each=lambda rig, t: None):  # fmt: skip
        plan = load_plan(experiment, [*options, "metrics={}", "figures=[]"], configs=CONFIGS)
        self.plan = plan
        states, stop = StateMachine(), StopRequests()
        states.move(RigState.IDLE)
        self._rows = []
        with build_rig(plan.profile, backend) as rig:
            self.names = [column.name for column in rig.truth_columns]

            class Recorder:
                def write(_, cycle, t, row):
                    self._rows.append((row[0], *rig.truth()))
                    each(rig, row[1])
                    if at is not None and row[1] >= at and not stop.count:
                        stop.request()

            rig.mechanism.attach(plan.controller, plan.motion)
            plan.motion.attach(rig.devices)
            rig.arm()
            period = plan.profile.loop.period
            loop = Loop(
                clock=rig.clock, period=period, buses=tuple(rig.buses.values()),
                devices=tuple(rig.devices.values()), mechanism=rig.mechanism,
                controller=spoil(plan.controller), states=states,
            )  # fmt: skip
            self.outcome = loop.run(
                plan.motion,
                recorder=Recorder(),
                events=lambda *_: None,
                stop=stop,
                timings=Timings(approach=0.5),
            )
        # The bus is closed: from here on the plant is on its own.
        end = rig.clock.now()
        for tick in range(1, round(WATCHED / period) + 1):
            rig.clock.sleep_until(end + tick * period)
            self._rows.append((AFTER, *rig.truth()))
        self.truth = np.array(self._rows)

    def column(self, name, *phases):
        """Return the truth's column, of all cycles or of some phases."""
        values = self.truth[:, 1 + self.names.index(f"truth.{name}")]
        return values[np.isin(self.truth[:, 0], phases)] if phases else values

    def during_stop(self, name):
        return self.column(name, Phase.STOP, AFTER)

    def released(self, name):
        """Return the column since the rig has come to rest."""
        brakes = round((Timings().brake + Timings().settle) / self.plan.profile.loop.period)
        return self.during_stop(name)[brakes:]
