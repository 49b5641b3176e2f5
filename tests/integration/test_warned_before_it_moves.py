"""What `rig check` warns of is said before hardware moves, and so is what a test will do."""

import sys

import click
import pytest

from rig.cli import invoke

STOP = "cylinder.limits.stop_energy=9 J"
FAST = ["cylinder.base_pressure=150 kPa", STOP, "buses.can0.channel=nocan7"]
LOOP = "loop.small_margin=a test"
COMMANDS = [
    ("run", "cylinder-sine"), ("calibrate", "cylinder", "response"), ("commission", "cylinder"),
    ("run", "cylinder-sine", "--uncommissioned", "a test"),
]  # fmt: skip


def sets(options):
    return [word for option in options for word in ("--set", option)]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path


@pytest.fixture
def asked(here, monkeypatch, capsys):
    """Return what was said before somebody was asked, who then types another name."""

    class Terminal:
        def isatty(self):
            return True

    said = []
    monkeypatch.setattr(sys, "stdin", Terminal())
    monkeypatch.setattr(click, "prompt", lambda *_, **__: said.append(capsys.readouterr().err))
    return said


def warnings(said):
    return [line for line in said.splitlines() if line.startswith("warning: ")]


@pytest.fixture
def warned(here, capsys):
    assert invoke(["check", "cylinder", *sets(FAST)]) == 0
    lines = warnings(capsys.readouterr().err)
    assert any("above limits.speed" in line for line in lines)
    return lines


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_whoever_is_asked_has_read_the_warnings(asked, warned, command):
    assert invoke([*command, "--on", "hardware", *sets([*FAST, LOOP])]) == 2
    assert warnings(asked[0]) == warned


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_whoever_gives_the_name_beforehand_reads_them_as_well(here, warned, capsys, command):
    """There is no such bus, and nobody answers a test, so nothing more comes of it."""
    words = ["--on", "hardware", "--yes", "cylinder", *sets([*FAST, LOOP])]
    assert invoke([*command, *words]) in (2, 3)
    assert warnings(capsys.readouterr().err) == warned


def test_nobody_is_warned_in_a_simulation(here, capsys):
    options = [*FAST, "reference.tones=[{frequency: 1 Hz, periods: 2}]", "metrics={}"]
    assert invoke(["run", "cylinder-sine", "--no-report", "--on", "sim", *sets(options)]) == 0
    assert warnings(capsys.readouterr().err) == []


def test_an_acceptance_test_says_what_it_does_before_it_asks(asked):
    assert invoke(["commission", "cylinder", "--on", "hardware", *sets([STOP])]) == 2
    said = asked[0]
    assert "the acceptance test of cylinder:\n  bus: Every node number of every bus" in said
    assert "first-motion: The rig is energised and moves by 1 mm under control." in said
    assert "limits: speed 500 mm/s" in said


def test_an_acceptance_test_without_a_stop_is_refused_before_it_asks(asked, here, capsys):
    for words in ([], ["--yes", "cylinder"]):
        assert invoke(["commission", "cylinder", "--on", "hardware", *words]) == 3
        assert "error: cylinder: limits.stop_energy is not declared" in capsys.readouterr().err
    assert asked == [] and not (here / "configs").exists()
