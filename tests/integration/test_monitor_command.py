"""`rig monitor` as it is used: files, pipes, live interfaces, and what is typed wrong."""

import json
import signal
import subprocess
import sys
import threading
import time

import click
import pytest

can = pytest.importorskip("can")

from rig.cli import group, invoke  # noqa: E402
from rig.cli.commands import invoke as invoke_click  # noqa: E402
from rig.hal import FastCanBus  # noqa: E402

LOG = """\
(1700000000.000000) can0 000#0110
(1700000000.000100) can0 710#05
(1700000000.001000) can0 190#CD0C004001000000
(1700000000.001100) can0 080#
(1700000000.002000) can0 7E5#00
(1700000000.003000) can0 5A0#43056001E8030000
(1700000000.003000) can0 5A0#4305600201000000
(1700000000.004000) can0 1A0#10270000ECFF0000
(1700000000.0050"""
RIG = [sys.executable, "-m", "rig", "monitor", "cylinder", "--frames"]


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "bus.log"
    path.write_text(LOG)
    return path


def test_a_file_becomes_lines_in_the_profiles_names(log, capfd):
    assert invoke(["monitor", "cylinder", "--frames", str(log)]) == 0
    out, err = capfd.readouterr()
    lines = out.splitlines()
    assert [line.split(maxsplit=5)[:5] for line in lines[:3]] == [
        ["0.000000", "can0", "000", "regulators", "NMT"],
        ["0.000100", "can0", "710", "regulators", "heartbeat"],
        ["0.001000", "can0", "190", "regulators", "TPDO1"],
    ]
    assert "antagonist pressure = 500 kPa, agonist setpoint = 15.26 Pa" in lines[2]
    assert lines[4].split()[2:] == ["7E5", "-", "unknown", "00"]
    assert "position = 10 mm, speed = -0.2 mm/s" in lines[7]
    assert err == "8 frames, 1 that the profile does not know\n"


def test_json_is_one_object_per_line(log, capfd):
    assert invoke(["monitor", "cylinder", "--frames", str(log), "--json"]) == 0
    objects = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert objects[7] == {
        "t": 0.004,
        "time": 1700000000.004,
        "bus": "can0",
        "id": "1A0",
        "data": "10270000ECFF0000",
        "device": "encoder-agonist",
        "service": "TPDO1",
        "known": True,
        "values": [
            {"name": "position", "object": "0x6004:00", "value": pytest.approx(0.01), "unit": "m"},
            {"name": "speed", "object": "0x6030:01", "value": pytest.approx(-2e-4), "unit": "m/s"},
            {"name": "alarms", "object": "0x6503:00", "value": "0x0000", "unit": None},
        ],
        "text": None,
    }
    assert (objects[4]["device"], objects[4]["known"]) == (None, False)


