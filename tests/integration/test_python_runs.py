"""`import rig`: runs from Python, and what becomes of their exceptions."""

import json
import math
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import rig
from controllers.cylinder.pid import Pid
from rig.cli import invoke
from rig.mechanisms.cylinder.references import Sine, SineTone
from rig.runtime.phases import Phase

SHORT = {"approach": 0.5, "reference.levels": "[0, 2 mm]", "reference.dwell": 0.5}
ONE_FIGURE = SHORT | {"figures": "[timing]"}


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    return tmp_path_factory.mktemp("runs")


@pytest.fixture(scope="module")
def recorded(out):
    return rig.run("cylinder-staircase", on="sim", set=SHORT, seed=3, out=out)


def test_importing_costs_nothing():
    heavy = ("numpy", "pydantic", "click")
    asked = f"import rig, sys; print([m for m in {heavy} if m in sys.modules])"
    told = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "[]"


def test_everything_offered_is_there():
    for name in rig.__all__:
        assert getattr(rig, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'walk'"):
        rig.walk  # noqa: B018


def test_a_simulation_may_be_held_at_a_pace(out):
    """Whoever steers it from Python lives in real time."""
    began = time.monotonic()
    quick = SHORT | {"reference.levels": "[0, 0]", "reference.dwell": 0.2}
    run = rig.run("cylinder-staircase", on="sim", set=quick, pace=2.0, out=out)
    assert time.monotonic() - began > 0.5 * run.data["t"][-1] - 0.1
    for wrong in (0, -1.0, math.nan, math.inf, "fast", True):
        with pytest.raises(rig.ConfigurationError, match=r"pace is .*: a number, at least 0\.01"):
            rig.run("cylinder-staircase", on="sim", pace=wrong, out=out)


def test_a_run_tells_what_was_recorded(recorded):
    assert recorded.status == "ok"
    assert recorded.manifest["seed"] == 3
    error = recorded.metrics["hold_rms"]
    assert error.unit == "m"
    assert 0 < float(error) < 1e-3
    data = recorded.data
    assert recorded.units["reading.position"] == "m"
    assert np.all(np.diff(data["t"]) > 0)
    assert recorded.events[0]["kind"] == "state"
    assert recorded.figure("tracking").axes
    assert recorded.report.read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(KeyError, match="hold_rms"):
        recorded.metrics["marker_rms"]
    with pytest.raises(
        rig.ConfigurationError,
        match=r"there are tracking, error, pressures, .*timing, limits, truth$",
    ):
        recorded.figure("nothing")
    with pytest.raises(rig.ConfigurationError, match="has not recorded what marker-track shows"):
        recorded.figure("marker-track")


def test_pandas_takes_the_data(recorded):
    pytest.importorskip("pandas")
    frame = recorded.frame()
    assert frame.index.name == "t"
    assert frame["reading.position"].to_numpy() == pytest.approx(recorded.data["reading.position"])


def test_it_is_loaded_and_found_again(recorded, out):
    assert rig.load(recorded.path).metrics == recorded.metrics
    assert recorded.path in [run.path for run in rig.runs(out)]
    assert not rig.runs(out, where=lambda run: run.manifest["seed"] == 77)
    with pytest.raises(rig.ConfigurationError, match="not a run folder"):
        rig.load(out)


def test_runs_side_by_side(recorded, out):
    other = rig.run("cylinder-staircase", on="sim", set=SHORT, seed=3, controller="pid", out=out)
    compared = rig.compare({"ours": recorded, "pid": other})
    rows = {row["name"]: row["values"] for row in compared.rows}
    assert rows["hold_rms"] == [float(run.metrics["hold_rms"]) for run in (recorded, other)]
    assert "pid" in repr(compared)
    assert "<table>" in compared._repr_html_()
    assert compared.figure().axes
    with pytest.raises(rig.ConfigurationError, match="two runs"):
        rig.compare([recorded])


def test_a_run_is_replayed(recorded, out):
    found = rig.replay(recorded)
    assert found.same
    assert found.cycles == len(recorded.data)
    assert np.any(rig.replay(recorded, controller="pid").most > 1e3)
    given = rig.run("cylinder-staircase", on="sim", set=SHORT, controller=Pid, out=out)
    with pytest.raises(rig.ConfigurationError, match=r"given from Python \(code/: Pid.py\)"):
        rig.replay(given)


def test_a_check_says_what_a_file_says():
    assert rig.check("cylinder")["name"] == "cylinder"
    assert rig.check("cylinder-sine")["experiment"]["name"] == "cylinder-sine"
    with pytest.raises(rig.ConfigurationError, match="did you mean"):
        rig.check("cylindre")


@pytest.mark.parametrize(
    ("rig_name", "wrong", "said"),
    [
        ("cylinder", {"readings": "no-such-file.csv"}, "cannot read no-such-file.csv"),
        ("cylinder", {"readings": 3}, "readings is 3, and no path"),
        ("cylinder", {"procedure": "friction", "readings": "x.csv"}, "friction reads no instrum"),
        ("cylinder", {"conditions": ["hot"]}, "conditions are .*must be words by their names"),
        ("cylinder", {"conditions": {"temperature": 21.0}}, "conditions are"),
        ("cylinder", {"operator": 7}, "operator is 7"),
        ("cylinder", {"procedure": 7}, "procedure is 7"),
        (7, {}, "rig is 7"), ("cylinder", {"on": "mars"}, "'mars' is neither"),
    ],
)  # fmt: skip
def test_what_is_wrong_of_a_calibration_is_said_before_anything_moves(
    rig_name, wrong, said, tmp_path
):
    with pytest.raises(rig.ConfigurationError, match=said):
        rig.calibrate(
            rig_name, **{"procedure": "regulators", "on": "sim", "out": tmp_path, **wrong}
        )
    assert not list(tmp_path.iterdir())


def test_a_calibration_is_written(tmp_path):
    configs = tmp_path / "configs"
    shutil.copytree(
        Path(__file__).parents[2] / "configs",
        configs,
        ignore=shutil.ignore_patterns("calibration", "commissioning"),
    )
    done = rig.calibrate(
        "cylinder-uncalibrated", "encoders", out=tmp_path, configs=configs, on="sim"
    )
    assert done.files
    lines = repr(done).splitlines()
    assert lines[-len(done.files) :] == [str(path) for path in done.files]
    estimates = [one for finding in done.findings for one in finding.estimates]
    assert len(lines) == len(estimates) + len(done.files)
    for line, estimate in zip(lines, estimates, strict=False):
        assert f" {estimate.name}: " in line and "95 %" in line
    assert all(path.is_relative_to(configs) for path in done.files)
    with pytest.raises(rig.ConfigurationError, match="yes='cylinder'"):
        rig.calibrate("cylinder", "encoders", out=tmp_path, configs=configs, on="hardware")


# How a run ends ---------------------------------------------------------------------------


def test_a_missed_bound_is_an_exception_only_if_asked_for(out):
    wrong = SHORT | {"metrics.hold_rms.max": "1 nm"}
    run = rig.run("cylinder-staircase", on="sim", set=wrong, out=out)
    assert run.status == "failed"
    assert run.metrics["hold_rms"].passed is False
    with pytest.raises(rig.BoundMissed) as missed:
        rig.run("cylinder-staircase", on="sim", set=wrong, out=out, strict=True)
    assert missed.value.run.status == "failed"


def test_a_fault_is_an_exception_with_its_run(out):
    fault = "[{at: 2.0, device: regulators, fault: emergency_stop}]"
    with pytest.raises(rig.RunFaulted, match="emergency stop") as faulted:
        rig.run("cylinder-staircase", on="sim", set={**SHORT, "simulation.faults": fault}, out=out)
    assert isinstance(faulted.value, rig.RigError)
    assert faulted.value.run.status == "faulted"
    assert len(faulted.value.run.data)


BEARS = {"cylinder.limits.stop_energy": "1 J"}


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"set": {"reference.amplitud": 1}}, "^set={'reference.amplitud': 1}: unknown key 'ampli"),
        ({"set": {"reference.dwell": [1]}}, r"^set={'reference.dwell': \[1\]}: dwell"),
        ({"set": {"loop.rate": "1 m"}}, "^set={'loop.rate': '1 m'}: loop.rate: '1 m' is not in Hz"),
        ({"set": {"nothing.at.all": 1}}, "^set={'nothing.at.all': 1}: there is no key 'nothing'"),
        (
            {"set": {"limits.speed": 1}},
            r"no key 'limits'; did you mean 'cylinder\.limits\.speed'\?$",
        ),
        ({"seed": -3}, "^seed=-3: seed is -3, expected at least 0"),
        (
            {"controller": "pdi"},
            r"(?s)^controller='pdi': no controller is called 'pdi'.*did you mean pid\?$",
        ),
        ({"controller": "pdi", "rig": "arm"}, "are: dls, esc, esc-paper, inv"),
        ({"controller": object()}, "it has no"),
        ({"controller": 3.0}, "it has no"),
        ({"reference": object()}, "not one for a pair"),
        ({"reference": Sine}, "make one of it"),
        ({"reference": Sine("4 N", ())}, r"^reference=Sine\(…\): amplitude: '4 N' is not in m"),
        ({"reference": Sine(0.5, (SineTone(1.0, 2),))}, "outside limits.position"),
        ({"plan": 3}, "no function of the rig"),
        ({"plan": lambda r: None, "reference": object()}, "not both"),
        ({"measures": {"m": "text"}}, "measure m"),
        ({"measures": {"hold_rms": len}}, "cylinder-staircase has a metric of this name"),
        ({"measures": {"m": (len, "parsec")}}, "measure m: .*parsec.*usual units are m, cm"),
        ({"measures": {"m": (len, "m/s/")}}, "measure m: .*usual units are"),
        ({"on": "mars"}, "'mars' is neither one of sim, virtual, vcan, hardware nor a CAN inter"),
        ({"on": "Sim"}, "'Sim' is neither one of sim"),
        (
            {"on": "hardware", "set": {**BEARS, "controllers.cascade.velocity_rate": 700}},
            "loop.small_margin",
        ),
        ({"on": "hardware", "set": {**BEARS, "loop.small_margin": "x"}}, "yes='cylinder'"),
    ],
)
def test_what_is_wrong_is_a_sentence_before_anything_moves(out, wrong, said):
    before = set(out.iterdir())
    with pytest.raises(rig.RigError, match=said):
        rig.run("cylinder-staircase", **{"on": "sim", "out": out, **wrong})
    assert set(out.iterdir()) == before


