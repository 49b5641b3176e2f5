"""`--json`: every command has it, and prints JSON that any reader takes, and nothing else."""

import importlib
import json
import math
import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest

from rig.cli import invoke, listing
from rig.cli.command_table import COMMANDS
from rig.cli.tables import finite, print_json
from rig.config.names import find_configs
from rig.hal import ConfigurationError

QUICK = (
    "--on",
    "sim",
    "--set",
    "reference.repeats=1",
    "--set",
    "reference.dwell=0.5 s",
    "--set",
    "reference.rise=0.1 s",
    "--set",
    "reference.size=2 mm",
    "--set",
    "figures=[timing]",
)


def commands():
    """Yield every command and those of groups, with its name."""

    def below(name, command):
        if isinstance(command, click.Group):
            context = click.Context(command)
            for sub in command.list_commands(context):
                yield from below(f"{name} {sub}", command.get_command(context, sub))
        else:
            yield name, command

    for name, (path, _) in COMMANDS.items():
        module, _, attribute = path.partition(":")
        yield from below(name, getattr(importlib.import_module(module), attribute))


def options_of(command):
    return {word for parameter in command.params for word in parameter.opts}


def test_every_command_has_it_and_is_driven_with_it_below():
    found = dict(commands())
    assert [name for name, command in found.items() if "--json" not in options_of(command)] == []
    driven = {name for name in found for words in DRIVEN.values() if begins(words, name.split())}
    assert driven == set(found)


def begins(words, name):
    return words[: len(name)] == name


def test_the_folder_of_runs_has_both_names_everywhere():
    """A command that looks for a run and writes something else keeps `--out` for that."""
    lacking = {
        name for name, command in commands()
        if len(options_of(command) & {"--out", "--runs"}) == 1
    }  # fmt: skip
    assert not lacking


@pytest.mark.parametrize("option", ["--out", "--runs"])
def test_runs_are_found_by_either_name(option, lab, monkeypatch, capsys):
    monkeypatch.chdir(lab / "runs")
    for words in (["list", "runs"], ["explain", "latest"], ["status", "cylinder"], ["stop"]):
        code = invoke([*words, "--json", option, "../runs"])
        told = capsys.readouterr()
        assert code == (1 if words == ["stop"] else 0), told.err
        assert words == ["stop"] or "cylinder-step" in told.out


def strict(text):
    """Parse JSON as the standard has it: no NaN, no Infinity."""

    def refuse(name):
        raise ValueError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    shutil.copytree(
        find_configs()[-1],
        folder / "configs",
        ignore=shutil.ignore_patterns("calibration", "commissioning"),
    )
    words = ["run", "cylinder-step", "--no-report", "--out", str(folder / "runs"), *QUICK]
    for seed in ("1", "2"):
        more = ["--on", "virtual", "--frames"] if seed == "1" else []
        assert invoke([*words, "--seed", seed, *more]) in (0, 1)
    return folder


