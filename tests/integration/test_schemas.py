"""The JSON Schemas, by a validator of others: they say of every file what the loader says."""

import random
from functools import cache
from pathlib import Path

import pytest

import rig
from rig.assembly import REGISTRY, check_profile
from rig.config import experiment_schema, load_experiment, load_profile, profile_schema
from rig.config.yaml_loader import read_plain
from rig.experiment.plan import load_plan
from rig.hal import ConfigurationError

jsonschema = pytest.importorskip("jsonschema")
CONFIGS = Path(rig.__file__).parents[1] / "configs"
SHIPPED = sorted([*(CONFIGS / "rigs").glob("*.yaml"), *(CONFIGS / "experiments").glob("*.yaml")])


@cache
def validator(folder):
    made = (profile_schema if folder == "rigs" else experiment_schema)(REGISTRY)
    jsonschema.Draft202012Validator.check_schema(made)
    return jsonschema.Draft202012Validator(made)


def load(path, folder):
    if folder == "rigs":
        check_profile(load_profile(path, REGISTRY, (), (CONFIGS,)))
    else:
        load_experiment(path, REGISTRY, (), (CONFIGS,))


def plan(path, folder):
    """Load an experiment with its rig, which knows the laws that it has."""
    if folder == "rigs":
        load(path, folder)
    else:
        load_plan(path, (), configs=CONFIGS)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_file_is_valid(path):
    assert [str(e) for e in validator(path.parent.name).iter_errors(read_plain(path))] == []


# (folder, file, what is taken out, what stands there)
BROKEN = [
    (folder, name, before, after)
    for folder, name, before, texts in [
        ("rigs", "cylinder", "bore: 16 mm",
         ["bore: '16'", "bore: wide", "bore: -1", "bore: 0", "bore: 16", "bore: [16 mm]",
          "bore: true", "bore: {}", "boer: 16 mm", "bore: 1e5", "bore: '1e-2'", "bore:"]),
        ("rigs", "cylinder", "mechanism: cylinder",
         ["mechanism: cylindre", "mechanism: 3", "mechanism: joint", "machine: cylinder",
          "mechanism: [cylinder]", "mechanism: cylinder\nmore: 1", "mechanism:"]),
        ("rigs", "cylinder", "rate: 1 kHz",
         ["rate: '1000'", "rate: fast", "rate: -5", "speed: 1 kHz", "rate: [1]", "rate: '1e3'"]),
        ("rigs", "cylinder", "bitrate: 1 Mbit/s",
         ["bitrate: 1", "max_refused: -1", "receive_limit: 1000000", "sdo_timeout: 1e300",
          "protocol: canopener", "bit_rate: 1 Mbit/s"]),
        ("rigs", "cylinder", "driver: cia401",
         ["driver: cia499", "driver: cia402", "driver:", "drivers: cia401", "driver: 401"]),
        ("experiments", "cylinder-sine", "controller: cascade",
         ["law: pid\ncontroller: cascade", "controler: cascade", "controllers: cascade",
          "controller: x", "law: esc", "controller:"]),
        ("experiments", "cylinder-sine", "approach: 2 s",
         ["approach: soon", "approach: '2'", "approach: 700", "approach: -1", "metric: {}",
          "law: 3", "rigs: x"]),
        ("experiments", "cylinder-sine", "figures: [tracking, error, pressures, timing]",
         ["figures: tracking", "figures: [1]", "figure: [tracking]"]),
        ("experiments", "cylinder-sine", "max: 0.15 mm",
         ["max: often", "most: 0.15 mm", "max: [1]", "max: '0.1'", "max: true"]),
        ("experiments", "arm-elbow-circle", "law: esc",
         ["law: pid", "law: cascade", "law: super-twisting", "controller: pid\nlaw: esc"]),
    ]
    for after in texts
]  # fmt: skip


@pytest.mark.parametrize(("folder", "name", "before", "after"), BROKEN)
def test_what_the_loader_refuses_the_schema_refuses(folder, name, before, after, tmp_path):
    text = (CONFIGS / folder / f"{name}.yaml").read_text()
    assert before in text
    (tmp_path / folder).mkdir()
    path = tmp_path / folder / "mine.yaml"
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(ConfigurationError):
        plan(path, folder)
    assert list(validator(folder).iter_errors(read_plain(path))), path.read_text()


def test_there_are_enough_broken_ones():
    assert len(BROKEN) >= 50


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_key_that_is_taken_out_is_missed_by_both_or_by_none(path, tmp_path):
    import yaml

    folder, chance = path.parent.name, random.Random(path.stem)
    content = read_plain(path)
    del content[chance.choice(list(content))]
    (tmp_path / folder).mkdir()
    made = tmp_path / folder / path.name
    made.write_text(yaml.safe_dump(content))
    try:
        load(made, folder)
    except ConfigurationError:
        return  # one file does not know what another says: the schema may accept it
    assert not list(validator(folder).iter_errors(read_plain(made)))
