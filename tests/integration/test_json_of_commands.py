"""`--json`: every command that prints a result has it, and prints JSON that any reader takes."""

import importlib
import json
import math
import random
from pathlib import Path

import click
import pytest

from rig.cli import invoke
from rig.cli.command_table import COMMANDS
from rig.cli.tables import finite

WITHOUT = {
    "simulate": "goes on until it is stopped",
    "watch": "goes on until it is stopped",
    "reset": "says whether it could, by its exit code",
    "schema": "what it prints is JSON",
    "completion": "what it prints is a script",
    "calibrate": "asks and tells step by step; its result is a sealed file",
    "tune": "tells step by step; its result is a sealed file",
}
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


def test_every_command_has_it_but_those_that_print_no_result():
    lacking = {
        name for name, command in commands()
        if not any("--json" in parameter.opts for parameter in command.params)
    }  # fmt: skip
    assert lacking == set(WITHOUT)


def strict(text):
    """Parse JSON as the standard has it: no NaN, no Infinity."""

    def refuse(name):
        raise ValueError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    words = ["run", "cylinder-step", "--no-report", "--out", str(folder / "runs"), *QUICK]
    for seed in ("1", "2"):
        assert invoke([*words, "--seed", seed]) in (0, 1)
    return folder


PRINTED = {
    "diff": ["diff", "FIRST", "SECOND"],
    "export": ["export", "FIRST", "--format", "csv"],
    "report": ["report", "FIRST"],
    "rerun": ["rerun", "FIRST", "--no-report"],
    "replay": ["replay", "FIRST"],
    "replay another": ["replay", "FIRST", "--controller", "pid"],
    "stop": ["stop"],
    "list": ["list"],
    "explain": ["explain", "FIRST"],
    "check": ["check", "cylinder-step"],
    "status": ["status", "cylinder"],
    "faults list": ["faults", "list", "cylinder"],
    "commission": ["commission", "cylinder", "--dry-run"],
    "schema": ["schema", "profile"],
}


@pytest.mark.parametrize("name", PRINTED)
def test_what_is_printed_is_json(name, lab, monkeypatch, capsys):
    monkeypatch.chdir(lab)
    first, second, *_ = sorted(path.name for path in Path("runs").iterdir() if path.is_dir())
    words = [{"FIRST": first, "SECOND": second}.get(word, word) for word in PRINTED[name]]
    code = invoke([*words, *(["--json"] if name != "schema" else [])])
    told = capsys.readouterr()
    assert code in (0, 1), told.err
    content = strict(told.out)
    if name == "diff":
        assert {"overshoot", "air_used"} <= {metric["name"] for metric in content["metrics"]}
        assert content["log"] is not None
    if name == "replay another":
        assert all(isinstance(one["rms"], float) for one in content["commands"])
    if name == "replay":
        assert content["same"] is True and content["cycles"] > 1000
    if name == "rerun":
        assert content["compared"] and content["difference"] is None


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
