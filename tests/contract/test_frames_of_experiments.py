"""Every frame of whole experiments under Wireshark's CANopen dissector and our own decoder."""

import json
import os
from pathlib import Path

import pytest
from wireshark import dissect, needs_tshark, troubles

from drivers.can.candump import parse_lines
from drivers.can.frame import REMOTE_FLAG
from rig.cli import invoke

CONFIGS = Path(__file__).parents[2] / "configs" / "experiments"
RIGS = {"cylinder": "cylinder", "joint": "joint", "arm": "arm", "legs": "legs-can"}
ONE_OF_EACH = ("cylinder-step", "joint-circle", "arm-elbow-circle", "legs-squat")
# Every other one takes a quarter of an hour more: with SLOW=1, as in `.ci/run`.
EXPERIMENTS = (
    sorted(path.stem for path in CONFIGS.glob("*.yaml")) if os.environ.get("SLOW") else ONE_OF_EACH
)
SERVICES = ("SYNC", "PDO1", "Default-SDO", "NMT", "NMT Error Control")


@needs_tshark
def test_the_dissector_tells_what_is_no_canopen(tmp_path):
    """So that the tests below can fail."""
    log = tmp_path / "bad.log"
    lines = ("710#05", "001#11", "710#", "601#40", "090#0011", "7FF#0011", "00000123#11")
    log.write_text("".join(f"(1700000000.00000{k}) can0 {x}\n" for k, x in enumerate(lines)))
    found = dissect(log)
    assert sum(found.values()) == len(lines)
    assert sum(troubles(found).values()) >= len(lines) - 2


@needs_tshark
@pytest.mark.slow
@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_no_frame_of_an_experiment_is_malformed_or_unknown(
    experiment, tmp_path, capfd, record_property
):
    """And it ends within its bounds, over production drivers and frames."""
    rig = RIGS[experiment.partition("-")[0]]
    options = ["--rig", rig] if rig == "legs-can" else []  # others name a variant of their rig
    arguments = ["run", experiment, *options, "--frames", "--no-report", "--out", str(tmp_path)]
    assert invoke(arguments) == 0
    (folder,) = tmp_path.iterdir()
    found = dissect(folder / "frames.log")
    assert not troubles(found)
    assert all(found[service] for service in SERVICES), found
    capfd.readouterr()
    assert invoke(["monitor", str(folder / "profile.yaml"), "--frames", str(folder), "--json"]) == 0
    shown = capfd.readouterr().out.splitlines()
    assert len(shown) == sum(found.values())
    assert all(json.loads(line)["known"] for line in shown)
    record_property("exchanges", (f"frames of {experiment} on {rig} under tshark", len(shown)))


@pytest.mark.slow
def test_every_frame_of_the_odrives_is_in_the_dbc(tmp_path, capfd, record_property):
    """CANSimple is no CANopen: the DBC of the package odrive-can judges, by way of cantools."""
    odrive_can = pytest.importorskip("odrive_can")
    messages = {
        message.frame_id & 0x1F: message
        for message in odrive_can.get_dbc("odrive-cansimple-0.6.10").messages
        if message.frame_id < 0x20
    }
    arguments = ["run", "arm-elbow-circle", "--rig", "arm-odrive", "--frames", "--no-report"]
    assert invoke([*arguments, "--out", str(tmp_path)]) == 0
    (folder,) = tmp_path.iterdir()
    with (folder / "frames.log").open() as lines:
        frames = list(parse_lines(lines, "frames.log"))
    for frame in frames:
        message = messages[frame.can_id & 0x1F]
        if frame.can_id & REMOTE_FLAG:
            assert frame.data == b""
            continue
        assert len(frame.data) == message.length, f"{message.name}: {frame}"
        message.decode(frame.data, decode_choices=False)
    capfd.readouterr()
    assert invoke(["monitor", "arm-odrive", "--frames", str(folder), "--json"]) == 0
    shown = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert all(line["known"] for line in shown)
    assert len(shown) == len(frames)
    record_property("exchanges", ("frames of arm-elbow-circle on ODrives by the DBC", len(frames)))
