"""A package that nobody here wrote, through the whole command line.

`tests/stranger` is such a package: a mechanism with everything that belongs to it, a sensor that is
only logged, a regulator with a code of its own, a law and a path for mechanisms of ours.
"""

import importlib.util
import json
import shutil

import numpy as np
import pytest
from stranger_lab import (
    PACKAGE,
    PROJECT,
    SOURCE,
    Lab,
    beside_the_source,
    in_an_environment,
    metrics_of,
)

from rig.runtime.log import read_log

TRUE_ZERO = 0.015  # rad, of the plant's settings


@pytest.fixture(scope="module", params=["path", pytest.param("venv", marks=pytest.mark.slow)])
def lab(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    shutil.copytree(SOURCE / "crank_rig" / "configs", folder / "configs")
    if request.param == "path":
        return Lab(folder, beside_the_source(folder / "site"))
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("hatchling is not installed, which builds the package")
    return Lab(folder, [], in_an_environment(folder / "venv"))


@pytest.fixture(scope="module")
def recorded(lab):
    """Return a run of the crank on virtual CAN, with its frames."""
    return lab.run("crank-turns", "--on", "virtual", "--frames")


@pytest.fixture(scope="module")
def simulated(lab):
    """Return a run of the crank without a bus."""
    return lab.run("crank-turns", "--on", "sim")


def test_what_it_has_is_listed(lab):
    rigs = [rig["name"] for rig in json.loads(lab.rig("list", "rigs", "--json").stdout)]
    assert {"crank", "cylinder-tecno", "our-arm", "arm", "cylinder"} <= set(rigs)
    experiments = lab.rig("list", "experiments").stdout
    assert "crank-turns" in experiments
    assert "cylinder-sine" in experiments


def test_check_says_what_it_says_of_ours(lab):
    done = lab.rig("check", "crank-turns", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["profile"]["mechanism"] == "crank"
    assert said["profile"]["controllers"] == ["cross-coupled", "independent"]
    assert [s["name"] for s in said["experiment"]["segments"]] == [
        "to at 3 rad/s",
        "fro at 5 rad/s",
    ]
    assert [m["unit"] for m in said["experiment"]["metrics"]] == ["rad", "rad"]
    assert "valid" in lab.rig("check", "cylinder-tecno").stderr


PLAN = """
import rig

def apart(r):
    zero = r.goal.positions
    yield r.move([zero[0] + 0.1, zero[1] + 0.1], 0.5)
    r.mark("turned")
    assert (yield r.settle(0.02)), r.state

run = rig.run("crank-turns", on="virtual", plan=apart)
print(run.status, [segment.name for segment in run.segments], sorted(run.metrics))
"""


def test_a_plan_in_python_moves_it(lab):
    done = lab.python_run("-c", PLAN)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("ok ['all', 'turned']")


def test_a_typing_error_is_shown_with_its_place(lab):
    done = lab.rig("check", "crank-turns", "--set", "crank.max_twsit=1")
    assert done.returncode == 2
    assert "did you mean max_twist" in done.stderr


def test_its_schema_is_part_of_the_schema(lab):
    words = ("max_twist", '"load-cell"', "rod_stiffness", "cross-coupled")
    schema = lab.rig("schema", "profile", "crank")
    assert schema.returncode == 0, schema.stderr
    assert all(word in schema.stdout for word in words)
    assert "crank-turns" in lab.rig("schema", "experiment", "crank").stdout
    without = lab.rig("schema", "profile")
    assert not any(word in without.stdout for word in words)


def test_what_its_words_mean_is_explained_with_its_rig(lab):
    assert lab.rig("explain", "crank.rod_zero").returncode == 2
    explained = lab.rig("explain", "crank.rod_zero", "--rig", "crank")
    assert explained.returncode == 0, explained.stderr
    assert "crank.rod_zero" in explained.stdout


def test_the_simulation_is_offered(lab):
    done = lab.rig("simulate", "--help")
    assert done.returncode == 0
    assert "RIG" in done.stdout


def test_run_without_a_bus(simulated):
    metrics = metrics_of(simulated)
    assert metrics["rod_twist"]["pass"] and metrics["turning_rms"]["pass"]
    assert {"twist.png", "twist.svg"} <= {file.name for file in (simulated / "figures").iterdir()}
    assert "Twist of the rod" in (simulated / "report.html").read_text()


def test_run_on_virtual_can(recorded):
    metrics = metrics_of(recorded)
    assert metrics["rod_twist"]["unit"] == "rad"
    assert metrics["rod_twist"]["pass"] and metrics["turning_rms"]["pass"]


@pytest.mark.parametrize("backend", ["sim", "virtual"])
def test_a_sensor_that_nobody_uses_is_logged_with_its_unit(simulated, recorded, backend):
    """It has no simulation of its own: what its settings describe is enough."""
    path = recorded if backend == "virtual" else simulated
    log = read_log(path / "log.mcap")
    (column,) = [c for c in log.columns if c.name == "device.rod_force_force"]
    assert column.unit == "N"
    force, torque = log.column(column.name), log.column("truth.rod_torque")
    assert np.ptp(force) > 10.0
    # One cycle old, and in steps of 15 mN.
    assert np.corrcoef(force[1:], torque[:-1])[0, 1] > 0.99


def test_monitor_reads_its_frames_in_its_names(lab, recorded):
    done = lab.rig("monitor", "crank", "--frames", recorded)
    assert done.returncode == 0, done.stderr
    assert "drives left" in done.stdout
    assert "target position" in done.stdout
    assert "rod-force" in done.stdout


def test_report_is_made_again(lab, recorded):
    (recorded / "report.html").unlink()
    shutil.rmtree(recorded / "figures")
    done = lab.rig("report", recorded)
    assert done.returncode == 0, done.stderr
    assert (recorded / "figures" / "twist.png").exists()
    assert "Twist of the rod" in (recorded / "report.html").read_text()


@pytest.mark.slow
def test_compare_draws_its_own_comparison(lab):
    done = lab.rig("compare", "crank-turns", "--on", "sim")
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    assert header.split() == ["cross-coupled", "independent"]
    assert [row.split()[0] for row in rows] == ["turning_rms", "rod_twist"]
    (figure,) = lab.folder.glob("runs/*compare/compare.svg")
    assert "mrad" in figure.read_text()


@pytest.mark.slow
def test_calibration_finds_what_is_true_and_is_laid_over(lab):
    refused = lab.rig("calibrate", "crank", "rod-zreo", "--yes")
    assert refused.returncode == 2
    assert "did you mean rod-zero" in refused.stderr
    done = lab.rig("calibrate", "crank", "rod-zero", "--yes")
    assert done.returncode == 0, done.stderr
    assert "the right one leads by up to" in done.stderr
    text = (lab.folder / "configs" / "calibration" / "crank" / "crank.yaml").read_text()
    found = float(text.split("rod_zero:")[1].split()[0])
    assert found == pytest.approx(TRUE_ZERO, abs=1e-4)
    try:
        checked = json.loads(lab.rig("check", "crank", "--json").stdout)["profile"]
        assert checked["calibrations"][0]["procedure"] == "rod-zero"
        calibrated = metrics_of(lab.run("crank-turns", "--on", "sim"))
        assert calibrated["rod_twist"]["value"] < 5e-4
    finally:
        shutil.rmtree(lab.folder / "configs" / "calibration")


def test_another_codec_in_the_place_of_ours_under_a_law_of_its_own(lab):
    path = lab.run("tecno-sine", "--on", "virtual", "--frames")
    metrics = metrics_of(path)
    assert metrics["tracking_rms"]["pass"]
    done = lab.rig("monitor", "cylinder-tecno", "--frames", path)
    assert "kPa, supply open" in done.stdout


@pytest.mark.slow
def test_a_fault_of_its_node_is_a_fault_of_the_run(lab):
    fault = "simulation.faults=[{at: 3 s, device: regulators, fault: regulator_fault}]"
    done = lab.rig("run", "tecno-sine", "--on", "virtual", "--set", fault)
    assert done.returncode == 4
    assert "regulators: a regulator reports a fault" in done.stderr


@pytest.mark.slow
def test_a_path_of_its_own_for_an_arm(lab):
    assert metrics_of(lab.run("arm-sway", "--on", "sim"))["completes"]["value"] == 1.0


@pytest.mark.slow
def test_it_passes_the_suites_of_the_contract(lab):
    done = lab.python_run(
        "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error", "-c", "/dev/null",
        "--rootdir", PACKAGE / "tests", PACKAGE / "tests",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:]
    assert "failed" not in done.stdout


def test_faults_break_it_and_its_own_hazards_judge(lab):
    listed = lab.rig("faults", "list", "crank", "--json")
    assert listed.returncode == 0, listed.stderr
    assert {"drive_fault", "setpoints_lost"} <= {
        kind["fault"] for kind in json.loads(listed.stdout)
    }
    done = lab.rig("faults", "run", "crank", "--random", "6", "--json")
    assert done.returncode in (0, 1), done.stderr
    verdicts = json.loads(done.stdout)
    assert len(verdicts) == 6
    assert not any(verdict["crashed"] for verdict in verdicts), done.stderr


def test_the_manifest_names_its_version_and_code(recorded):
    plug_in = json.loads((recorded / "manifest.json").read_text())["plug_ins"]["crank_rig"]
    assert (plug_in["distribution"], plug_in["version"]) == (PROJECT["name"], PROJECT["version"])
    assert len(plug_in["sha256"]) == 64
