"""One whole cycle beside the same work with stock packages, on the same sockets and frames.

Ours is the loop of a real run: the production drivers on `SocketCanBus`, whose other end is held
by the emulated nodes. What these send is written down and fed to the other stack. Only the
cycle's own CPU time counts, on both sides; feeding does not.

A tenth is what is wanted. On three frames a cycle it is not reached: measured were 0.18 of a stack
that drains the bus in its cycle and 0.13 of one that receives as canopen's documentation says. A
third to a half of ours are system calls, which the other side pays as well. The table shows what is
wanted; the bounds keep what was reached.
"""

import socket
import time
from statistics import median

import can
import pytest
from bench_rig import armed_rig, cylinder_profile, run
from stock_stack import PERIOD, StockCycle

from drivers.can.socketcan import SocketCanBus
from rig.assembly import Backend
from rig.runtime.log import read_log

SECONDS = 5.5
ROUNDS = 3
THREADED_CYCLES = 500
WANTED = 0.1
BOUND_DRAINED = 0.25
BOUND_THREADED = 0.17

pytestmark = pytest.mark.benchmark


def test_cycle_cost(tmp_path, table, monkeypatch):
    names = ("rig", "stock, bus drained in the cycle", "stock, canopen's receiving thread")
    rounds = {name: [] for name in names}
    for number in range(ROUNDS + 1):
        log = tmp_path / f"ours-{number}.mcap"
        costs, fed = our_cycles(monkeypatch, log)
        columns = read_log(log).columns
        assert len(costs) > 0.9 * SECONDS / PERIOD
        results = [median(costs)]
        for threaded in (False, True):
            path = tmp_path / f"stock-{threaded}-{number}.mcap"
            some = fed[:THREADED_CYCLES] if threaded else fed
            results.append(stock_cycles(monkeypatch, path, some, columns, threaded))
        if number:  # the first compiles the plant and fills caches
            for name, result in zip(names, results, strict=True):
                rounds[name].append(result)
    ours, drained, threaded = (median(rounds[name]) for name in names)
    for name, results in rounds.items():
        table(
            what=name,
            us=1e6 * median(results),
            rig_over_it=ours / median(results),
            rounds=" ".join(f"{1e6 * cost:.1f}" for cost in results),
        )
    table(
        what="wanted",
        ratio=WANTED,
        reached=ours <= WANTED * drained,
        frames_in_per_cycle=sum(len(frames) for frames in fed) / len(fed),
    )
    assert ours <= BOUND_DRAINED * drained
    assert ours <= BOUND_THREADED * threaded


class FarEnd(SocketCanBus):
    """The emulated nodes' end of the socket pair; keeps what they send."""

    def __init__(self, sock):
        super().__init__(sock, "far")
        self.sent = []

    def send(self, msg, timeout=None):
        self.sent.append((msg.arbitration_id, bytes(msg.data)))
        super().send(msg)


class CycleCosts:
    """The rig's clock; counts the CPU time from the end of one sleep to the next sleep."""

    def __init__(self, clock, far):
        self.now = clock.now
        self.costs = []
        self.fed = []
        self._clock = clock
        self._far = far
        self._woke = None

    def sleep_until(self, t):
        slept = time.process_time()
        if self._woke is not None:
            self.costs.append(slept - self._woke)
        self._clock.sleep_until(t)
        self.fed.append(self._far.sent)
        self._far.sent = []
        self._woke = time.process_time()


def our_cycles(monkeypatch, log):
    """Return the CPU time of each cycle of a run, s, and the frames that came before each."""
    near, far = _pair()
    end = FarEnd(far)
    with monkeypatch.context() as patch:
        patch.setattr("can.Bus", lambda **_: end)
        patch.setattr("drivers.can.open_bus", lambda _: SocketCanBus(near, "near"))
        with armed_rig(Backend.VIRTUAL) as rig:
            end.sent = []
            clock = CycleCosts(rig.clock, end)
            done = run(rig, log, SECONDS, clock=clock)
    # The first cycle came before the first sleep, and the last one goes on to make safe.
    whole = done.outcome.cycles - 2
    return clock.costs[:whole], clock.fed[:whole]


def stock_cycles(monkeypatch, log, fed, columns, threaded):
    """Return the CPU time of a stock cycle, s, fed with the same frames."""
    near, far = _pair()
    feeder = SocketCanBus(far, "far")
    with monkeypatch.context() as patch, log.open("wb") as file:
        module = "can.interfaces.socketcan.socketcan"
        patch.setattr(f"{module}.create_socket", lambda: near)
        patch.setattr(f"{module}.bind_socket", lambda *_: None)
        patch.setattr(f"{module}.log.disabled", True)  # of options that only CAN sockets have
        bus = can.Bus(interface="socketcan", channel="can0", ignore_config=True)
        cycle = StockCycle(cylinder_profile(), bus, len(columns), file, threaded=threaded)
        costs = []
        began = time.process_time()
        for k, frames in enumerate(fed):
            feeding = time.thread_time()
            for can_id, data in frames:
                feeder.send_data(can_id, data)
            if threaded:
                time.sleep(PERIOD / 2)
            feeding = time.thread_time() - feeding
            if not threaded:
                began = time.process_time()
            cycle.step(k * PERIOD)
            ended = time.process_time()
            # The thread works while this one sleeps, so its whole time since is counted.
            costs.append(ended - began - (feeding if threaded else 0.0))
            sent = feeder.drain()
            assert len(sent) == 2, sent  # setpoints and SYNC
            began = time.process_time()
        cycle.close()
        assert threaded or cycle.frames == sum(len(frames) for frames in fed)
    feeder.shutdown()
    return median(costs)


def _pair():
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
