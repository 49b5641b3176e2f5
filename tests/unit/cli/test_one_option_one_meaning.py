"""An option has the same meaning, type and default in every command that has it."""

import importlib

import click
import pytest

from rig.cli.command_table import COMMANDS

SEVERAL = {
    "--all": "every procedure, every run",
    "--beside": "in the page, in the figures",
    "--controller": "what is run, tuned or asked in open loop",
    "--dry-run": "what is shown in the place of what is done",
    "--experiment": "one to look at, or several to break in",
    "--for": "tune for a motion; for how long",
    "--frames": "what is recorded, what is read",
    "--on": "what is run on, and which bus is asked",
    "--operator": "who tests, calibrates, tunes",
    "--out": "a folder of runs, or what a command writes that has runs under --runs",
    "--rehearse": "in the page, in the figures",
    "--replace": "a calibration, gains",
    "--rig": "another than the experiment's; of a new experiment; whose words",
    "--steer": "of a run, of a page",
    "--uncommissioned": "of a run, of a calibration",
    "--vary": "a comparison's one axis, a sweep's several",
    "--wait": "for the end of a run, for the emergency stop",
    "--runs": "`rig sweep` and `rig faults run` have folders of their own in it",
    "--seed": "of the simulation; of what is drawn by `rig tune` and `rig faults run`",
    "--json": "`rig monitor` prints one object per line",
    "--workers": "a sweep's file may say how many",
    "--yes": "`rig calibrate` takes it without a name in simulation",
}
"""Options whose help differs, and what is the same all the same."""
RUN_FOLDERS = {"run", "compare", "doctor", "status", "commission", "calibrate", "tune", "list",
               "watch", "stop", "monitor", "explain", "report", "diff"}  # fmt: skip
LOADS_A_PROFILE = {"run", "compare", "sweep", "check", "doctor", "status", "commission",
                   "calibrate", "tune", "margins", "reset", "simulate",
                   "monitor"}  # fmt: skip
SIMULATES_ONE = {"run", "compare", "commission", "calibrate", "check", "margins", "simulate"}
MOVES_HARDWARE = {"run", "compare", "sweep", "commission", "calibrate", "margins", "reset", "rerun"}


def options():
    """Return the options of every command, by their spelling and the command's words."""
    found = {}

    def look(words, command):
        if isinstance(command, click.Group):
            for name, below in command.commands.items():
                look(f"{words} {name}", below)
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                for spelling in parameter.opts:
                    found.setdefault(spelling, {})[words] = parameter

    for name, (place, _) in COMMANDS.items():
        module, _, attribute = place.partition(":")
        look(name, getattr(importlib.import_module(module), attribute))
    return found


OPTIONS = options()
SHARED = sorted(name for name, of in OPTIONS.items() if len(of) > 1)


def meaning(option):
    kind = option.type
    bounds = getattr(kind, "min", None), getattr(kind, "max", None)
    of = (kind.name, bounds, option.multiple, option.is_flag, option.metavar)
    return option.help, of, repr(option.default)


@pytest.mark.parametrize("name", [name for name in SHARED if name not in SEVERAL])
def test_it_has_one_meaning(name):
    assert len({meaning(option) for option in OPTIONS[name].values()}) == 1


@pytest.mark.parametrize("name", sorted(SEVERAL))
def test_what_differs_differs_still(name):
    """Else the exception is to go."""
    assert len({meaning(option) for option in OPTIONS[name].values()}) > 1


@pytest.mark.parametrize("name", SHARED)
def test_it_is_a_switch_everywhere_or_nowhere(name):
    flags = {option.is_flag for words, option in OPTIONS[name].items()}
    assert len(flags) == 1 or name == "--frames"


def commands_with(name):
    return set(OPTIONS[name])


def test_who_would_expect_it_finds_it():
    assert commands_with("--set") >= LOADS_A_PROFILE
    assert commands_with("--configs") >= LOADS_A_PROFILE
    assert commands_with("--seed") >= SIMULATES_ONE
    assert commands_with("--yes") == MOVES_HARDWARE
    assert commands_with("--out") >= RUN_FOLDERS
    assert commands_with("--runs") >= RUN_FOLDERS
    groups = {"faults"}
    leaves = {words for of in OPTIONS.values() for words in of}
    assert commands_with("--json") == leaves - groups


def test_words_that_differ_agree_in_their_core():
    for name, core in (("--out", "run"), ("--yes", "rig's name"), ("--seed", "Of the |Seed of")):
        for words, option in OPTIONS[name].items():
            said = option.help
            if name == "--out" and words in ("sweep", "faults run", "export", "replay", "rerun"):
                continue
            assert any(part in said for part in core.split("|")), (name, words)
    runs = {option.help for words, option in OPTIONS["--out"].items() if words in RUN_FOLDERS}
    assert runs == {"Where run folders live."}
    seeds = {o.help for words, o in OPTIONS["--seed"].items() if words in SIMULATES_ONE}
    assert len(seeds) == 1
