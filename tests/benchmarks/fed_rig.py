"""A rig that is fed with what the nodes of a recorded run sent, cycle by cycle.

A run on emulated nodes is recorded first: all that goes over each bus, both ways. Then the same
loop runs again, and a Feeder hands it what came before each cycle. A CAN bus is a pair of sockets,
a serial one a pseudo-terminal: the drivers' system calls are those of a real run. Only the cycle's
own processor time counts.
"""

import contextlib
import os
import time
import tty
from statistics import median
from typing import NamedTuple

import numpy as np
from test_cycle_cost import CycleCosts, FarEnd, SocketLine, _pair, clock_cost

from drivers.can.socketcan import SocketCanBus
from drivers.dynamixel.port import TtyPort
from drivers.sim.dynamixel.line import MemoryPort
from rig.assembly import Backend, build_rig
from rig.runtime.cycle import RUN_COLUMNS, TIMING_COLUMNS
from rig.runtime.log import read_log
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.recorder import LogRecorder
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

CYCLES = 2500
"""Of a run that are compared, from the first one of the motion on."""


class Recorded(NamedTuple):
    """What a run exchanged and logged.

    Parameters
    ----------
    came, went : list of mapping
        By cycle and bus: frames (or bytes) before it, and those that it sent.
    log : Log
        Its rows.
    first : int
        The first cycle of the motion.
    """

    came: list
    went: list
    log: object
    first: int


class Costs(NamedTuple):
    """Processor time of a cycle, and of the law in it, s."""

    cycle: float
    law: float


class HearingEnd(FarEnd):
    """The nodes' end of a pair of sockets; keeps what goes either way."""

    def __init__(self, sock):
        super().__init__(sock)
        self.heard = []

    def send_data(self, can_id, data):
        with contextlib.suppress(BlockingIOError):  # nobody reads it: the run has ended
            super().send_data(can_id, data)

    def drain(self, limit=256):
        frames = super().drain(limit)
        self.heard += frames
        return frames

    def taken(self):
        """Return what came and what went since the last time."""
        sent, heard, self.sent, self.heard = self.sent, self.heard, [], []
        return sent, heard


class HearingPort(MemoryPort):
    """The host's end of an emulated serial line; keeps what goes either way."""

    def __init__(self):
        self.came = self.went = self._waiting = b""
        super().__init__()

    @property
    def waiting(self):
        return self._waiting

    @waiting.setter
    def waiting(self, data):
        if len(data) > len(self._waiting):  # the servos have answered
            self.came += data[len(self._waiting) :]
        self._waiting = data

    def write(self, data):
        self.went += data
        return super().write(data)

    def taken(self):
        """Return what came and what went since the last time."""
        came, went, self.came, self.went = self.came, self.went, b"", b""
        return came, went


class SerialEnd:
    """The servos' end of a pseudo-terminal, whose other end the driver opens as its port."""

    def __init__(self, baudrate):
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        self.path = os.ttyname(slave)
        self.port = TtyPort(self.path, baudrate)
        self.reader = self.port._serial
        self._slave = slave  # kept open: without any user the line would hang up

    def drain(self):
        """Return what the host has sent."""
        with contextlib.suppress(BlockingIOError):
            return os.read(self._master, 1 << 16)
        return b""

    def put(self, data):
        """Hand bytes to the kernel, which passes them on."""
        if data:
            os.write(self._master, data)

    def feed(self, data):
        """Hand bytes to the host, and wait until they are there."""
        if data:
            self.put(data)
            while self.reader.in_waiting < len(data):
                pass

    def shutdown(self):
        self.port.close()
        os.close(self._slave)
        os.close(self._master)


class WritingClock:
    """The rig's clock; writes down what came and went by each sleep."""

    def __init__(self, clock, ends):
        self.now = clock.now
        self.came, self.went = [], []
        self._clock, self._ends = clock, ends

    def sleep_until(self, t):
        self._clock.sleep_until(t)
        both = {name: end.taken() for name, end in self._ends.items()}
        self.came.append({name: came for name, (came, _) in both.items()})
        self.went.append({name: went for name, (_, went) in both.items()})


class Feeder:
    """A world in which nothing happens but that what was recorded comes."""

    def __init__(self, ends, came):
        self._ends = ends
        self._came = iter(came)

    def advance(self, t):
        came = next(self._came, {})
        for name, end in self._ends.items():
            end.drain()
            feed(end, came.get(name, ()))


