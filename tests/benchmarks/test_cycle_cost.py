"""One whole cycle beside the same work with stock packages, on the same sockets and frames.

A run of the cylinder rig on emulated nodes is recorded first: every frame that the nodes send.
Then both sides are fed with these frames, cycle by cycle, over a socket pair: ours is the loop of a
real run with the production drivers on `SocketCanBus`, the other is `stock_stack`. Only the cycle's
own CPU time counts; feeding and asking for the time do not. Both sides must do the same work, so
ours must log the very rows of the recorded run, and the setpoints of the other must be near them.
"""

import contextlib
import socket
import time
from itertools import pairwise
from statistics import median

import can
import numpy as np
import pytest
from bench_rig import AMPLITUDE, armed_rig, cylinder_profile, frequency_of, run
from intervals import ratio_of
from stock_stack import APPROACH, ENERGISE, PERIOD, StockCycle

from drivers.can.socketcan import SocketCanBus
from rig.assembly import Backend
from rig.runtime.log import read_log
from rig.runtime.phases import Timings

SECONDS = 7.5
ROUNDS = 9
THREADED_CYCLES = 500
RUNNING = 1  # as the log has the phase
WANTED = 0.1
NEAR = 1e3  # the two sides' setpoints while the sine runs, median of the difference, Pa

pytestmark = pytest.mark.benchmark


def test_cycle_cost(tmp_path, table, monkeypatch):
    assert Timings()[:2] == (ENERGISE, APPROACH)
    fed, recorded = record_run(monkeypatch, tmp_path / "recorded.mcap")
    names = ("rig", "stock, bus drained in the cycle", "stock, canopen's receiving thread")
    rounds = {name: [] for name in names}
    for number in range(ROUNDS + 1):
        costs = [our_cycles(monkeypatch, tmp_path / f"ours-{number}.mcap", fed, recorded)]
        for threaded in (False, True):
            path = tmp_path / f"stock-{threaded}-{number}.mcap"
            some = fed[: THREADED_CYCLES if threaded else before_the_stop(recorded)]
            costs.append(stock_cycles(monkeypatch, path, some, recorded, threaded))
        if number:  # the first fills caches
            for name, cost in zip(names, costs, strict=True):
                rounds[name].append(cost)
    ratios = {}
    for name, costs in rounds.items():
        ratios[name], low, high = ratio_of(rounds["rig"], costs)
        table(
            what=name, us=1e6 * median(costs), rig_over_it=ratios[name], low=low, high=high,
            rounds=" ".join(f"{1e6 * cost:.1f}" for cost in costs),
        )  # fmt: skip
    _, drained, threaded = ratios.values()
    table(
        what="wanted",
        ratio=WANTED,
        reached=max(drained, threaded) <= WANTED,
        frames_in_per_cycle=sum(len(frames) for frames in fed) / len(fed),
    )
    assert drained <= WANTED
    assert threaded <= WANTED


class FarEnd(SocketCanBus):
    """The emulated nodes' end of the socket pair; keeps what they send."""

    def __init__(self, sock):
        super().__init__(sock, "far")
        self.sent = []

    def send_data(self, can_id, data):
        self.sent.append((can_id, data))
        super().send_data(can_id, data)


class SocketLine:
    """A pair of sockets as the line between master and nodes."""

    def __init__(self, near, end):
        self.nodes_end = end
        self.open = lambda: SocketCanBus(near, "near")


class RecordingClock:
    """The rig's clock; writes down what came during each sleep."""

    def __init__(self, clock, end):
        self.now = clock.now
        self.fed = []
        self._clock = clock
        self._end = end

    def sleep_until(self, t):
        self._clock.sleep_until(t)
        self.fed.append(self._end.sent)
        self._end.sent = []


class Feeder:
    """A world in which nothing happens but that the frames of the next cycle come."""

    def __init__(self, end, fed):
        self._end = end
        self._fed = iter(fed)

    def advance(self, t):
        self._end.drain()
        for can_id, data in next(self._fed, ()):
            self._end.send_data(can_id, data)


