"""What a profile promises of its safety and cannot keep is refused where it is read."""

import random

import pytest

from rig.cli import invoke

MODULE, BUS = "devices.regulators", "buses.can0"


def refused(rig, said, capsys):
    assert invoke(["check", rig, *(word for its in said for word in ("--set", its))]) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("rig", "key", "lacks"),
    [
        ("cylinder", "cylinder.emergency_stop", "devices.regulators.stop_bit"),
        ("cylinder-valves", "cylinder.emergency_stop", "devices.valves.stop_bit"),
        ("joint", "joint.emergency_stop", "devices.regulators.stop_bit"),
        ("arm", "arm.emergency_stop", "devices.drives.stop_contact"),
    ],
)
def test_an_emergency_stop_needs_a_contact(rig, key, lacks, capsys):
    err = refused(rig, [f"{lacks}=null"], capsys)
    assert f"{key}: " in err and f"give {lacks}" in err
    assert f"{lacks}: --set {lacks}=null" in err
    assert invoke(["check", rig, "--set", f"{lacks}=null", "--set", f"{key}=null"]) == 0


@pytest.mark.parametrize("rig", ["cylinder", "joint", "cylinder-valves"])
def test_a_pair_without_co_contraction_is_none(rig, capsys):
    section = rig.partition("-")[0]
    err = refused(rig, [f"{section}.base_pressure=0"], capsys)
    assert "base_pressure" in err
    assert "limits.pressure" in err or rig == "joint"  # which has a law that divides by it
    assert invoke(["check", rig, "--set", f"{section}.base_pressure=40 kPa"]) == 0


def test_a_regulator_that_gives_most_without_a_signal_is_refused(capsys):
    key = f"{MODULE}.channels.agonist.setpoint.pressure"
    err = refused("cylinder", [f"{key}=[500 kPa, 0 kPa]"], capsys)
    assert "pressure: 500000 … 0 Pa falls" in err


@pytest.mark.parametrize("seed", range(4))
def test_a_node_is_told_whole_milliseconds(seed, capsys):
    chance = random.Random(seed)
    shown = chance.randint(2, 9) + chance.choice([0.1, 0.4, 0.5, 0.75])
    key, held_by = chance.choice([
        (f"{BUS}.heartbeat", "0x1017"), (f"{MODULE}.setpoint_deadline", "0x1400:05"),
    ])  # fmt: skip
    err = refused("cylinder", [f"{key}={shown} ms"], capsys)
    assert f"({shown:g} ms) is not a whole number of milliseconds" in err
    assert held_by in err
    err = refused("cylinder", [f"{BUS}.heartbeat_timeout={20 + shown} ms"], capsys)
    assert "heartbeat_timeout" in err and "0x1016" in err


@pytest.mark.parametrize("seed", range(4))
def test_a_master_that_beats_in_its_cycle_does_so_often_enough(seed, capsys):
    chance = random.Random(seed)
    timeout = chance.randint(20, 60)
    beats = chance.randint(1, timeout // 2)
    cycle = chance.uniform(timeout / 2 + 0.5, 1.5 * timeout)  # ms; two no longer fit
    timed = [f"{BUS}.heartbeat={beats} ms", f"{BUS}.heartbeat_timeout={timeout} ms"]
    err = refused("cylinder", [*timed, f"loop.rate={1e3 / cycle:.4f}"], capsys)
    assert "buses.can0.heartbeat_timeout" in err
    assert "between two heartbeats of the master" in err
    assert "loop.rate" in err
    assert "heartbeats of the master" not in said_at(timed, capsys)


def said_at(timed, capsys):
    """Return what the shipped rate makes of the same times: nothing about heartbeats."""
    invoke(["check", "cylinder", *(word for its in timed for word in ("--set", its))])
    return capsys.readouterr().err


def test_an_odrive_is_told_whole_milliseconds(capsys):
    err = refused("arm-odrive", ["devices.drives.heartbeat=20.5 ms"], capsys)
    assert "heartbeat_msg_rate_ms" in err
