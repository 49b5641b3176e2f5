"""From the settings of a CiA 410 inclinometer to its simulated forms."""

import math
from collections.abc import Callable
from typing import Final

from drivers.cia410.settings import PROFILE, Cia410Settings
from drivers.sim.direct.body_sensors import SimulatedInertialSensor
from drivers.sim.nodes.base import VENDOR_ID
from drivers.sim.nodes.described import EmulatedDescribed, NodeBuild, ObjectBuild
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock, MeasuredPlant

Lean = Installed[Cia410Settings, MeasuredPlant]

_TWO_AXES: Final = 0x0002_0000
"""Of the device type: an inclinometer of two axes."""


def emulate_cia410(of: Lean) -> tuple[EmulatedDescribed]:
    """Return an emulated inclinometer, mounted as the driver's settings say."""
    settings = of.built
    thousandths = round(math.degrees(settings.step) * 1000.0)
    mounted = zip(
        (settings.roll, settings.pitch, settings.roll_rate, settings.pitch_rate),
        (settings.step, settings.step, settings.rate_step, settings.rate_step),
        (settings.roll_zero, settings.pitch_zero, 0.0, 0.0),
        of.channels,
        strict=True,
    )
    objects = [ObjectBuild(0x6000, 0, "u16", thousandths)]
    objects += [
        ObjectBuild(
            axis.index,
            axis.sub,
            axis.type,
            0,
            False,
            "t",
            _counts(of, channel, -step if axis.reversed else step, zero),
        )
        for axis, step, zero, channel in mounted
    ]
    sent = tuple(tuple(entry.code for entry in layout) for layout in settings.layouts)
    build = NodeBuild(PROFILE | _TWO_AXES, VENDOR_ID, 410, of.serial or 0, tuple(objects), (), sent)
    return (EmulatedDescribed(of.name, settings.node, build),)


def _counts(of: Lean, channel: int, step: float, zero: float) -> Callable[[], float]:
    return lambda: (of.plant.channel_value(channel) + zero) / step


def simulate_cia410(of: Lean, clock: Clock) -> SimulatedInertialSensor:
    """Return a simulated sensor with the resolution of the wired one."""
    settings = of.settings
    steps = (settings.step, settings.step, settings.rate_step, settings.rate_step)
    return SimulatedInertialSensor(
        of.name, of.plant, of.channels, steps, settings.frozen_timeout, clock
    )


WIRING = Wiring(emulate_cia410, simulate_cia410)
