"""`rig new`: what it writes runs at once, and passes its own test."""

import json
import random
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from stranger_lab import Lab, beside_the_source

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import load_experiment, load_profile
from rig.config.names import find_configs, list_files
from rig.runtime.log import LogFile, read_log


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("mechanism", ["arm", "cylinder", "joint", "legs"])
def test_an_experiment_of_any_rig_is_valid(here, capsys, mechanism):
    assert mechanism in REGISTRY.names("mechanism")
    assert invoke(["new", "experiment", "first-try", "--rig", mechanism]) == 0
    assert invoke(["check", "first-try.yaml"]) == 0
    text = (here / "first-try.yaml").read_text()
    assert f"rig: {mechanism}" in text
    assert text.count("\nname: ") == 1
    assert "rig check first-try.yaml" in capsys.readouterr().err


@pytest.mark.parametrize("seed", range(3))
def test_a_rig_begins_as_any_other(here, capsys, seed):
    like = random.Random(seed).choice(list(list_files("rigs", find_configs())))
    assert invoke(["new", "rig", "our-own", "--like", like]) == 0
    assert invoke(["check", "our-own.yaml"]) == 0
    text = (here / "our-own.yaml").read_text()
    assert f"extends: {like}" in text
    # What is said of it is said as a comment.
    assert sum(not line.startswith("#") and bool(line) for line in text.splitlines()) == 3


@pytest.mark.parametrize("like", ["cylinder-step", "cylinder-sine"])
def test_an_experiment_like_another_is_of_the_rig_that_is_said(here, like):
    assert invoke(["new", "experiment", "a", "--rig", "cylinder-ideal", "--like", like]) == 0
    assert invoke(["new", "experiment", "b", "--like", like]) == 0
    for name, rig in (("a", "cylinder-ideal"), ("b", "cylinder")):
        experiment = load_experiment(f"{name}.yaml", REGISTRY, (), find_configs())
        assert experiment.rig == rig


def project_of(folder):
    return tomllib.loads((folder / "pyproject.toml").read_text())["project"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name"),
    [("controller", "slow-pi"), ("driver", "grip-force2"), ("mechanism", "turn-table")],
)
def test_a_package_runs_at_once_and_passes_its_own_test(here, kind, name):
    assert invoke(["new", kind, name]) == 0
    folder = here / name
    assert "my_" not in "".join(path.read_text() for path in folder.rglob("*.py"))
    paths = beside_the_source(here / "installed", project_of(folder), folder / "src")
    lab = Lab(folder, paths)
    [first] = (folder / "configs" / "experiments").iterdir()
    run = lab.run(first.stem, "--on", "sim", "--no-report")
    assert (run / "log.mcap").exists()
    tested = lab.python_run("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests")
    assert tested.returncode == 0, tested.stdout
    assert " passed" in tested.stdout