def feed(end, content):
    """Send frames, or bytes, as the nodes of a bus."""
    if isinstance(end, SerialEnd):
        end.feed(content)
    else:
        for can_id, data in content:
            end.send_data(can_id, data)


def record_run(monkeypatch, plan, path):
    """Run a plan on emulated nodes; return what went over its buses, and the log."""
    with rig_on_ends(monkeypatch, plan.profile) as (rig, ends):
        clock = WritingClock(rig.clock, ends)
        cycles = run(rig, plan, path, clock)
    log = read_log(path)
    first = int(np.argmax(log.column("phase") == 1))
    # The first cycle came before the first sleep.
    return Recorded(clock.came[: cycles - 1], clock.went[:cycles], log, first)


def our_cycles(monkeypatch, plan, path, recorded):
    """Return the cost of a cycle of ours, fed with what was recorded; it logs the same rows."""
    with rig_on_ends(monkeypatch, plan.profile) as (rig, ends):
        take_terminals(rig, ends)
        world, rig.clock.world = rig.clock.world, Feeder(ends, recorded.came)
        law = TimedLaw(plan.controller)
        clock = CycleCosts(rig.clock)
        run(rig, plan, path, clock, law)
        rig.clock.world = world
        for end in ends.values():
            if isinstance(end, SerialEnd):
                end.shutdown()
    log = read_log(path)
    same = [
        number
        for number, column in enumerate(log.columns)
        if column.name.partition(".")[0] not in ("timing", "truth")
    ]
    known = recorded.log.values[:, same]
    assert np.array_equal(log.values[:, same], known, equal_nan=True)
    part = slice(recorded.first, recorded.first + CYCLES)
    asking = clock_cost()
    cycle = median(clock.costs[part]) - 2.0 * asking
    return Costs(cycle, median(law.costs[:CYCLES]) - asking)


def take_terminals(rig, ends):
    """Put pseudo-terminals in the place of the emulated serial lines of an armed rig."""
    for name, bus in rig.buses.items():
        if isinstance(ends[name], HearingPort):
            end = SerialEnd(bus.settings.baudrate)
            end.feed(ends[name].waiting)  # the answer to what arming asked for last
            ends[name], bus._port = end, end.port


class TimedLaw:
    """A law, and what each of its updates took of the processor."""

    def __init__(self, law):
        self._law = law
        self.costs = []

    def __getattr__(self, name):
        return getattr(self._law, name)

    def update(self, state, reference):
        began = time.process_time()
        command = self._law.update(state, reference)
        self.costs.append(time.process_time() - began)
        return command


@contextlib.contextmanager
def rig_on_ends(monkeypatch, profile):
    """Yield the armed rig of a profile on sockets, and the other end of each bus by name."""
    ends = {}

    def line(name):
        near, far = _pair()
        ends[name] = HearingEnd(far)
        return SocketLine(near, ends[name])

    with monkeypatch.context() as patch:
        patch.setattr("drivers.sim.can_line.CanLine", line)
        patch.setattr("drivers.sim.dynamixel.line.MemoryPort", HearingPort)
        with build_rig(profile, Backend.VIRTUAL) as rig:
            for name, bus in rig.buses.items():
                if name not in ends:
                    ends[name] = bus._port
            rig.arm()
            rig.truth, rig.truth_columns = tuple, ()  # a real rig tells no truth
            for end in ends.values():
                end.taken()
            yield rig, ends
    for end in ends.values():
        if isinstance(end, SocketCanBus):
            end.shutdown()


def run(rig, plan, path, clock, law=None):
    """Run a plan's motion with a clock; return how many cycles it took."""
    law = plan.controller if law is None else law
    rig.mechanism.attach(plan.controller, plan.motion)
    plan.motion.attach(rig.devices)
    states = StateMachine()
    states.move(RigState.IDLE)
    loop = Loop(
        clock=clock, period=plan.profile.loop.period, buses=tuple(rig.buses.values()),
        devices=tuple(rig.devices.values()), mechanism=rig.mechanism, controller=law,
        states=states, truth=rig.truth,
    )  # fmt: skip
    columns = (*RUN_COLUMNS, *rig.mechanism.columns, *TIMING_COLUMNS)
    with LogRecorder(path, columns) as recorder:
        outcome = loop.run(
            plan.motion, recorder=recorder, events=lambda *_: None, stop=StopRequests(),
            timings=Timings(approach=plan.experiment.approach),
        )  # fmt: skip
    assert outcome.fault is None, outcome.fault
    return outcome.cycles