GROUP = "udp_multicast:239.74.163.57"
TUNE = (
    "--controller", "pid", "--for", "cylinder-step", "--generations", "3", "--dry-run",
    "--set", "plant.model=antagonistic-pair", "--set", "reference.dwell=1 s",
    "--set", "reference.rise=0.2 s",
)  # fmt: skip
DRIVEN = {
    "run": ["run", "cylinder-step", "--no-report", *QUICK],
    "compare": ["compare", "cylinder-step", "--controllers", "cascade,pid", *QUICK],
    "sweep": ["sweep", "cylinder-step", "--seeds", "1:3", *QUICK],
    "new": ["new", "experiment", "mine", "--rig", "cylinder"],
    "check": ["check", "cylinder-step"],
    "doctor": ["doctor", "cylinder"],
    "status": ["status", "cylinder"],
    "commission": ["commission", "cylinder", "--dry-run"],
    "calibrate": ["calibrate", "cylinder"],
    "calibrate by": ["calibrate", "cylinder", "response", "--yes", "--on", "sim"],
    "calibrate history": ["calibrate", "cylinder", "--history", "cylinder"],
    "calibrate diff": ["calibrate", "cylinder", "--diff", "cylinder", "cylinder"],
    "tune": ["tune", "cylinder", *TUNE],
    "margins": ["margins", "cylinder", "--on", "sim"],
    "watch": ["watch", "FIRST", "--port", "0", "--steer"],
    "stop": ["stop"],
    "reset": ["reset", "cylinder"],
    "simulate": ["simulate", "cylinder", "--on", GROUP],
    "monitor": ["monitor", "cylinder", "--frames", "FIRST", "--for", "0.2"],
    "faults list": ["faults", "list", "cylinder"],
    "faults run": ["faults", "run", "cylinder", "--only", "encoder_alarm", "--seed", "3"],
    "list": ["list"],
    "explain": ["explain", "FIRST"],
    "explain word": ["explain", "tracking_rms"],
    "report": ["report", "FIRST"],
    "report beside": ["report", "FIRST", "--rehearse"],
    "export": ["export", "FIRST", "--format", "csv"],
    "rerun": ["rerun", "FIRST", "--no-report"],
    "diff": ["diff", "FIRST", "SECOND"],
    "replay": ["replay", "FIRST"],
    "replay another": ["replay", "FIRST", "--controller", "pid"],
    "schema": ["schema", "profile"],
    "completion": ["completion", "bash"],
}
"""Every command, in the order in which they find what they need."""
SERVING = {"watch": "steer", "simulate": "buses"}
"""Those that go on until they are stopped, and a key of what they print when they have begun."""
LINES = {"monitor"}
"""Those that print an object per line, for as long as it takes."""
CONTENT = {
    "run": lambda found: found["status"] == "ok" and found["metrics"][0]["name"],
    "compare": lambda found: found["labels"] == ["cascade", "pid"],
    "calibrate": lambda found: "response" in {one["name"] for one in found},
    "calibrate by": lambda found: (
        found[0]["found"][0]["estimates"][0]["std"] > 0.0
        and Path(found[0]["files"][0]).is_file()
        and {"cascade", "pid"} <= set(found[0]["loops"])
    ),
    "calibrate history": lambda found: found[0]["provenance"]["procedure"] == "response",
    "calibrate diff": lambda found: all(one["a"] == one["b"] for one in found["quantities"]),
    "tune": lambda found: (
        found["file"] is None and set(found["now"]["gains"]) == set(found["before"]["gains"])
    ),
    "margins": lambda found: found["now"]["sensitivity"]["measured"] > 1.0,
    "watch": lambda found: found["look"].startswith("http://127.0.0.1:") and found["steer"],
    "reset": lambda found: found["was_latched"] is None and not found["is_latched"],
    "simulate": lambda found: "regulators" in found["buses"]["can0"]["devices"],
    "monitor": lambda found: len(found) > 100 and all(isinstance(one, dict) for one in found),
    "faults run": lambda found: found[0]["case"]["first"],
    "report beside": lambda found: found["residuals"][0]["name"] == "reading.position",
    "diff": lambda found: (
        {"overshoot", "air_used"} <= {metric["name"] for metric in found["metrics"]}
        and found["log"] is not None
    ),
    "replay": lambda found: found["same"] is True and found["cycles"] > 1000,
    "replay another": lambda found: all(isinstance(o["rms"], float) for o in found["commands"]),
    "rerun": lambda found: found["compared"] and found["difference"] is None,
    "completion": lambda found: "_RIG_COMPLETE" in found["script"],
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name == "tune" else []) for name in DRIVEN],
)
def test_what_is_printed_is_json(name, lab, monkeypatch, capfd):
    monkeypatch.chdir(lab)
    given = sorted(path for path in Path("runs").iterdir() if (path / "manifest.json").exists())
    first = next(path.name for path in given if (path / "frames.log").exists())
    second = next(path.name for path in given if path.name != first)
    words = [{"FIRST": first, "SECOND": second}.get(word, word) for word in DRIVEN[name]]
    if name in SERVING:
        text = printed_until_stopped([*words, "--json"], SERVING[name])
    else:
        priority = os.nice(0)
        code = invoke([*words, "--json"])
        assert os.nice(0) == priority, "its caller runs on at another priority"
        told = capfd.readouterr()
        text = told.out
        assert code in (0, 1) or (name == "doctor" and code == 3), told.err
    found = [strict(line) for line in text.splitlines()] if name in LINES else strict(text)
    assert CONTENT.get(name, lambda _: True)(found), found


WRONG = {
    "a name": (["check", "nothere"], 2, "no rig or experiment is called 'nothere'"),
    "a command": (["chek"], 2, "There is no command 'chek'"),
    "an option": (["list", "--nothing"], 2, "No such option"),
    "a run": (["report", "nothere"], 2, "nothere"),
    "a key": (["run", "cylinder-step", "--set", "no.key=1"], 2, "no.key"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_an_error_is_an_object_too(wrong, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words, code, text = WRONG[wrong]
    assert invoke([*words, "--json"]) == code
    told = capsys.readouterr()
    found = strict(told.out)
    assert found["exit"] == code
    assert text in found["error"]
    assert text in told.err  # and in words, as ever
    assert invoke(words) == code
    assert capsys.readouterr().out == ""


def test_what_is_printed_before_an_error_stays_one_object(monkeypatch, capsys):
    def fails(**_):
        print_json({"found": 1})
        raise ConfigurationError("it went wrong afterwards")

    monkeypatch.setattr(listing.listing, "callback", fails)
    assert invoke(["list", "--json"]) == 2
    assert strict(capsys.readouterr().out) == {"found": 1}


def printed_until_stopped(words, key):
    """Return what a command prints, which is interrupted when it has printed its object."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rig", *words],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        lines = []
        for line in process.stdout:
            lines.append(line)
            if line.startswith("}"):
                break
        assert any(f'"{key}"' in line for line in lines), "it was not printed before it was stopped"
    finally:
        process.terminate()
        rest, _ = process.communicate(timeout=30)
    return "".join(lines) + rest


@pytest.mark.parametrize("seed", range(20))
def test_numbers_that_are_none_become_null(seed):
    chance = random.Random(seed)

    def drawn(depth):
        kind = chance.randrange(6 if depth else 4)
        if kind < 2:
            return chance.choice([math.nan, math.inf, -math.inf, chance.uniform(-1e300, 1e300)])
        if kind < 4:
            return chance.choice([None, True, 10**30, "NaN", Path("a/b")])
        if kind == 4:
            return [drawn(depth - 1) for _ in range(3)]
        return {f"k{k}": drawn(depth - 1) for k in range(3)}

    content = {"all": [drawn(4) for _ in range(8)]}
    text = json.dumps(finite(content), allow_nan=False)
    assert strict(text)["all"] == finite(content)["all"]
