"""Frames of a run on file: read by the field's tools, and decoded as the run recorded itself.

One short run of the cylinder is shared by all of these; the experiments of the other rigs are
looked at as a whole in ``test_frames_of_experiments.py``.
"""

import json
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from wireshark import dissect, needs_tshark, troubles

can = pytest.importorskip("can")

from drivers.can.candump import parse_lines  # noqa: E402
from drivers.can.frame import EXTENDED_MASK  # noqa: E402
from rig.cli import invoke  # noqa: E402
from rig.runtime.log import read_log  # noqa: E402

PDOS = (0x190, 0x1A0, 0x1A1, 0x210)
CONFIGS = Path(__file__).parents[2] / "configs"
# Steps too short to settle: the bounds of the experiment are of no interest here.
SHORT = (
    "loop.rate=500 Hz",
    "reference.dwell=0.2 s",
    "reference.rise=0 s",
    "reference.size=1 mm",
    "reference.repeats=1",
    "approach=0.2 s",
)


def run(out, *options):
    """Run an experiment; return its folder."""
    settings = [word for option in SHORT for word in ("--set", option)]
    code = invoke(["run", "cylinder-step", "--out", str(out), "--no-report", *settings, *options])
    assert code in (0, 1)
    (folder,) = out.iterdir()
    return folder


