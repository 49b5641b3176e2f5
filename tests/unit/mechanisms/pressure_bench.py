"""Regulators whose pressures a test moves, under the watch that follows them."""

import pytest
from joint_fakes import CHANNELS

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.settings import RegulatorModel

STEP, TIME, DEVIATION, START = 2.0**-10, 2.0**-6, 40e3, 200e3
CYCLES = round(TIME / STEP)
"""So many cycles a pressure may be off."""
NEVER = 1e12
LOOP = 2.5e3
CALM = {"deviation": NEVER, "slow": NEVER, "offset": 12e3}
"""The mean alone."""
ATTENTIVE = {
    "deviation": DEVIATION,
    "time": TIME,
    "offset": NEVER,
    "slow": NEVER,
    "loop": LOOP,
}
"""The deviation and its time alone."""


def pressure_bounds(**alarm):
    """Return attentive bounds with others put in; a setpoint that stands is given as much time."""
    said = ATTENTIVE | alarm
    as_late = {"unasked": said["time"], "stray": said["deviation"]}
    return PressureBounds(**(as_late | said))


class Bench:
    """Regulators that were well and have held one pressure."""

    def __init__(self, response=None, starts=(START,) * 4, **alarm):
        self.watch = PressureWatch(
            pressure_bounds(**alarm),
            response or RegulatorModel(dead_time=0.0),
            CHANNELS,
            "valves",
        )
        self.now = 0.0
        self.starts = starts
        self.watch.send(starts)
        self.pass_by(2)

    def pass_by(self, cycles, **off):
        """Let time pass with some channels off what they should be, Pa."""
        for _ in range(cycles):
            self.now += STEP
            off_now = [off.get(name, 0.0) for name in CHANNELS]
            shown = [start + one for start, one in zip(self.starts, off_now, strict=True)]
            self.watch.check(tuple(shown), self.now)

    def what(self, **off):
        """Return what is said as soon as it has lasted."""
        self.pass_by(CYCLES, **off)
        with pytest.raises(SafetyError) as caught:
            self.pass_by(1, **off)
        return str(caught.value)
