"""What a run notices of those who watch it: nothing.

Runs in real time with and without a page that five look at, two of which do not read what they are
sent, turn by turn; the cycle's lateness and the ticks that it missed are compared.
"""

import asyncio
import contextlib
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np
import pytest

from rig.runtime.log import read_log

sys.path.insert(0, str(Path(__file__).parents[1] / "integration"))
from watched import LOCAL, paced_run, server_of, watched_run

aiohttp = pytest.importorskip("aiohttp")
pytestmark = pytest.mark.benchmark

COLUMNS, SECONDS = 40, 10.0
ROUNDS = 3
GROUP, RATE, SETTLE = "udp_multicast:239.74.163.51", 200.0, 4.0
TICKS = os.sysconf("SC_CLK_TCK")


async def look(session, run, seconds, received, *, stalls=False):
    page = await session.ws_connect(
        f"http://{LOCAL}:{run.port}/ws", origin=f"http://{LOCAL}:{run.port}", max_msg_size=0
    )
    await page.send_json({"type": "open", "token": run.token})
    heard, size, until = 0, 0, time.monotonic() + seconds
    while time.monotonic() < until:
        message = await page.receive(10.0)
        heard += 1
        size += len(message.data or b"")
        if message.type is aiohttp.WSMsgType.TEXT:
            told = message.json()
            if told["type"] == "status":
                await page.send_json({"type": "here", "heard": heard})
            if told["type"] == "hello" and told["columns"]:
                columns = [k % len(told["columns"]) for k in range(COLUMNS)]
                await page.send_json(
                    {"type": "follow", "id": 1, "columns": columns, "seconds": 10.0}
                )
                if stalls:
                    await asyncio.sleep(until - time.monotonic())
                    return
        elif message.type is not aiohttp.WSMsgType.BINARY:
            return
    received.append(size / seconds)
    await page.close()


def watch(run, viewers, stalled=0):
    """Return the share of a core that the server takes, and the bytes a second of each page."""
    received = []

    async def work():
        async with aiohttp.ClientSession() as session:
            await asyncio.gather(
                *(look(session, run, SECONDS, received) for _ in range(viewers - stalled)),
                *(look(session, run, SECONDS, received, stalls=True) for _ in range(stalled)),
            )

    before, begun = used(run), time.monotonic()
    asyncio.run(work())
    return (used(run) - before) / (time.monotonic() - begun), received


def used(run):
    fields = Path(f"/proc/{server_of(run.folder)}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def memory(run):
    status = Path(f"/proc/{server_of(run.folder)}/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", status)[1])


def test_a_page_costs_little(tmp_path, table):
    with watched_run(tmp_path, "cylinder-sine", "--on", "sim", steer=False) as run:
        one, [rate] = watch(run, 1)
        five, rates = watch(run, 5)
        took = memory(run)
    table(
        what=f"{COLUMNS} channels x 10 s at 10 Hz, scene at 30 Hz",
        core_for_one=one, core_for_five=five, bytes_per_second=rate, least_of_five=min(rates),
        memory=took,
    )  # fmt: skip
    assert one <= 0.25
    assert five <= 0.4
    assert max(rate, *rates) <= 2e6
    assert min(rates) >= 0.8 * rate  # none was left out
    assert took <= 150e6


@pytest.mark.parametrize(
    ("experiment", "key"),
    [("cylinder-sine", "position_rate"), ("joint-circle-camera", "pair.position_rate")],
)
def test_who_steers_needs_little_room(tmp_path, table, experiment, key):
    """Also once a change was asked for, which takes the law and its loop's margins."""

    async def ask(run):
        async with aiohttp.ClientSession() as session:
            page = await session.ws_connect(
                f"http://{LOCAL}:{run.port}/ws", origin=f"http://{LOCAL}:{run.port}"
            )
            await page.send_json({"type": "open", "token": run.steer.partition("#")[2]})
            wish = {"type": "gain", "key": key, "value": 100.0, "ramp": 1.0, "sure": False}
            await page.send_json(wish)
            while True:
                message = await page.receive(30.0)
                if message.type is aiohttp.WSMsgType.TEXT and message.json()["type"] == "steered":
                    return message.json()["message"]

    with watched_run(tmp_path, experiment, "--on", "sim") as run:
        watch(run, 5)
        before = memory(run)
        assert asyncio.run(ask(run)).endswith("?")
        after = memory(run)
    table(what=f"memory with --steer: {experiment}", before=before, asked=after)
    assert after <= 150e6


def test_the_cycle_is_not_disturbed(tmp_path, table):
    """By what the cycles' work takes, which needs no real-time priority to be compared."""
    alone, watched = [], []
    for turn in range(ROUNDS):
        with paced_run(tmp_path / f"{turn}-alone") as folder:
            time.sleep(SECONDS)
        alone.append(work_of(folder))
        with watched_run(tmp_path / f"{turn}", "cylinder-sine", "--on", "sim", steer=False) as run:
            watch(run, 5, stalled=2)
        watched.append(work_of(run.folder))
    ratio = median(watched) / median(alone)
    table(what="p99 of a cycle's work", alone=median(alone), watched=median(watched), ratio=ratio)
    assert ratio <= 1.05


def test_no_more_ticks_are_missed(tmp_path, table):
    """On the wall clock and over sockets, on which another process emulates the rig."""
    words = ["--set", f"loop.rate={RATE:g} Hz"]
    missed, late = {"alone": [], "watched": []}, {"alone": [], "watched": []}
    with emulated("cylinder", GROUP, *words):
        for turn in range(2 * ROUNDS):
            how = ("alone", "watched")[turn % 2]
            where = ("cylinder-sine", "--on", GROUP, *words)
            with watched_run(tmp_path / f"{turn}", *where, steer=False) as run:
                time.sleep(SETTLE)
                if how == "watched":
                    watch(run, 5, stalled=2)
                else:
                    time.sleep(SECONDS)
            log = read_log(run.folder / "log.mcap")
            here = log.t > log.t[-1] - 0.9 * SECONDS
            missed[how].append(int(np.sum(np.diff(log.cycle[here].astype(np.int64)) - 1)))
            late[how].append(float(np.percentile(log.column("timing.lateness")[here], 99)))
    for how, counts in missed.items():
        table(what=f"ticks missed of {0.9 * SECONDS * RATE:.0f}, {how}",
              rounds=" ".join(map(str, counts)), wake_up_p99=median(late[how]))  # fmt: skip
    assert sum(missed["watched"]) <= 1.05 * sum(missed["alone"]) + 1


@contextlib.contextmanager
def emulated(rig, on, *words):
    process = subprocess.Popen(
        [sys.executable, "-m", "rig", "simulate", rig, "--on", on, *words],
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert any("Ctrl-C" in line for line in process.stderr), "it has not begun"
        yield
    finally:
        process.terminate()
        process.communicate()


def work_of(folder):
    """Return the 99th percentile of what the last cycles took, s."""
    log = read_log(folder / "log.mcap")
    late = log.t > log.t[-1] - 0.9 * SECONDS
    steps = ("receive", "read", "control", "transmit", "record")
    return float(np.percentile(sum(log.column(f"timing.{step}")[late] for step in steps), 99))
