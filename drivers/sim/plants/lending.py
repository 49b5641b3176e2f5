"""A pneumatic plant with its devices as one kernel, for loops that run compiled as a whole.

What such a loop sees is what `drivers.sim.direct` shows: readings that are quantised and one cycle
old, setpoints that act in their own cycle.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple, cast

import numba
import numpy as np

from drivers.sim.plants.compiled import Record
from drivers.sim.plants.pneumatics import ATMOSPHERE

Kernel = Callable[..., None]
Memory = tuple[Record, ...]

DEVICES = np.dtype(
    [
        (name, float)
        for name in (
            "is_filtered",  # 1: the monitor sees the outlet through its filter, 0: the chamber
            "monitor_gain",
            "monitor_zero",  # Pa
            "monitor_noise",  # Pa rms
            "monitor_step",  # of its converter, Pa
            "rod_noise",  # m rms
            "rod_step",  # of its encoder, m
            "least",  # of the converter that drives the actuator: a pressure, Pa, or an opening
            "span",  # of it
            "codes",  # its steps
        )
    ]
)
"""Errors and resolutions of one channel's devices."""

_SAMPLES = 4096
"""Of noise, which go round."""


class Lending(NamedTuple):
    """The loop that a plant is lent to.

    Parameters
    ----------
    period : float
        s.
    rod_step, pressure_step : float
        The finest steps of encoders (m) and monitors (Pa).
    seed : int
        Of the devices' noise.
    """

    period: float
    rod_step: float
    pressure_step: float
    seed: int


def memory_of(bodies: tuple[Record, ...], devices: Record, of: Lending, dt: float) -> Memory:
    """Return what the kernel of `exchange_of` works on.

    Parameters
    ----------
    bodies : tuple of ndarray
        What the plant's own kernel takes before steps and substep; the channels come first.
    devices : ndarray, shape (n,)
        `DEVICES` of each channel, without their steps.
    of : Lending
        The loop.
    dt : float
        The substep, s.
    """
    devices["rod_step"], devices["monitor_step"] = of.rod_step, of.pressure_step
    noise = np.random.default_rng(of.seed).standard_normal((_SAMPLES, 2, len(devices)))
    steps = np.array([round(of.period / dt)])
    return bodies, devices, noise, np.zeros(1, np.int64), steps, np.array([dt])


@cache
def exchange_of(advance: Kernel, tell: Kernel) -> Kernel:
    """Return the compiled function of `rig.hal.plant.LentPlant`.

    Parameters
    ----------
    advance : callable
        The plant's own kernel: ``advance(*bodies, steps, dt)``.
    tell : callable
        Compiled: ``tell(bodies, truth)`` writes what is true of the axes.
    """

    def exchange(memory: Memory, setpoints: Record, seen: Record, truth: Record) -> None:
        bodies, devices, noise, at, steps, dt = memory
        channels = bodies[0]
        count = len(channels)
        now = noise[at[0]]
        at[0] = (at[0] + 1) % len(noise)
        for k in range(count):
            channel, device = channels[k], devices[k]
            rod = channel.extension + device.rod_noise * now[0, k]
            seen[k] = np.rint(rod / device.rod_step) * device.rod_step
            pressure = channel.pressure - ATMOSPHERE
            shown = device.monitor_gain * (channel.monitor if device.is_filtered else pressure)
            shown += device.monitor_zero + device.monitor_noise * now[1, k]
            seen[count + k] = np.rint(shown / device.monitor_step) * device.monitor_step
            share = min(max((setpoints[k] - device.least) / device.span, 0.0), 1.0)
            code = np.floor(share * device.codes + 0.5)
            channel.setpoint = device.least + code / device.codes * device.span
        advance(*(bodies + (steps[0], dt[0])))  # noqa: RUF005 - what numba understands
        tell(bodies, truth)

    return cast(Kernel, numba.njit(error_model="numpy")(exchange))
