"""Readings that come late bear the time of the SYNC that they answer, and not of the latest."""

import random
from functools import partial

import pytest
from stop_bench import Stopped

from drivers.sim.frame_faults import LASTING, FrameFault
from rig.assembly import Backend
from rig.hal import DeviceError, StaleReading

DRAWN = random.Random(1007)
SINE = ("reference.tones=[{frequency: 1 Hz, periods: 2}]", "reference.amplitude=8 mm")
RIGS = {
    "cylinder-sine": (SINE, ("encoder-agonist", "encoder-antagonist", "regulators"), 1e-3, 15e-3),
    "arm-wrist-hit": ((), ("drives",), 5e-3, 30e-3),
}
LEARNT = 8
"""Cycles after the first late reading until its lag is known."""


class Late:
    """A run in which the frames of a device come late from an instant on.

    Attributes
    ----------
    errors : list of float
        By how much a reading's time is that of another SYNC than its own, s: in each cycle.
    """

    def __init__(self, experiment, device, delay, at, *, lost=0, twice=False):
        options, _, self.period, _ = RIGS[experiment]
        self.errors, self.lost, self.syncs = [], lost, []
        self._device, self._delay, self._at = device, delay, at
        self._twice = twice
        self._sent = []
        self._started, self._cycles, self.late_from = None, 0, 0
        options = (*options, f"simulation.seed={DRAWN.randrange(1000)}")
        self.run = Stopped(experiment, options, Backend.VIRTUAL, at + 0.4, each=self._each)
        self.fault = self.run.outcome.fault

    def _each(self, rig, t):
        world, now = rig.clock.world, rig.clock.now()
        self._cycles += 1
        frames = world.frames_of(self._device)
        self.statistics = rig.buses[frames.bus].statistics()
        if self._started is None:
            if t < self._at:
                return
            self._started, self.late_from = now, self._cycles
            for can_id in frames.from_device:
                for kind, value, count in self._faults():
                    fault = FrameFault(kind, can_id, count=count, value=value)
                    world.add_frame_fault(frames.bus, fault)
            self._spy(rig, frames)
            return
        device = rig.devices[self._device]
        reading = next(
            getattr(device, name)() for name in ("position", "positions", "pressure")
            if hasattr(device, name)
        )  # fmt: skip
        # Its own SYNC was sent right before the answer whose delay is over.
        arrived = [sent for sent in self._sent if sent + self._delay < now - 1e-4]
        if now > self._started + self._delay + LEARNT * self.period and arrived:
            self.errors.append(abs(arrived[-1] - reading.t))

    def _faults(self):
        if self._delay:
            yield "delay", self._delay, LASTING
        if self.lost:
            yield "drop", 0.0, self.lost
        if self._twice:
            yield "duplicate", 0.0, LASTING

    def _spy(self, rig, frames):
        """Note when the device's last frame of each cycle is sent, before anything delays it."""
        bus = next(b for b in rig.clock.world.buses if b.name == frames.bus)
        last = frames.from_device[-1]

        def spied(send, can_id, data):
            if can_id == last:
                self._sent.append(rig.clock.world.time)
            send(can_id, data)

        for node in bus.nodes:
            node.send = partial(spied, node.send)


def draw(count, most):
    cases = []
    for _ in range(count):
        experiment = DRAWN.choice(list(RIGS))
        _, devices, period, _ = RIGS[experiment]
        delay = DRAWN.uniform(0.2e-3, most[experiment])
        if DRAWN.random() < 0.5:  # the phase does not show whole cycles
            delay = max(1, round(delay / period)) * period
        cases.append((experiment, DRAWN.choice(devices), delay, DRAWN.uniform(0.05, 0.4)))
    return cases


@pytest.mark.parametrize(
    ("experiment", "device", "delay", "at"),
    [*draw(10, {"cylinder-sine": 4e-3, "arm-wrist-hit": 20e-3}),
     ("cylinder-sine", "encoder-agonist", 2e-3, 0.2), ("arm-wrist-hit", "drives", 20e-3, 0.2)],
)  # fmt: skip
def test_late_reading_bears_the_time_of_its_own_sync(experiment, device, delay, at):
    late = Late(experiment, device, delay, at)
    assert late.fault is None
    assert len(late.errors) > 20
    assert max(late.errors) < 0.5e-3
    assert (late.statistics["late_samples"] > 20) == (delay > 0.9 * late.period)


@pytest.mark.parametrize(
    ("experiment", "device", "delay", "at"),
    draw(6, {"cylinder-sine": 30e-3, "arm-wrist-hit": 30e-3}),
)
def test_reading_is_never_used_when_it_is_too_old(experiment, device, delay, at):
    age, period = RIGS[experiment][3], RIGS[experiment][2]
    late = Late(experiment, device, max(delay, age), at)
    assert isinstance(late.fault, DeviceError | StaleReading)
    assert device in str(late.fault)
    assert not late.errors or max(late.errors) < 0.5e-3
    assert (late.run.outcome.cycles - late.late_from) * period < 2.0 * age


@pytest.mark.parametrize("lost", [1, 2, 3])
def test_answers_that_were_lost_leave_the_next_ones_fresh(lost):
    late = Late("cylinder-sine", "encoder-antagonist", 0.0, DRAWN.uniform(0.05, 0.4), lost=lost)
    assert late.fault is None
    assert max(late.errors) < 1.5e-3  # at most the SYNC that is left out
    assert late.statistics["late_samples"] == 0
    assert late.statistics["omitted_syncs"] == 1


def test_answers_that_come_twice_are_not_late():
    late = Late("cylinder-sine", "encoder-agonist", 0.0, 0.2, twice=True)
    assert late.fault is None
    assert late.statistics["late_samples"] == late.statistics["omitted_syncs"] == 0