class CycleCosts:
    """The rig's clock; counts the CPU time from the end of one sleep to the next sleep."""

    def __init__(self, clock):
        self.now = clock.now
        self.costs = []
        self._clock = clock
        self._woke = None

    def sleep_until(self, t):
        slept = time.process_time()
        if self._woke is not None:
            self.costs.append(slept - self._woke)
        self._clock.sleep_until(t)
        self._woke = time.process_time()


def record_run(monkeypatch, path):
    """Run the rig on emulated nodes; return the frames before each cycle, and the log."""
    with rig_on_sockets(monkeypatch) as (rig, end):
        end.sent = []
        clock = RecordingClock(rig.clock, end)
        done = run(rig, path, SECONDS, clock=clock)
    # The first cycle came before the first sleep.
    return clock.fed[: done.outcome.cycles - 1], read_log(path)


def our_cycles(monkeypatch, path, fed, recorded):
    """Return the CPU time of a cycle of ours, s, fed with the recorded frames."""
    with rig_on_sockets(monkeypatch) as (rig, end):
        world, rig.clock.world = rig.clock.world, Feeder(end, fed)
        clock = CycleCosts(rig.clock)
        run(rig, path, SECONDS, clock=clock)
        rig.clock.world = world
    log = read_log(path)
    same = [
        number
        for number, column in enumerate(log.columns)
        if column.name.partition(".")[0] not in ("timing", "truth")
    ]
    assert np.array_equal(log.values[:, same], recorded.values[:, same])
    return median(clock.costs[: len(fed)]) - clock_cost()


@contextlib.contextmanager
def rig_on_sockets(monkeypatch):
    """Yield the armed rig, whose only bus is a socket, and the nodes' end of it."""
    near, far = _pair()
    end = FarEnd(far)
    with monkeypatch.context() as patch:
        patch.setattr("drivers.sim.can_line.CanLine", lambda _: SocketLine(near, end))
        with armed_rig(Backend.VIRTUAL) as rig:
            rig.truth, rig.truth_columns = tuple, ()  # a real rig tells no truth
            yield rig, end
    end.shutdown()


def stock_cycles(monkeypatch, path, fed, recorded, threaded):
    """Return the CPU time of a stock cycle, s, fed with the same frames."""
    near, far = _pair()
    feeder = SocketCanBus(far, "far")
    with monkeypatch.context() as patch, path.open("wb") as file:
        module = "can.interfaces.socketcan.socketcan"
        patch.setattr(f"{module}.create_socket", lambda: near)
        patch.setattr(f"{module}.bind_socket", lambda *_: None)
        patch.setattr(f"{module}.log.disabled", True)  # of options that only CAN sockets have
        bus = can.Bus(interface="socketcan", channel="can0", ignore_config=True)
        width, sine = len(recorded.columns), (AMPLITUDE, frequency_of(SECONDS))
        cycle = StockCycle(cylinder_profile(), bus, width, file, sine, threaded=threaded)
        costs, applied = [], []
        began = time.process_time()
        for k, frames in enumerate(fed, 1):
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
            applied.append(cycle.applied)
            sent = feeder.drain()
            assert len(sent) in (2, 3), sent  # setpoints, SYNC and now and then a heartbeat
            began = time.process_time()
        cycle.close()
        assert threaded or cycle.frames == sum(len(frames) for frames in fed)
    feeder.shutdown()
    if not threaded:
        assert_same_setpoints(np.array(applied), recorded)
    return median(costs) - clock_cost()


def before_the_stop(recorded):
    """Return how many cycles come before ours stops and vents: the other only ever controls."""
    phases = recorded.values[:, [column.name for column in recorded.columns].index("phase")]
    return int(np.flatnonzero(phases == RUNNING)[-1]) + 1


def clock_cost():
    """Return the CPU time that asking for the CPU time takes, s; both sides are spared it."""
    asked = [time.process_time() for _ in range(1001)]
    return median(later - earlier for earlier, later in pairwise(asked))


def assert_same_setpoints(applied, recorded):
    """Compare the stock setpoints with ours while the sine runs, fed with the same readings."""
    names = [column.name for column in recorded.columns]
    ours = recorded.values[1:, [names.index("applied.agonist"), names.index("applied.antagonist")]]
    running = recorded.values[1:, names.index("phase")] == RUNNING
    apart = np.abs(ours[: len(applied)] - applied)[running[: len(applied)]]
    assert np.median(apart) < NEAR


def _pair():
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
