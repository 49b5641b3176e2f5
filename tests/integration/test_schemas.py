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
from rig.sweeping.sweep_file import load_sweep
from rig.sweeping.sweep_keys import sweep_schema

jsonschema = pytest.importorskip("jsonschema")
CONFIGS = Path(rig.__file__).parents[1] / "configs"
SCHEMAS = {
    "rigs": lambda: profile_schema(REGISTRY),
    "experiments": lambda: experiment_schema(REGISTRY),
    "sweeps": sweep_schema,
}
SHIPPED = sorted(path for folder in SCHEMAS for path in (CONFIGS / folder).glob("*.yaml"))


@cache
def validator(folder):
    made = SCHEMAS[folder]()
    jsonschema.Draft202012Validator.check_schema(made)
    return jsonschema.Draft202012Validator(made)


def load(path, folder):
    if folder == "rigs":
        check_profile(load_profile(path, REGISTRY, (), (CONFIGS,)))
    elif folder == "sweeps":
        load_sweep(path)
    else:
        load_experiment(path, REGISTRY, (), (CONFIGS,))


def plan(path, folder):
    """Load an experiment with its rig, which knows the laws that it has."""
    if folder != "experiments":
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
        ("experiments", "cylinder-sine",
         "figures: [tracking, error, frequency-response, pressures, limits, timing]",
         ["figures: tracking", "figures: [1]", "figure: [tracking]"]),
        ("experiments", "cylinder-sine", "max: 0.9 mm",
         ["max: often", "most: 0.9 mm", "max: [1]", "max: '0.1'", "max: true"]),
        ("experiments", "arm-elbow-circle", "law: esc",
         ["law: pid", "law: cascade", "law: super-twisting", "controller: pid\nlaw: esc"]),
        ("rigs", "cylinder-valves", "driver: cia401-valves",
         ["driver: cia401", "driver: cia401-valve", "driver: load-cells", "driver: cia410"]),
        ("rigs", "cylinder-valves", "opening: [-1, 1]",
         ["opening: [-1]", "opening: [-1, 1, 1]", "opening: shut", "opening: [shut, 1]",
          "pressure: [0 kPa, 500 kPa]", "open: [-1, 1]"]),
        ("rigs", "cylinder-valves", "supply_bit: 0",
         ["supply_bit: -1", "supply_bit: 0.5", "supply_bit: true", "supply: 0"]),
        ("rigs", "cylinder-valves", "loop: {gain: 80, lag: 5 ms, preview: 3 ms}",
         ["loop: {gain: 0, lag: 5 ms}", "loop: {gain: -80}", "loop: {gain: 80, lag: '5'}",
          "loop: {gain: 80, lags: 5 ms}", "loop: 80", "loop: {gain: 80, preview: -3 ms}",
          "loops: {gain: 80}"]),
        ("rigs", "cylinder-valves", "feeds_from: 0.008",
         ["feeds_from: soon", "feeds_from: 5", "feeds: 0.008", "feeds_from: [0.008]"]),
        ("rigs", "cylinder-valves", "conductance_in: 3.6e-9",
         ["conductance_in: 0", "conductance_in: 1", "conductance_in: '3.6e-9'",
          "conductance: 3.6e-9"]),
        ("rigs", "legs-balance", "driver: load-cells",
         ["driver: load-cell", "driver: cia410", "driver: cia401", "driver: [load-cells]"]),
        ("rigs", "legs-balance", "{sub: 1, force: [-100 N, 100 N]}",
         ["{sub: -1, force: [-100 N, 100 N]}", "{sub: 1, force: [-100 N]}",
          "{sub: 1, force: 100 N}", "{sub: 1, force: ['-100', 100 N]}",
          "{sub: 1, weight: [-100 N, 100 N]}", "1", "{sub: one, force: [-100 N, 100 N]}"]),
        ("rigs", "legs-balance", "driver: cia410",
         ["driver: cia411", "driver: cia410\n    rolls: {}",
          "driver: cia410\n    roll: {reversed: 1}", "driver: cia410\n    roll: reversed"]),
        ("rigs", "legs-balance", "load_cells: [feet]",
         ["load_cells: feet", "load_cells: [1]", "load_cell: [feet]", "load_cells: {feet: 1}"]),
        ("rigs", "legs-balance", "inertial: waist",
         ["inertial: [waist]", "inertial: 2", "inertials: waist"]),
        ("rigs", "legs-balance", "sag: {stiffness: 150 N m/rad}",
         ["sag: {stiffness: '150'}", "sag: {stiffness: -1 N m/rad}", "sag: {stiffness: 0}",
          "sag: {stiff: 150 N m/rad}", "sag: 150 N m/rad", "sag: true", "sagging: {}"]),
        ("rigs", "legs-balance", "stabiliser: {}",
         ["stabiliser: true", "stabilizer: {}", "stabiliser: {recovery: fast}",
          "stabiliser: {recovery: -1}", "stabiliser: {recover: 0.5}", "stabiliser: []"]),
        ("rigs", "legs-balance", "legs:\n",
         ["legs:\n  cell_inset: -1\n", "legs:\n  cell_inset: 1\n", "legs:\n  cell_inset: '0.005'\n",
          "legs:\n  cell_inset: [5 mm]\n", "legs:\n  cells_inset: 5 mm\n"]),
        ("experiments", "legs-footsteps", "{foot: right, x: 32 mm, y: -38 mm, heading: 8 deg}",
         ["{foot: middle, x: 32 mm, y: -38 mm}", "{foot: right, x: '32', y: -38 mm}",
          "{x: 32 mm, y: -38 mm}", "{foot: right, x: 32 mm, z: -38 mm}", "[32 mm, -38 mm]",
          "{foot: right, x: 32 mm, y: -38 mm, swing: -1 s}"]),
        ("experiments", "arm-path", "- [120 mm, 0 mm, 0 mm]",
         ["- [120 mm, 0 mm]", "- ['120', 0 mm, 0 mm]", "- 120 mm", "- {x: 120 mm}",
          "- [far, 0 mm, 0 mm]"]),
        ("sweeps", "cylinder-ideal-units", "experiment: cylinder-ideal-sine",
         ["experiment: 3", "experiment: [cylinder-ideal-sine]", "experiment:", "experiment: ''",
          "experiments: cylinder-ideal-sine", "experiment: true"]),
        ("sweeps", "cylinder-ideal-units", "on: sim",
         ["on: moon", "on: 3", "on: [sim]", "backend: sim", "on: true"]),
        ("sweeps", "cylinder-ideal-units", "setpoint_offset: 3 kPa",
         ["setpoint_offset: '3'", "setpoint_offset: -3", "setpoint_offset: 1e6",
          "set_point_offset: 3 kPa", "setpoint_offset: [3 kPa]"]),
        ("sweeps", "cylinder-ideal-units", "repeat: 20",
         ["repeat: 0", "repeat: -1", "repeat: many", "repeat: 1.5", "repeat: true",
          "repeat: 100001", "repeat: 20\nseeds: 0:3", "seeds: 0..20", "seeds: []", "seeds: -1",
          "seeds: [a]", "seeds: 1.5", "seeds: {}", "seed: 20"]),
        ("sweeps", "cylinder-ideal-units", "metric: tracking_rms",
         ["metric: 3", "metric: [tracking_rms]", "keep: -1", "keep: some", "keep: 1.5",
          "keep: true", "workers: -1", "workers: 1025", "workers: two", "workers: '2'",
          "draw_seed: -1", "draw_seed: x", "stop_when: tracking_rms", "stop_when: 3",
          "stop_when: tracking_rms < small", "stop_when: tracking_rms < nan", "budget: often",
          "budget: 30", "budget: [30 min]", "dask: 3", "out: 3", "out: [x]",
          "set: x", "set: [x]", "vary: x=1", "vary: {controller: 3}", "vary: {controller: []}",
          "vary: {controller: {}}", "vary: [controller]", "rig: 3", "serial: true"]),
        ("sweeps", "joint", "variations:\n",
         ["variations:\n  worst: {plant.friction_scale: 2}\n",
          "variations:\n  nominal: {plant.friction_scale: 2}\n",
          "variations:\n  2 x: {plant.friction_scale: 2}\n", "variations:\n  nothing: {}\n",
          "variations:\n  text: plant.friction_scale=2\n", "variation:\n"]),
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
    assert len(BROKEN) >= 200
    assert {folder for folder, *_ in BROKEN} == set(SCHEMAS)


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
