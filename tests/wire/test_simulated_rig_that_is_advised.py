"""`rig check --on hardware` advises a simulated rig that the same question then finds."""

import random
import re
import shlex
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from drivers.can.multicast import FIRST_PORT
from rig.assembly import REGISTRY, parse_interfaces
from rig.assembly.on_interfaces import own_interfaces
from rig.assembly.survey import compare, expected_on
from rig.cli import invoke
from rig.cli.check_bus import _simulated
from rig.config import find_configs, load_profile

BUS = "{{interface: {}, channel: {}}}"


def profile_of(rig, *overrides):
    return load_profile(rig, REGISTRY, overrides, find_configs())


def on_bus(interface, channel):
    return f"buses.can0={BUS.format(interface, channel)}"


@pytest.fixture
def simulated():
    """Return what starts a command in the background; it ends with the test."""
    running = []

    def start(words, is_told):
        process = subprocess.Popen(
            [sys.executable, "-m", *words], stderr=subprocess.PIPE, text=True
        )  # fmt: skip
        running.append(process)
        for line in process.stderr:
            if re.search(is_told, line):
                return line
        pytest.skip("this machine has no such network")

    yield start
    for process in running:
        process.terminate()
        process.communicate()


@pytest.mark.parametrize("options", ["", ", options: {port: 43177}"])
def test_a_profiles_own_group_meets_the_simulation_that_is_advised(
    tmp_path, monkeypatch, capsys, simulated, options
):
    pytest.importorskip("msgpack")
    monkeypatch.chdir(tmp_path)
    group = f"239.74.164.{random.Random(options).randrange(20, 250)}"
    (tmp_path / "mine.yaml").write_text(
        "extends: cylinder\nbuses:\n"
        f"  can0: {{interface: udp_multicast, channel: {group}{options}}}\n"
    )
    code = invoke(["check", "mine.yaml", "--on", "hardware"])
    told = capsys.readouterr().err
    if "nobody answers" not in told:
        pytest.skip(told)
    advised = told.strip().rpartition("is started by: ")[2]
    assert code == 3 and advised == f"rig simulate mine.yaml --on udp_multicast:{group}"
    simulated([*shlex.split(advised), "--for", "60"], "simulating")
    deadline = time.monotonic() + 10.0
    while invoke(["check", "mine.yaml", "--on", "hardware"]) and time.monotonic() < deadline:
        capsys.readouterr()
    assert "3 of 3 nodes are as the profile says" in capsys.readouterr().err


def test_the_port_is_the_groups_unless_the_profile_names_the_group_with_another():
    own = on_bus("udp_multicast", "239.74.163.9, options: {port: 43177}")
    ports = {"239.74.163.9": 43177, "239.74.163.8": FIRST_PORT + 8}
    ports["ff15:7079::6173"] = FIRST_PORT + 6173
    for on, port in ports.items():
        found = parse_interfaces(f"udp_multicast:{on}", profile_of("cylinder", own))
        assert found["can0"]["options"] == {"port": port}


@pytest.mark.parametrize(
    ("rig", "interface", "advised"),
    [
        ("cylinder", ("socketcan", "vcan3"), "--on vcan3"),
        ("cylinder", ("socketcan", "can7"),
         "--on can7 (on another computer of that bus, unless it is a vcan)"),
        ("cylinder", ("pcan", "PCAN_USBBUS1"),
         "--on vcan0; then look again with --on vcan0 in the place of --on hardware"),
    ],
)  # fmt: skip
def test_what_is_advised_is_an_option_that_rig_simulate_takes(rig, interface, advised):
    profile = profile_of(rig, on_bus(*interface))
    assert _simulated(profile, "hardware") == f"rig simulate {rig} {advised}"
    on = shlex.split(advised)[1].rstrip(";")
    assert parse_interfaces(on, profile)["can0"]["channel"] == on
    assert _simulated(profile, "vcan5") == f"rig simulate {rig} --on vcan5"


def test_of_several_buses_each_is_named():
    profile = profile_of("legs-can")
    assert own_interfaces(profile) == "can0,can1"
    assert set(parse_interfaces("can0,can1", profile)) == {"can0", "can1"}


def test_a_serial_line_is_asked_at_the_port_that_the_simulation_prints(simulated, capsys):
    profile = profile_of("legs")
    [line] = profile.buses
    advised = _simulated(profile, "hardware")
    command, _, rest = advised.partition("; ")
    assert rest == f"then look again with --set buses.{line}.port=PORT, which it prints"
    told = simulated([*shlex.split(command), "--for", "60"], rf"^{line} on /dev")
    port = re.search(r"/dev/\S+?(?=:)", told)[0]
    assert invoke(["check", "legs", "--on", "hardware", "--set", f"buses.{line}.port={port}"]) == 0
    assert "nodes are as the profile says" in capsys.readouterr().err


def test_a_bus_on_which_nobody_answers_is_advised_so(monkeypatch, capsys):
    profile = profile_of("cylinder", on_bus("socketcan", "vcan3"))
    silent = compare("can0", expected_on(profile, "can0"), {})
    monkeypatch.setattr("rig.assembly.survey.survey_buses", lambda *_: silent)
    monkeypatch.setattr("rig.cli.check.load", lambda *_: (profile, SimpleNamespace()))
    assert invoke(["check", "cylinder", "--on", "hardware"]) == 3
    assert "rig simulate cylinder --on vcan3\n" in capsys.readouterr().err