# Python objects ---------------------------------------------------------------------------


class Halved(Pid):
    """Half of what a PID wants."""

    def update(self, state, reference, load=0.0):
        command = super().update(state, reference, load)
        mean = 0.5 * (command.agonist + command.antagonist)
        return type(command)(*(mean + 0.5 * (side - mean) for side in command))


def excursion(data):
    """How far beyond the last level, m."""
    return np.max(data["reading.position"]) - data["reference.position"][-1]


def test_a_law_and_a_measure_in_python(out):
    wanted = {"excursion": (excursion, "m"), "cycles": len}
    run, other = (
        rig.run(
            "cylinder-staircase", on="sim", set=ONE_FIGURE, controller=law, measures=wanted, out=out
        )
        for law in (Halved, Pid)
    )
    assert float(run.metrics["hold_rms"]) != float(other.metrics["hold_rms"])
    assert run.metrics["excursion"].unit == "m"
    followed = run.data[run.data["phase"] == 1]
    assert float(run.metrics["excursion"]) == excursion(followed)
    assert float(run.metrics["cycles"]) == len(followed)
    kept = (run.path / "code" / "Halved.py").read_text()
    assert "Half of what a PID wants." in kept
    assert "code/Halved.py" in run.manifest["files"]
    before = dict(run.metrics)
    assert run.report.exists()  # derives all metrics once more; these came with the run
    assert dict(rig.load(run.path).metrics) == before


