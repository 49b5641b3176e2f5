"""Setpoints of regulators that are lost or late for good: found by what the module says it got."""

import random

import numpy as np
import pytest
from stop_bench import Stopped

from drivers.sim.frame_faults import LASTING, FrameFault
from rig.assembly import Backend
from rig.hal import DeviceFault

DRAWN = random.Random(6)
SINE = (
    "reference.amplitude=8 mm",
    "reference.tones=[{frequency: 1 Hz, periods: 2}]",
)
SETPOINTS = 0x210
LIMIT = 20e-3
"""Of the cylinder's position, as its profile says, m."""


def run(at, *faults):
    """Follow a sine, with faults of the setpoints' frames from instants on, s."""
    waiting = list(zip(at, faults, strict=True))

    def each(rig, t):
        while waiting and t >= waiting[0][0]:
            rig.clock.world.add_frame_fault("can0", waiting.pop(0)[1])

    options = (*SINE, f"simulation.seed={DRAWN.randrange(1000)}")
    return Stopped("cylinder-sine", options, Backend.VIRTUAL, None, each=each)


@pytest.mark.parametrize(
    ("kind", "value", "at"),
    [("drop", 0.0, DRAWN.uniform(0.1, 1.9)) for _ in range(4)]
    + [("delay", 0.05, DRAWN.uniform(0.1, 1.9)) for _ in range(4)],
)
def test_setpoints_that_do_not_arrive_in_time_are_a_fault(kind, value, at):
    stopped = run([at], FrameFault(kind, SETPOINTS, count=LASTING, value=value))
    fault = stopped.outcome.fault
    assert isinstance(fault, DeviceFault)
    assert "setpoints of" in str(fault)
    assert "do not arrive, or come late" in str(fault)
    assert fault.device == "regulators"
    assert np.abs(stopped.column("position")).max() < LIMIT


def test_a_few_that_are_lost_are_ridden_through():
    at = sorted(DRAWN.uniform(0.1, 1.9) for _ in range(5))
    assert run(at, *[FrameFault("drop", SETPOINTS)] * 5).outcome.fault is None


@pytest.mark.parametrize("at", [DRAWN.uniform(0.1, 1.9) for _ in range(3)])
def test_a_module_that_was_made_safe_goes_on_to_say_what_it_measures(at):
    """The safe setpoint is none that the controller sent, and yet it is not missing."""
    ages = []

    def each(rig, t):
        if t >= at:
            regulators = rig.devices["regulators"]
            regulators.make_safe()
            ages.append(rig.clock.now() - regulators.pressure().t)

    options = (*SINE, f"simulation.seed={DRAWN.randrange(1000)}")
    Stopped("cylinder-sine", options, Backend.VIRTUAL, at + 0.1, each=each)
    assert len(ages) > 25
    assert max(ages) < 5e-3


@pytest.mark.parametrize(
    ("at", "bytes_left"), [(DRAWN.uniform(0.1, 1.9), DRAWN.randrange(4)) for _ in range(6)]
)
def test_a_module_that_cannot_be_told_to_vent_is_stopped_and_vents(at, bytes_left):
    """The first short frame is a fault, and the safe setpoints after it are as short."""
    stopped = run([at], FrameFault("truncate", SETPOINTS, count=LASTING, value=bytes_left))
    assert "wrong length" in str(stopped.outcome.fault)
    assert np.abs(stopped.column("position")).max() < LIMIT