def frames_of(path):
    with path.open() as lines:
        return list(parse_lines(lines, str(path)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run(tmp_path_factory.mktemp("runs"), "--frames")


@pytest.fixture(scope="module")
def frames(folder):
    return frames_of(folder / "frames.log")


def test_every_cycle_is_on_file(folder, frames):
    log = read_log(folder / "log.mcap")
    kinds = Counter(frame.can_id for frame in frames)
    manifest = json.loads((folder / "manifest.json").read_text())
    assert kinds[0x080] == manifest["buses"]["can0"]["syncs"] >= len(log.t)
    assert len(frames) >= (
        manifest["buses"]["can0"]["frames_in"] + manifest["buses"]["can0"]["frames_out"]
    )
    assert manifest["frames"] == {
        "recorded": len(frames), "lost": 0, "origin": manifest["frames"]["origin"],
    }  # fmt: skip
    times = [frame.time for frame in frames]
    assert times == sorted(times)
    assert {frame.channel for frame in frames} == {"can0"}
    assert "--frames=log" in manifest["command"]


def test_what_the_monitor_shows_is_what_the_run_recorded(folder, capfd):
    """Position and pressure, decoded from the frames, against the log of the loop."""
    assert invoke(["monitor", "cylinder", "--frames", str(folder), "--json"]) == 0
    shown = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    log = read_log(folder / "log.mcap")
    column = {column.name: log.values[:, k] for k, column in enumerate(log.columns)}
    for device, service, name, recorded in (
        ("regulators", "TPDO1", "agonist pressure", "reading.pressure_agonist"),
        ("regulators", "TPDO1", "antagonist pressure", "reading.pressure_antagonist"),
        ("regulators", "RPDO1", "agonist setpoint", "applied.agonist"),
        ("encoder-agonist", "TPDO1", "position", "reading.position_agonist"),
        ("encoder-antagonist", "TPDO1", "position", "reading.position_antagonist"),
    ):
        found = [
            value
            for line in shown
            if (line["device"], line["service"]) == (device, service)
            for value in line["values"]
            if value["name"] == name
        ]
        unit = next(item.unit for item in log.columns if item.name == recorded)
        assert {value["unit"] for value in found} == {unit}
        numbers = [value["value"] for value in found]
        expected = list(column[recorded])
        # Arming and closing exchange a few more, before and after what the loop recorded.
        starts = range(len(numbers) - len(expected) + 1)
        step = 500e3 / 32767 if unit == "Pa" else 0.0  # half of it is lost in rounding setpoints
        slack = 0.51 * step if "applied" in recorded else 1e-9 * (500e3 if unit == "Pa" else 1.0)
        assert any(
            all(abs(a - b) <= slack for a, b in zip(numbers[k:], expected, strict=False))
            for k in starts
        ), f"{device} {name} is not {recorded}"
    assert all(line["known"] for line in shown)


def test_python_can_reads_the_log(folder, frames):
    read = list(can.LogReader(str(folder / "frames.log")))
    assert [(m.arbitration_id, bytes(m.data), m.channel) for m in read] == [
        (frame.can_id & EXTENDED_MASK, frame.data, frame.channel) for frame in frames
    ]
    assert read[-1].timestamp == pytest.approx(frames[-1].time, abs=1e-6)


@pytest.mark.skipif(shutil.which("log2asc") is None, reason="can-utils is not installed")
def test_can_utils_convert_the_log(folder, frames):
    result = subprocess.run(
        ["log2asc", "-I", str(folder / "frames.log"), "can0"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines = [line.split() for line in result.stdout.splitlines()[3:]]
    assert [(int(line[2], 16), line[5:6], "".join(line[6:])) for line in lines] == [
        (frame.can_id, [str(len(frame.data))], frame.data.hex().upper()) for frame in frames
    ]


@needs_tshark
def test_wireshark_finds_nothing_malformed_and_nothing_unknown(folder, frames, record_property):
    found = dissect(folder / "frames.log")
    assert not troubles(found)
    assert sum(found.values()) == len(frames)
    syncs = sum(frame.can_id == 0x080 for frame in frames)
    assert (found["SYNC"], found["PDO1"]) == (syncs, sum(f.can_id in PDOS for f in frames))
    record_property("exchanges", ("frames of a cylinder under tshark", len(frames)))


@pytest.mark.parametrize("kind", ["asc", "blf"])
def test_other_formats_hold_the_same_frames(kind, folder, frames, tmp_path, capfd):
    from rig.assembly import REGISTRY
    from rig.assembly.frame_recording import convert_frames
    from rig.config import load_profile

    copy = shutil.copy(folder / "frames.log", tmp_path / "frames.log")
    profile = load_profile("cylinder", REGISTRY, (), [CONFIGS])
    made = convert_frames(Path(copy), kind, profile)
    assert [path.name for path in tmp_path.iterdir()] == [f"frames.{kind}"]
    read = list(can.LogReader(str(made)))
    assert [(m.arbitration_id, bytes(m.data)) for m in read] == [
        (frame.can_id, frame.data) for frame in frames
    ]
    gaps = [abs((m.timestamp - read[0].timestamp) - (frame.time - frames[0].time))
            for m, frame in zip(read, frames, strict=True)]  # fmt: skip
    assert max(gaps) < 5e-6
    assert invoke(["monitor", "cylinder", "--frames", str(made), "--for", "0.1"]) == 0
    ours = capfd.readouterr().out.splitlines()
    assert invoke(["monitor", "cylinder", "--frames", str(folder), "--for", "0.1"]) == 0
    theirs = capfd.readouterr().out.splitlines()
    assert [line[14:] for line in ours] == [line[14:] for line in theirs]


@pytest.mark.slow
def test_a_killed_run_leaves_every_frame_and_a_log_that_is_read(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "rig", "run", "cylinder-sine", "--frames", "--out", str(tmp_path)],
        stderr=subprocess.DEVNULL,
    )
    deadline = time.monotonic() + 60.0
    while not any(path.stat().st_size > 100_000 for path in tmp_path.glob("*/log.mcap")):
        assert time.monotonic() < deadline, "it never ran"
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    (folder,) = tmp_path.iterdir()
    cycles = len(read_log(folder / "log.mcap").t)
    syncs = sum(frame.can_id == 0x080 for frame in frames_of(folder / "frames.log"))
    assert syncs >= cycles > 200, "a cycle is recorded after its frames were"
