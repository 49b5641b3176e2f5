"""What an hour costs in memory: the server's, and that of a page in a real browser.

A run of an hour is written thirty times as fast as it would come, by who holds the folder's lock as
a run does; a page follows it with four panes and the scene. The rows are those of a real run.
"""

import itertools
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rig.run_folder import RunFolder, RunStatus
from rig.runtime.log import read_log
from rig.runtime.recorder import LogRecorder

sys.path.insert(0, str(Path(__file__).parents[1] / "integration"))
from watched import served_folder, server_of

pytest.importorskip("aiohttp")
sync_api = pytest.importorskip("playwright.sync_api", reason="pip install playwright")

CHROMIUM = shutil.which("chromium")
pytestmark = [
    pytest.mark.benchmark,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium"),
]
HOUR, FASTER = float(os.environ.get("RIG_HOUR", "3600")), 30.0
LOOKS = (0.1, 0.5, 1.0)
"""Shares of the hour after which memory is looked at."""


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    out = tmp_path_factory.mktemp("real")
    command = [sys.executable, "-m", "rig", "run", "cylinder-step", "--on", "sim", "--no-report"]
    subprocess.run([*command, "--out", str(out)], check=True, capture_output=True)
    (folder,) = out.iterdir()
    return folder


def memory_of(pid):
    text = Path(f"/proc/{pid}/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", text)[1])


def memory_of_page(chrome, renderers):
    """Return the least that the page's processes have had within a second, tidied up."""
    seen = []
    for _ in range(5):
        chrome.send("HeapProfiler.collectGarbage")
        time.sleep(0.2)
        seen.append(sum(memory_of(process) for process in renderers))
    return min(seen)


def test_memory_is_flat_over_an_hour(real, tmp_path, table):
    log = read_log(real / "log.mcap")
    folder = RunFolder.create(
        tmp_path, "hour", "sim", rig="cylinder", law="cascade",
        inputs={name: (real / name).read_text() for name in ("profile.yaml", "experiment.yaml")},
    )  # fmt: skip
    period = float(log.t[1] - log.t[0])
    rows = itertools.cycle([tuple(row) for row in log.values.tolist()])
    seen = []
    with (
        sync_api.sync_playwright() as driver,
        LogRecorder(folder.log_path, log.columns) as recorder,
        served_folder(folder.path) as address,
    ):
        recorder.write(0, 0.0, next(rows))
        browser = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page(viewport={"width": 800, "height": 600})
        page.goto(address)
        chrome = page.context.new_cdp_session(page)
        renderers = [
            process["id"]
            for process in browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")[
                "processInfo"
            ]
            if process["type"] == "renderer"
        ]
        server, begun, cycle = server_of(folder.path), time.monotonic(), 1
        for share in LOOKS:
            while cycle * period < share * HOUR:
                due = min((time.monotonic() - begun) * FASTER, share * HOUR)
                while cycle * period < due:
                    recorder.write(cycle, cycle * period, next(rows))
                    cycle += 1
                    if not cycle % 60_000:
                        folder.record_event(cycle * period, "mark", "a minute has passed")
                page.wait_for_timeout(50)
            page.wait_for_timeout(2000)
            assert page.evaluate("board.status.t") > share * HOUR - 2.0  # it has kept up
            seen.append((memory_of(server), memory_of_page(chrome, renderers)))
            table(
                what=f"after {share * HOUR / 60:.0f} min", log=folder.log_path.stat().st_size,
                server=seen[-1][0], page=seen[-1][1],
            )  # fmt: skip
        browser.close()
    folder.finish(RunStatus.OK, 0)
    for early, late in zip(seen[1], seen[2], strict=True):
        assert late <= 1.05 * early
    assert seen[-1][0] <= 150e6