def test_a_package_keeps_its_tests_apart_from_what_it_lies_in(here):
    assert invoke(["new", "driver", "oil-thermometer"]) == 0
    (here / "pyproject.toml").write_text('[tool.pytest.ini_options]\naddopts = "--not-known"\n')
    listed = subprocess.run(
        [sys.executable, "-m", "pytest", "--collect-only", "-q", "tests"],
        cwd=here / "oil-thermometer", capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert listed.returncode == 0, listed.stderr
    assert "test_oil_thermometer.py" in listed.stdout


def test_a_channel_that_no_plant_has_and_a_unit_of_nobody_are_told_before_a_run(here):
    assert invoke(["new", "driver", "supply-gauge"]) == 0
    folder = here / "supply-gauge"
    rig = "configs/rigs/supply-gauge-rig.yaml"
    lines = (folder / rig).read_text().splitlines()
    place = next(n for n, line in enumerate(lines, 1) if line.startswith("    measures: agonist"))
    paths = beside_the_source(here / "installed", project_of(folder), folder / "src")
    lab = Lab(folder, paths)

    (folder / rig).write_text("\n".join(lines).replace("unit: N ", "unit: furlong "))
    checked = lab.rig("check", "supply-gauge-rig")
    assert checked.returncode == 0
    [warning] = [line for line in checked.stderr.splitlines() if line.startswith("warning")]
    assert "devices.supply-gauge.unit: device.supply_gauge_value is in furlong" in warning
    assert f"    devices.supply-gauge.unit: {rig}:" in checked.stderr

    (folder / rig).write_text("\n".join(lines).replace("measures: agonist", "measures: supply"))
    for command in (["check", "supply-gauge-rig"], ["run", "supply-gauge-sine", "--on", "sim"]):
        refused = lab.rig(*command)
        assert refused.returncode == 2
        assert "antagonistic-pair has no channel supply; it has agonist" in refused.stderr
        assert f"devices.supply-gauge.measures: {rig}:{place}:5" in refused.stderr

    explained = lab.rig("explain", "supply_gauge_value", "--rig", "supply-gauge-rig")
    assert explained.returncode == 0
    assert "what the sensor measures, N" in explained.stdout


@pytest.mark.slow
def test_a_sensor_is_logged_in_the_unit_that_its_profile_says(here):
    assert invoke(["new", "driver", "oil-thermometer"]) == 0
    folder = here / "oil-thermometer"
    profile = folder / "configs" / "rigs" / "oil-thermometer-rig.yaml"
    text = profile.read_text()
    assert text.count("unit: N ") == 1
    profile.write_text(text.replace("unit: N ", "unit: degC "))
    assert not [path for path in folder.rglob("*.py") if '"N"' in path.read_text()]
    paths = beside_the_source(here / "installed", project_of(folder), folder / "src")
    run = Lab(folder, paths).run("oil-thermometer-sine", "--on", "sim", "--no-report")
    units = {column.name: column.unit for column in LogFile(run / "log.mcap").columns}
    assert units["device.oil_thermometer_value"] == "degC"


@pytest.mark.slow
def test_a_sensor_whose_zero_is_off_is_read_as_one_whose_zero_is_not(here):
    """The simulated node counts from its offset, the driver adds it: who forgets it shows 20 N."""
    assert invoke(["new", "driver", "load-gauge"]) == 0
    folder = here / "load-gauge"
    profile = folder / "configs" / "rigs" / "load-gauge-rig.yaml"
    text = profile.read_text()
    paths = beside_the_source(here / "installed", project_of(folder), folder / "src")
    found = []
    for offset in ("offset: 0 ", "offset: 20 "):
        profile.write_text(text.replace("offset: 0 ", offset))
        run = Lab(folder, paths).run("load-gauge-sine", "--on", "sim", "--no-report")
        found.append(read_log(run / "log.mcap").column("device.load_gauge_value"))
    assert found[0].max() - found[0].min() > 1.0
    assert abs(found[1] - found[0]).max() < 2 * 100 / 32767


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("controller", "Fast"), "no name for files"),
        (("controller", "../x"), "no name for files"),
        (("driver", "class"), "class is a word of Python's own"),
        (("driver", "x" * 41), "at most 40 characters"),
        (("driver", "cylinder"), "cylinder is a rig already; choose another name, as my-cylinder"),
        (("driver", "cia402"), "cia402 is a driver already"),
        (("driver", "regulators"), "regulators is a device of the rig cylinder already"),
        (("driver", "device"), "its class Device would hide another one that device.py uses"),
        (("controller", "cascade"), "cascade is a controller already"),
        (("controller", "law"), "its class Law would hide another one that law.py uses"),
        (("mechanism", "joint"), "joint is a rig already"),
        (("mechanism", "loop"), "loop is a key of profiles already"),
        (("mechanism", "servo"), "its class ServoSettings would hide another one that settings.py"),
        (("rig", "cylinder"), "cylinder is a rig already"),
        (("rig", "cylinder-sine"), "cylinder-sine is an experiment already"),
        (("experiment", "cylinder-sine"), "cylinder-sine is an experiment already"),
        (("mechanism", "seesaw", "--like", "crank"), "for experiments and rigs"),
        (("experiment", "mine", "--rig", "nobody"), "no rig is called 'nobody'"),
        (("experiment", "mine", "--rig", "cylindr"), "did you mean cylinder?"),
        (("experiment", "mine", "--rig", "cylindr", "--like", "cylinder-sine"), "cylinder?"),
        (("mechanism", "true"), "its class True would be a word of Python's own"),
        (("rig", "mine", "--like", "cylindr"), "did you mean cylinder?"),
        (("controller", "mine", "--like", "x"), "for experiments and rigs"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_written(here, capsys, words, said):
    assert invoke(["new", *words]) == 2
    assert said in capsys.readouterr().err
    assert list(here.iterdir()) == []


def test_a_program_is_told_what_was_written(here, capsys):
    assert invoke(["new", "experiment", "mine", "--json"]) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert (told["kind"], told["written"], said.err) == ("experiment", "mine.yaml", "")
    assert (here / told["written"]).exists()
    assert told["next"][0] == "rig check mine.yaml"


def test_a_package_whose_files_would_hide_others_is_refused(here, capsys):
    experiments = here / "configs" / "experiments"
    experiments.mkdir(parents=True)
    (experiments / "swing-turns.yaml").write_text("rig: cylinder\n")
    assert invoke(["new", "mechanism", "swing"]) == 2
    assert "swing-turns is an experiment already, which swing would have" in capsys.readouterr().err
    assert not (here / "swing").exists()


def test_what_is_there_stays(here, capsys):
    (here / "mine.yaml").write_text("precious")
    assert invoke(["new", "experiment", "mine"]) == 2
    assert (here / "mine.yaml").read_text() == "precious"
    assert invoke(["new", "driver", "sensor"]) == 0
    before = sorted(here.rglob("*"))
    assert invoke(["new", "controller", "sensor"]) == 2
    assert sorted(here.rglob("*")) == before


ARMS = Path(__file__).parents[1] / "data" / "arms"


@pytest.mark.parametrize(
    "option",
    [
        ("--urdf", "kr-6-r900.urdf"),
        pytest.param(("--dh", "puma-560.yaml"), marks=pytest.mark.slow),
    ],
)
def test_an_arm_from_its_description_runs_at_once(here, capsys, option):
    kind, file = option
    assert invoke(["new", "rig", "our-arm", kind, str(ARMS / file)]) == 0
    noted = capsys.readouterr().err
    assert "within a nanometre" in noted
    assert "rig run arm-tour --on sim --rig our-arm.yaml" in noted
    assert invoke(["check", "our-arm.yaml"]) == 0
    assert invoke(["run", "arm-tour", "--on", "sim", "--rig", "our-arm.yaml", "--no-report"]) == 0


LARGE = """convention: standard
joints:
  - {{alpha: 90 deg, d: {base:.4f} m, range: [-170 deg, 170 deg], speed: 2 rad/s}}
  - {{a: {upper:.4f} m, range: [-60 deg, 240 deg], speed: 2 rad/s}}
  - {{a: 0 m, d: 0 m, alpha: -90 deg, range: [-240 deg, 60 deg], speed: 2 rad/s}}
  - {{d: {fore:.4f} m, alpha: 90 deg, range: [-180 deg, 180 deg], speed: 4 rad/s}}
  - {{alpha: -90 deg, range: [-120 deg, 120 deg], speed: 4 rad/s}}
  - {{range: [-300 deg, 300 deg], speed: 4 rad/s}}
tool: {tool:.4f} m
"""
FOLDED = """name: folded
rig: large.yaml
law: look-ahead
reference: {kind: arm-turn, start: [0.6, -0.3, 0.9, -1.8, 0.5, -2.0], axis: [0, 0, 1], angle: 0.3}
approach: 4 s
"""


@pytest.mark.parametrize("reach", [2.0, 6.0])
def test_the_drives_of_a_large_arm_hold_it_folded_too(here, reach):
    """Torques that bear it stretched need motors of some inertia, or they shake it folded."""
    lengths = {"base": 0.1, "upper": 0.5, "fore": 0.5, "tool": 0.1}
    Path("large-dh.yaml").write_text(LARGE.format(**{k: reach * v for k, v in lengths.items()}))
    assert invoke(["new", "rig", "large", "--dh", "large-dh.yaml"]) == 0
    Path("folded.yaml").write_text(FOLDED)
    assert invoke(["run", "folded.yaml", "--on", "sim", "--no-report"]) == 0


@pytest.mark.parametrize("shipped", ["arm-irb-120", "arm-puma-560"])
def test_a_shipped_arm_is_what_its_description_comes_to(here, shipped):
    kind, end = ("urdf", "urdf") if shipped == "arm-irb-120" else ("dh", "yaml")
    file = ARMS / f"{shipped.removeprefix('arm-')}.{end}"
    assert invoke(["new", "rig", "ours", f"--{kind}", str(file)]) == 0
    ours, theirs = (
        load_profile(name, REGISTRY, search=find_configs()) for name in ("ours.yaml", shipped)
    )
    assert ours.mechanism_settings == theirs.mechanism_settings
    assert ours.devices == theirs.devices
    assert ours.plant == theirs.plant


@pytest.mark.parametrize(
    ("words", "code", "reason"),
    [
        (["rig", "ours", "--urdf", "none.urdf"], 2, "none.urdf"),
        (["rig", "ours", "--urdf", "a", "--dh", "b"], 2, "one of --urdf, --dh"),
        (["rig", "ours", "--dh", "a", "--tip", "hand"], 2, "--tip names a link of --urdf"),
        (["rig", "ours", "--urdf", "a", "--like", "arm"], 2, "one of --urdf, --dh"),
        (["experiment", "ours", "--urdf", "a"], 2, "one of --urdf, --dh"),
    ],
)
def test_a_description_that_is_none(here, capsys, words, code, reason):
    assert invoke(["new", *words]) == code
    assert reason in capsys.readouterr().err
    assert not list(here.iterdir())


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("numpy", "a package numpy is installed already"),
        ("rig", "a package rig is installed already"),
        ("python-can", "a package python-can is installed already"),
        ("json", "json is a module of Python's own"),
    ],
)
def test_a_package_hides_no_other(tmp_path, monkeypatch, capsys, name, why):
    monkeypatch.chdir(tmp_path)
    assert invoke(["new", "controller", name]) != 0
    assert why in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
