"""`rig doctor`: its exit codes, its table and its JSON."""

import json

import pytest
from click.testing import CliRunner

from rig.cli.doctor import EXIT_UNFIT, doctor
from rig.hal import ConfigurationError


def run(*words):
    return CliRunner().invoke(doctor, [*words, "--rate", "200"], standalone_mode=False)


def test_a_computer_alone_is_looked_at(tmp_path):
    result = run("--out", str(tmp_path), "--json")
    found = json.loads(result.stdout)["findings"]
    assert {one["verdict"] for one in found} <= {"ok", "poor", "no"}
    assert found[0]["what"] == "kernel"
    assert found[-1]["what"] == "wake-ups at 200 Hz, as it is"
    assert result.return_value == (EXIT_UNFIT if any(o["verdict"] == "no" for o in found) else 0)


def test_a_rig_whose_port_is_not_there_does_not_run_here(tmp_path):
    changes = ("--set", "buses.chain.port=/dev/rig-none")
    result = run("legs", *changes, "--out", str(tmp_path))
    assert result.return_value == EXIT_UNFIT
    assert "bus chain, serial /dev/rig-none" in result.stdout
    assert "bus chain, serial /dev/rig-none: plug it in" in result.stderr


def test_a_load_is_announced_and_measured(tmp_path):
    result = run("--abuse", "1", "--out", str(tmp_path))
    assert "1 s with" in result.stderr
    assert "wake-ups at 200 Hz, loaded for 1 s" in result.stdout


def test_an_unknown_rig_is_named():
    with pytest.raises(ConfigurationError, match="no rig is called 'nobody'"):
        CliRunner().invoke(doctor, ["nobody"], standalone_mode=False, catch_exceptions=False)
