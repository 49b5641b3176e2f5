"""Recording a cycle's frames beside python-can's own writer, each frame with the kernel at once."""

import time
from statistics import median

import can
import pytest

from drivers.can.frame_log import FrameLog
from rig.hal import FastCanBus

CYCLES = 3000
ROUNDS = 5
BOUND_RATIO = 0.65
BOUND = 30e-6  # a cycle of the cylinder at 1 kHz: 3 %
RECEIVED = [(0x190, bytes(5)), (0x1A0, bytes(8)), (0x1A1, bytes(8))]
SENT = [(0x210, bytes(5)), (0x080, b"")]

pytestmark = pytest.mark.benchmark


class Clock:
    now = staticmethod(time.monotonic)


class Interface(FastCanBus):
    """As cheap as an interface can be, so that what is measured is the recording."""

    def drain(self, limit):
        return RECEIVED

    def send_data(self, can_id, data):
        pass


def test_frame_log_cost(tmp_path, table):
    costs = {"not recorded": [], "FrameLog": [], "can.CanutilsLogWriter and flush": []}
    for number in range(ROUNDS + 1):
        log = FrameLog()
        log.start(tmp_path / f"{number}.log")
        measured = (
            cycles(Interface()),
            cycles(log.tap("can0", Clock(), Interface())),
            stock(tmp_path / f"stock-{number}.log"),
        )
        assert log.close() is None
        if number:  # the first warms up
            for results, cost in zip(costs.values(), measured, strict=True):
                results.append(cost)
    bare, ours, theirs = map(median, costs.values())
    for what, results in costs.items():
        table(what=what, us_per_cycle=1e6 * median(results))
    table(what="ratio", ratio=(ours - bare) / theirs, bound=BOUND_RATIO)
    assert ours - bare <= BOUND_RATIO * theirs
    # A machine on which python-can's writer is slow is slow at this as well.
    assert ours - bare <= BOUND or theirs > BOUND / BOUND_RATIO


def cycles(bus):
    """Return the CPU time of a cycle, s."""
    began = time.process_time()
    for _ in range(CYCLES):
        bus.drain(256)
        for can_id, data in SENT:
            bus.send_data(can_id, data)
    return (time.process_time() - began) / CYCLES


def stock(path):
    """Return the CPU time of a cycle, s."""
    with can.CanutilsLogWriter(path) as writer:
        began = time.process_time()
        for _ in range(CYCLES):
            now = time.time()
            for can_id, data in (*RECEIVED, *SENT):
                writer(
                    can.Message(
                        timestamp=now, arbitration_id=can_id, data=data, is_extended_id=False,
                        channel="can0",
                    )
                )  # fmt: skip
                writer.file.flush()
        return (time.process_time() - began) / CYCLES