def test_devices_and_time_narrow_what_is_shown(log, capfd):
    base = ["monitor", "cylinder", "--frames", str(log)]
    assert invoke([*base, "--device", "encoder-agonist"]) == 0
    assert len(capfd.readouterr().out.splitlines()) == 3
    assert invoke([*base, "--for", "0.0015"]) == 0
    assert len(capfd.readouterr().out.splitlines()) == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cylinder"], "Say whose frames"),
        (["cylinder", "--frames"], "Say whose frames"),
        (["cylinder", "--frames", "x.log", "--on", "vcan0"], "Say whose frames"),
        (["cylinder", "--frames", "nowhere.log"], "there is no file nowhere.log"),
        (["cylinder", "--frames", "nowhere"], "no run is called 'nowhere'"),
        (["cylindre", "--frames", "x"], "cylinder"),
        (["cylinder", "--frames", "x", "--device", "regulator"], "did you mean regulators?"),
        (["cylinder", "--frames", "--on", "can0,can1"], "2 interfaces for the CAN buses"),
        (["legs", "--frames", "{log}"], "has no CAN bus"),
        (["cylinder", "--frames", "{bad}"], r"bad.log:2: this is no frame"),
        (["cylinder", "--frames", "{blf}"], "this is no BLF file"),
        (["cylinder", "--frames", "{run}"], "records them with --frames"),
    ],
)
def test_what_is_typed_wrong_ends_with_2_and_says_what_is_right(
    arguments, message, log, tmp_path, capfd, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.log").write_text(LOG.replace("(1700000000.000100)", "noon"))
    (tmp_path / "bad.blf").write_text("no BLF")
    run = tmp_path / "runs" / "2026-run"
    run.mkdir(parents=True)
    (run / "manifest.json").write_text("{}")
    places = {"log": log, "bad": tmp_path / "bad.log", "blf": tmp_path / "bad.blf", "run": run}
    assert invoke(["monitor", *[word.format(**places) for word in arguments]]) == 2
    assert message in capfd.readouterr().err


def test_frames_need_a_bus_to_be_recorded(tmp_path, capfd):
    for options, message in (
        (["--on", "sim", "--frames"], "there is no bus"),
        (["--frames", "pcap"], "'pcap' is no format of frames, which are log, asc, blf"),
    ):
        assert invoke(["run", "cylinder-step", "--out", str(tmp_path), *options]) == 2
        assert message in capfd.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_reader_that_has_had_enough_is_no_error(log):
    log.write_text("".join(LOG.splitlines(keepends=True)[:-1]) * 3000)
    process = subprocess.Popen(
        [*RIG, str(log)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline().split()[2] == "000"
    process.stdout.close()
    said = process.stderr.read()
    process.stderr.close()
    assert process.wait(30) == 0
    assert "Traceback" not in said
    assert "Broken pipe" not in said


def test_a_pipe_is_shown_as_it_comes():
    process = subprocess.Popen(
        [*RIG, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    with process:
        for line in LOG.splitlines(keepends=True)[:3]:
            process.stdin.write(line)
            process.stdin.flush()
            assert process.stdout.readline().split()[2] == line.split()[2].partition("#")[0]
        process.stdin.close()
    assert process.returncode == 0


def test_a_live_interface_is_listened_to(capfd, request):
    channel = f"{request.node.name}0"
    stop = threading.Event()
    with can.Bus(channel, interface="virtual") as other:

        def send():
            while not stop.is_set():
                other.send(can.Message(arbitration_id=0x710, data=[5], is_extended_id=False))
                time.sleep(0.005)

        thread = threading.Thread(target=send)
        thread.start()
        arguments = ["monitor", "cylinder", "--frames", "--on", f"virtual:{channel}"]
        assert invoke([*arguments, "--for", "0.05"]) == 0
        stop.set()
        thread.join()
        assert other.recv(0.0) is None, "nothing is ever sent"
    out, err = capfd.readouterr()
    assert out.splitlines()[0].split()[1:4] == ["can0", "710", "regulators"]
    assert err.startswith(f"listening on virtual:{channel}")


def test_a_quiet_bus_is_left_in_time_too(capfd):
    arguments = ["monitor", "cylinder", "--frames", "--on", "virtual:silent0"]
    assert invoke([*arguments, "--for", "0.02"]) == 0
    assert capfd.readouterr().err.endswith("0 frames\n")


def test_frames_that_the_kernel_dropped_are_told(monkeypatch, capfd):
    class Flooded(FastCanBus):
        def __init__(self):
            self.frames = [(0x710, b"\5"), (0x7E5, b"")]

        def drain(self, limit):
            frames, self.frames = self.frames, []
            return frames

        def count_dropped(self):
            return 1234

        def shutdown(self):
            pass

    monkeypatch.setattr("drivers.can.open_bus", lambda settings: Flooded())
    assert invoke(["monitor", "cylinder", "--frames", "--on", "can0", "--for", "0.02"]) == 0
    summary = capfd.readouterr().err.splitlines()[-1]
    assert summary.startswith("2 frames, 1 that the profile does not know, and 1234 were lost")


def test_ctrl_c_ends_listening():
    # A shell has what it starts in the background ignore Ctrl-C, and so everything in it.
    process = subprocess.Popen(
        ["env", "--default-signal=INT", *RIG, "--on", "virtual:quiet0"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    with process:
        assert process.stderr.readline().startswith("listening on virtual:quiet0")
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30.0)[1] == "0 frames\n"
    assert process.returncode == 0


def complete(arguments, incomplete):
    from click.shell_completion import ShellComplete

    return [
        item.value
        for item in ShellComplete(group, {}, "rig", "_RIG_COMPLETE").get_completions(
            arguments, incomplete
        )
    ]


def test_names_are_completed():
    assert complete(["monitor"], "cylinder-low") == ["cylinder-low-speed"]
    assert complete(["monitor", "cylinder", "--device"], "enc") == [
        "encoder-agonist", "encoder-antagonist",
    ]  # fmt: skip
    assert complete(["monitor", "cylinder", "--frames"], "lat") == ["latest"]
    assert complete(["run", "cylinder-step", "--frames"], "b") == ["blf"]


def test_the_help_shows_how_it_is_used(capsys):
    assert invoke_click(["monitor", "--help"]) == 0
    text = capsys.readouterr().out
    assert "rig monitor joint --frames --on vcan0\n" in text
    assert isinstance(group.get_command(click.Context(group), "monitor"), click.Command)