def divides(data):
    return 1 / 0


def leaves(data):
    raise SystemExit(3)


def misses(data):
    return data["no.such.column"].max()


def returns_text(data):
    return "much"


@pytest.mark.parametrize(
    ("broken", "said", "line"),
    [
        (divides, "ZeroDivisionError: division by zero", 1),
        (leaves, "SystemExit: 3", 1),
        (misses, "ValueError: no field of name no.such.column", 1),
        (returns_text, "returned 'much', and no number", 0),
    ],
)
@pytest.mark.parametrize("bound", ["1 m", "1 nm"])
def test_a_measure_that_fails_says_where_and_leaves_the_run_as_it_was(
    broken, said, line, bound, out
):
    wanted = {"first": len, "bad": broken, "last": (excursion, "m")}
    setting = ONE_FIGURE | {"metrics.hold_rms.max": bound}
    with pytest.raises(rig.MeasureFailed) as failed:
        rig.run("cylinder-staircase", on="sim", set=setting, out=out, measures=wanted)
    assert f"measure bad ({__file__}, line {broken.__code__.co_firstlineno + line})" in str(
        failed.value
    )
    assert said in str(failed.value)
    run = failed.value.run
    assert str(run.path) in str(failed.value)
    assert (run.status, run.manifest["exit_code"]) == (
        ("ok", 0) if bound == "1 m" else ("failed", 1)
    )
    assert isinstance(failed.value, rig.RunError)
    assert len(run.data) == float(run.metrics["first"]) + np.sum(run.data["phase"] != 1)
    assert {"hold_rms", "first", "last"} < set(run.metrics) and "bad" not in run.metrics
    assert [event["message"] for event in run.events if event["kind"] == "measure"] == [
        str(failed.value).removesuffix(f" ({run.path})")
    ]
    assert "measure bad" in run.report.read_text()


