"""The keys of a file of faults: explained, in the reference and a schema, near to wrong ones."""

import json
import re
from dataclasses import fields
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

import rig
from rig.cli import invoke
from rig.cli.faults import faults
from rig.config.yaml_loader import read_plain
from rig.faults.scenario_file import (
    Next,
    Scenario,
    When,
    case_of,
    load_scenario,
    scenario_schema,
)
from rig.faults.survey import survey
from rig.hal import ConfigurationError

jsonschema = pytest.importorskip("jsonschema")
ROOT = Path(rig.__file__).parents[1]
KEYS = [
    *(field.name for field in fields(Scenario)),
    *(f"when.{field.name}" for field in fields(When)),
    *(f"then.{field.name}" for field in fields(Next)),
]
(EXAMPLE,) = re.findall("```yaml\n(.*?)```", (ROOT / "rig/faults/README.md").read_text(), re.DOTALL)


@pytest.mark.parametrize("key", KEYS)
def test_a_key_is_explained_and_in_the_reference(key, capsys):
    assert invoke(["explain", key]) == 0
    assert f"{key} (fault scenario key): " in capsys.readouterr().out
    page = (ROOT / ".readme/reference.md").read_text()
    assert f"| `{key}` |" in page.partition("## Scenarios")[2].partition("\n## ")[0]


def test_the_command_prints_the_schema(capsys):
    assert invoke(["schema", "scenario"]) == 0
    assert json.loads(capsys.readouterr().out) == scenario_schema()


def test_the_page_has_a_scenario_with_every_key(tmp_path):
    content = yaml.safe_load(EXAMPLE)
    assert {*content, *content["then"]} == {field.name for field in fields(Scenario)} | {"after"}
    (tmp_path / "case.yaml").write_text(EXAMPLE)
    words = ["faults", "run", str(tmp_path / "case.yaml"), "--out", str(tmp_path / "out")]
    assert CliRunner().invoke(faults, words[1:], standalone_mode=False).return_value == 0


CHANGES = [
    ("seed: 3", ["seed: 4", "seed: -1", "seed: 0.5", "sead: 3", "seed: '3'"]),
    ("fault: monitor", ["falt: monitor", "fault: 3 #", "fault: [leak] #"]),
    ("phase: run", ["phase: stop", "phase: running", "phase: 3", "fase: run"]),
    ("after: 50 ms", ["after: 0.05", "after: -1", "after: soon", "afer: 50 ms"]),
    ("lasts: 0.2 s", ["lasts: 0", "lasts: 2", "lasts: -1 s", "last: 0.2 s"]),
    ("seed: 3", ["seed: 4\nlasts: 1 s", "seed: 4\nlast: 1 s"]),
    ("rig: cylinder", ["rig: ./mine.yaml", "rigs: cylinder", "rig: [cylinder]", ""]),
    ("magnitude: 20 kPa", ["magnitude: 1", "magnitude: much", "magnitude: -3e4", "size: 20 kPa"]),
]  # fmt: skip


@pytest.mark.parametrize(("before", "after"), [(b, a) for b, texts in CHANGES for a in texts])
def test_the_schema_says_what_the_loader_says(before, after, tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(EXAMPLE.replace(before, after, 1))
    try:
        load_scenario(path)
    except ConfigurationError:
        loads = True
    else:
        loads = False
    jsonschema.Draft202012Validator.check_schema(scenario_schema())
    errors = list(jsonschema.Draft202012Validator(scenario_schema()).iter_errors(read_plain(path)))
    assert bool(errors) == loads, errors


@pytest.mark.parametrize(
    ("before", "wrong", "near"),
    [
        ("magnitude: 20 kPa", "magnitud: 20 kPa", "magnitude"),
        ("phase: run", "fase: run", "phase"),
        ("fault: silent", "falt: silent", "fault"),
        ("fault: monitor_offset", "fault: monitor_ofset", "monitor_offset"),
        ("phase: run", "phase: rum", "run"),
    ],
)
def test_a_wrong_key_gets_the_nearest_and_its_place(before, wrong, near, tmp_path, capsys):
    path = tmp_path / "case.yaml"
    path.write_text(EXAMPLE.replace(before, wrong, 1))
    assert invoke(["faults", "run", str(path), "--out", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert f"did you mean {near}?" in err
    line = 1 + path.read_text().partition(wrong)[0].count("\n")
    assert f"{path}:{line}:" in err


MAGNITUDES = [("20 kPa", 2e4), ("0.2 bar", 2e4), ("-30 kPa", -3e4), ("4e4", 4e4)]


@pytest.mark.parametrize(("written", "meant"), MAGNITUDES)
def test_a_magnitude_has_the_unit_that_it_is_written_with(written, meant, tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(EXAMPLE.replace("20 kPa", written))
    subject = survey("cylinder", ("cylinder-sine",), None)
    case = case_of(load_scenario(path), subject, str(path))
    assert case.first.magnitude == pytest.approx(meant)


@pytest.mark.parametrize(
    ("written", "said"),
    [("20 mm", "kPa"), ("20 kilopascal", "kPa"), ("900 kPa", "is outside ±2000 … 120000 Pa")],
)
def test_a_magnitude_of_another_kind_or_size_is_told_with_its_place(written, said, tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(EXAMPLE.replace("20 kPa", written))
    subject = survey("cylinder", ("cylinder-sine",), None)
    with pytest.raises(ConfigurationError) as refused:
        case_of(load_scenario(path), subject, str(path))
    assert f"{path}:5:12: monitor_offset" in str(refused.value) and said in str(refused.value)
