"""Frames on SocketCAN: a run records them while another program shows the same ones live."""

import json
import shutil
import subprocess
import sys

import pytest
from two_processes import Program, only_run, pause, simulate

from drivers.can.candump import parse_lines

pytestmark = pytest.mark.vcan
LINK = "vcan2"
SHORT = [
    word
    for option in (
        "loop.rate=200 Hz",
        "reference.dwell=0.3 s",
        "reference.rise=0 s",
        "reference.size=1 mm",
        "reference.repeats=1",
    )
    for word in ("--set", option)
]


@pytest.fixture(scope="module", autouse=True)
def devices():
    with simulate("cylinder", LINK, "--set", "loop.rate=200 Hz") as program:
        yield
        assert program.stop() == 0


def content(line):
    shown = json.loads(line)
    return int(shown["id"], 16), shown["data"]


def test_what_is_shown_live_is_what_is_on_file(tmp_path):
    log = tmp_path / "candump.log"
    with (
        log.open("wb") as target,
        Program("monitor", "cylinder", "--frames", "--on", LINK, "--json") as monitor,
        subprocess.Popen(["candump", "-L", LINK], stdout=target) as candump,
    ):
        monitor.wait_for("listening on")
        try:
            runs = tmp_path / "runs"
            with Program(
                "run", "cylinder-step", "--on", LINK, "--frames", "--no-report", "--out", runs,
                *SHORT,
            ) as run:  # fmt: skip
                assert run.end() in (0, 1), run.talk
            _, folder = only_run(runs)
            pause(0.2)  # until everybody has looked
            assert monitor.stop() == 0
        finally:
            candump.terminate()
    recorded = read(folder / "frames.log")
    shown = [content(line) for line in monitor.printed]
    theirs = read(log)
    # Others also hear what the devices said before the run opened the bus, and after.
    assert missing(recorded, shown) == missing(recorded, theirs) == []
    assert len(recorded) > 300


def read(path):
    with path.open() as lines:
        return [(f.can_id, f.data.hex().upper()) for f in parse_lines(lines, str(path))]


def missing(wanted, heard):
    """Return the first frame of each side, with its number, that another program did not hear.

    Each side's own frames come in their order; how the two sides' are interleaved differs by
    where one listens.
    """
    first = []
    for side in (is_masters, lambda frame: not is_masters(frame)):
        rest = iter([frame for frame in heard if side(frame)])
        for number, frame in enumerate(filter(side, wanted)):
            if not any(frame == other for other in rest):
                first.append((number, frame))
                break
    return first


def is_masters(frame):
    return frame[0] in (0x000, 0x080, 0x210, 0x610, 0x620, 0x621, 0x77F)


@pytest.mark.skipif(shutil.which("candump") is None, reason="can-utils is not installed")
def test_candump_is_piped_into_the_monitor():
    shell = f"candump -L -n 3 {LINK} | {sys.executable} -m rig monitor cylinder --frames - --json"
    piped = subprocess.Popen(["sh", "-c", shell], stdout=subprocess.PIPE, text=True)
    with piped:
        for _ in range(100):
            if piped.poll() is not None:
                break
            subprocess.run(["cansend", LINK, "000#8110"], check=True)
            try:
                piped.wait(0.3)
            except subprocess.TimeoutExpired:
                continue
        lines = piped.stdout.read().splitlines()
    assert piped.returncode == 0
    assert len(lines) == 3
    assert all(json.loads(line)["known"] for line in lines)