def test_a_measure_that_is_nan_says_so_and_one_that_never_came_does_not(out, capsys):
    wanted = {"strange": lambda data: math.nan, "late": lambda data: math.inf}
    run = rig.run("cylinder-staircase", on="sim", set=ONE_FIGURE, out=out, measures=wanted)
    assert str(run.metrics["strange"]) == "NaN" and str(run.metrics["late"]) == "never"
    page = run.report.read_text()
    assert "NaN</td>" in page and "never</td>" in page
    again = rig.load(run.path).metrics
    assert str(again["strange"]) == "NaN" and str(again["late"]) == "never"
    (run.path / "metrics.json").write_text(json.dumps({"metrics": [
        row for row in json.loads((run.path / "metrics.json").read_text())["metrics"]
        if row["name"] == "strange"]}))  # fmt: skip
    capsys.readouterr()
    assert invoke(["list", "runs", "--out", str(out)]) == 0
    assert "strange NaN" in capsys.readouterr().out


def test_a_reference_in_python_is_checked_like_ours(out):
    sine = Sine(4e-3, (SineTone(1.0, 2),))
    run = rig.run("cylinder-staircase", on="sim", reference=sine, set={"approach": 0.5}, out=out)
    runs = run.data["phase"] == Phase.RUN  # afterwards it is where the pair is let go
    assert np.max(run.data["reference.position"][runs]) == pytest.approx(4e-3, rel=0.02)
    assert run.metrics["pressure_min"].bound is None  # which was made for another motion


# Threads ----------------------------------------------------------------------------------


def test_runs_in_threads_of_another_program(out):
    def in_thread(seed):
        return rig.run("cylinder-staircase", on="sim", set=SHORT, seed=seed, out=out)

    with ThreadPoolExecutor(2) as threads:
        runs = list(threads.map(in_thread, (3, 4)))
    alone = rig.run("cylinder-staircase", on="sim", set=SHORT, seed=4, out=out)
    assert dict(runs[1].metrics) == dict(alone.metrics)
    assert dict(runs[0].metrics) != dict(alone.metrics)


def is_under_way(folder):
    log = folder / "log.mcap"
    return log.exists() and log.stat().st_size > 300_000


def test_another_thread_may_stop_a_run(out):
    stop, ended = rig.StopRequests(), []

    def in_thread():
        try:
            rig.run("cylinder-sine", on="virtual", stop=stop, out=out)
        except rig.RunInterrupted as error:
            ended.append(error)

    before = set(out.iterdir())
    thread = threading.Thread(target=in_thread)
    thread.start()
    while not any(is_under_way(folder) for folder in set(out.iterdir()) - before):
        time.sleep(0.02)
    stop.request()
    thread.join(60)
    assert not thread.is_alive()
    (error,) = ended
    assert error.run.status == "aborted"


def test_a_mapping_among_settings_holds_what_yaml_does():
    """Python's own words for true and for nothing are none of YAML's."""
    numbers = {"count": 2, "together": True, "width": None, "length": "20 mm", "first": "left"}
    text = "{count: 2, together: true, width: null, length: 20 mm, first: left}"
    found = [
        rig.check("legs-footsteps", set={"reference.steps": [], "reference.numbers": given})
        for given in (numbers, text)
    ]
    assert found[0]["experiment"] == found[1]["experiment"]
