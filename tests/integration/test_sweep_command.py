"""`rig sweep`: what it leaves, what it refuses, and that a point is the run that it names."""

import csv
import json
import random
import subprocess
import sys
from pathlib import Path

import pytest

from rig.assembly import Backend
from rig.cli import invoke
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.sweeping.api import sweep

CONFIGS = Path(__file__).parents[2] / "configs"
pytestmark = pytest.mark.usefixtures("warm_workers")
SHORT = ("--on", "sim", "--configs", CONFIGS, "--set", "loop.rate=200")
AXES = ("--vary", "plant.friction_scale=1.1,1.2", "--seeds", "0:2")
"""With less friction than it was tuned for, its gains do not come to rest at 200 Hz."""


def run(capsys, *arguments):
    code = invoke(["sweep", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_a_sweep_from_command_to_page(tmp_path, capsys):
    out = tmp_path / "sweep"
    code, shown, told = run(
        capsys, "cylinder-ideal-step", *SHORT, *AXES, "--out", out, "--workers", 2, "--keep", 1
    )
    assert code == 0
    assert "4 of 4 points: 4 ok" in told and "best in rise_time" in shown
    rows = list(csv.DictReader((out / "sweep.csv").read_text().splitlines()))
    assert [(row["plant.friction_scale"], row["simulation.seed"]) for row in rows] == [
        ("1.1", "0"), ("1.1", "1"), ("1.2", "0"), ("1.2", "1"),
    ]  # fmt: skip
    options = ["loop.rate=200", "plant.friction_scale=1.2", "simulation.seed=1"]
    plan = load_plan("cylinder-ideal-step", options, configs=CONFIGS)
    result = run_experiment(plan, Backend.SIM, tmp_path, report=False)
    for metric in result.metrics:
        assert float(rows[3][metric.name]) == metric.value
        assert rows[3][f"{metric.name}.unit"] == metric.unit
    kept = [folder.name for folder in (out / "runs").iterdir()]
    least = min(float(row["rise_time"]) for row in rows)
    best = [row["point"] for row in rows if float(row["rise_time"]) == least]
    assert len(kept) == 1 and kept[0] in best
    assert f"the best run that is kept: {out / 'runs' / kept[0]}\n" in told
    assert f'href="./runs/{kept[0]}/"' in (out / "sweep.html").read_text()
    before = {name: (out / name).read_bytes() for name in ("sweep.csv", "sweep.parquet")}
    again = sweep(
        "cylinder-ideal-step", {"plant.friction_scale": [1.1, 1.2, 1.3]}, seeds=range(2), on="sim",
        set={"loop.rate": 200}, out=out, configs=CONFIGS, workers=1, quiet=True,
    )  # fmt: skip
    assert len(again.table) == 6
    assert (out / "points.jsonl").read_text().count("\n") == 6
    assert (out / "sweep.csv").read_text().splitlines()[:5] == (
        before["sweep.csv"].decode().splitlines()
    )
    least = min(row["overshoot"] for row in again.table)
    assert again.best("overshoot")["overshoot"] == least
    assert again.figure("overshoot").axes
    serial = tmp_path / "serial"
    assert run(capsys, "cylinder-ideal-step", *SHORT, *AXES, "--out", serial, "--serial")[0] == 0
    assert {name: (serial / name).read_bytes() for name in before} == before


def test_the_folder_of_runs_is_said_as_everywhere(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    few = ("--vary", "plant.friction_scale=0.9", "--workers", 1)
    code, _, _ = run(capsys, "cylinder-ideal-step", *SHORT, *few, "--runs", "mine")
    assert code == 0
    assert (tmp_path / "mine" / "sweeps" / "cylinder-ideal-step-sim" / "sweep.csv").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]
    both = ("--runs", "mine", "--out", "other")
    code, _, told = run(capsys, "cylinder-ideal-step", *SHORT, *few, *both)
    assert code == 2 and "give one of them" in told


def test_variations_are_rows_laws_are_columns_and_what_stopped_is_named(tmp_path, capsys):
    file, out = tmp_path / "varied.yaml", tmp_path / "out"
    text = (
        "experiment: cylinder-ideal-step\non: sim\nset: {loop.rate: 200, reference.repeats: 1}\n"
        "vary: {controller: [cascade, pid]}\nmetric: overshoot\nvariations:\n"
        "  friction x 1.2: {plant.friction_scale: 1.2}\n"
        "  no supply: {plant.regulator.supply_pressure: 0 kPa}\n"
    )
    file.write_text(text)
    code, shown, told = run(capsys, file, "--out", out, "--configs", CONFIGS, "--workers", 1)
    assert code == 0 and "6 of 6 points" in told
    rows = list(csv.DictReader((out / "sweep.csv").read_text().splitlines()))
    reason = next(row["reason"] for row in rows if row["variation"] == "no supply")
    assert reason and "supply" in reason
    table, faults = shown.split("\n\n")
    title, header, *lines = table.splitlines()
    assert title == "# overshoot" and header.split() == ["variation", "cascade", "pid"]
    names = ["nominal", "friction x 1.2", "no supply", "worst"]
    assert all(line.startswith(name) for line, name in zip(lines, names, strict=True))
    assert lines[3].count(" stopped, ") == 2
    assert reason in faults
    tables = json.loads((out / "variations.json").read_text())
    of_cascade = tables[[table["metric"] for table in tables].index("overshoot")]["rows"]
    for row in rows:
        if row["controller"] == "cascade" and row["overshoot"]:
            assert of_cascade[row["variation"]][0]["value"] == float(row["overshoot"])
    assert (out / "sweep.png").stat().st_size > 10_000
    file.write_text(text + "  payload: {plant.carriage.mass: 100 g}\n")
    assert run(capsys, file, "--out", out, "--configs", CONFIGS, "--workers", 1)[0] == 0
    assert (out / "points.jsonl").read_text().count("\n") == 8  # the others are finished


def test_a_sweep_file_says_what_options_say(tmp_path, capsys):
    file = tmp_path / "friction.yaml"
    file.write_text(
        "experiment: cylinder-ideal-step\non: sim\n"
        "set: {reference.size: 3 mm, reference.repeats: 1}\n"
        "perturbation: {friction: 0.3}\nvary: {controller: [cascade, pid]}\nrepeat: 2\n"
        "metric: overshoot\nbudget: 3 points\nkeep: 0\n"
    )
    code, shown, told = run(capsys, file, "--out", tmp_path / "out", "--configs", CONFIGS)
    assert code == 0 and "best in overshoot" in shown and "3 of 4 points" in told
    code, shown, _ = run(
        capsys, file, "--out", tmp_path / "out", "--configs", CONFIGS, "--budget", "1 h", "--json"
    )
    rows = json.loads(shown)
    assert [row["controller"] for row in rows] == ["cascade", "cascade", "pid", "pid"]
    assert rows[0]["overshoot"] != rows[1]["overshoot"]
    assert not any((tmp_path / "out" / "runs").iterdir())


def test_it_is_best_and_ends_in_what_a_run_reports_of_itself(tmp_path, capsys):
    code, shown, told = run(
        capsys, "cylinder-ideal-step", *SHORT, "--set", "reference.repeats=1", "--seeds", "0:3",
        "--workers", 1, "--metric", "air_used", "--stop-when", "setpoint_range < 10 MPa",
        "--out", tmp_path,
    )  # fmt: skip
    assert code == 0, told
    assert "best in air_used" in shown and "1 of 3 points" in told


def test_a_point_that_cannot_be_is_a_row(tmp_path):
    found = sweep(
        "arm-elbow-turnback", {"reference.speed": ["0.1 m/s", "30 m/s"]}, on="sim",
        out=tmp_path, configs=CONFIGS, workers=1, quiet=True, set={"metrics": "{}"},
        budget="2 points",
    )  # fmt: skip
    fast = found.table[1]
    assert fast["status"] == "refused" and fast["reason"]
    assert fast["reference.speed"] == 30.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("nothing is varied",)),
        (("--vary", "plant.frictoin_scale=1,2"), ("frictoin_scale", "did you mean friction_scale")),
        (("--vary", "planet.friction_scale=1,2"), ("planet",)),
        (("--vary", "plant.friction_scale=1,2 mm"), ("friction_scale", "2 mm")),
        (("--vary", "plant.friction_scale=1 mm,2 mm"), ("--vary plant.friction_scale=1 mm: ",)),
        (("--vary", "plant.friction_scale=1,five"), ("--vary plant.friction_scale=five: ",)),
        (("--vary", "planet.friction_scale=1,2"), ("--vary planet.friction_scale=1: there is no",)),
        (("--vary", "controller=nope"), ("--vary controller=nope: ", "are: cascade, pid, pid-f")),
        (("--vary", "plant.friction_scale=1..2:100000", "--seeds", "0:10000"),
         ("1,000,000,000 points",)),
        (("--vary", "plant.friction_scale=1..2"), ("no such range",)),
        ((*AXES, "--on", "hardware"), ("--serial",)),
        ((*AXES, "--on", "vcan"), ("--serial",)),
        ((*AXES, "--workers", "0x"), ("workers",)),
        ((*AXES, "--workers", "9999"), ("9999", "1<=x<=1024")),
        ((*AXES, "--draw-seed", "-1"), ("draw_seed is -1",)),
        ((*AXES, "--dask", "tcp://192.0.2.1:8786"), ("TLS",)),
        ((*AXES, "--dask", "nowhere.json"), ("neither an address",)),
        ((*AXES, "--budget", "5 mm"), ("budget", "mm")),
        ((*AXES, "--keep", "some"), ("keep",)),
        ((*AXES, "--stop-when", "x"), ("stop when",)),
        ((*AXES, "--stop-when", "rise < 1 s"), ("no metric 'rise'", "did you mean rise_time")),
        ((*AXES, "--metric", "overshot"), ("did you mean overshoot",)),
        ((*AXES, "--metric", "airused"), ("no metric 'airused'", "did you mean air_used")),
    ],
)  # fmt: skip
def test_what_cannot_be_swept_is_refused_before_anything_runs(tmp_path, capsys, arguments, words):
    code, _, told = run(
        capsys, "cylinder-ideal-step", "--configs", CONFIGS, "--out", tmp_path, *arguments
    )
    assert code == 2
    for word in words:
        assert word in told
    assert "--set" not in told
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("controller", ["cascade", "pid", "super-twisting"])
def test_a_pressure_that_leaves_a_law_no_room_is_a_refused_point(controller, tmp_path, capsys):
    pressure = f"{random.Random(controller).uniform(0.1, 10.0):.3f} kPa"
    out = ("--set", f"controller={controller}", "--out", tmp_path)
    wrong = f"cylinder.base_pressure={pressure},150 kPa"
    code, _, told = run(
        capsys, "cylinder-ideal-step", *SHORT, *out, "--vary", wrong, "--workers", 1, "--json"
    )
    assert code == 0
    rows = (tmp_path / "sweep.csv").read_text().splitlines()
    assert ",refused," in rows[1] and "leaves no differential" in rows[1]
    assert ",refused," not in rows[2] and "lost" not in told
    single = [
        "run",
        "cylinder-ideal-step",
        "--on",
        "sim",
        "--set",
        f"cylinder.base_pressure={pressure}",
    ]
    assert invoke([*single, "--set", f"controller={controller}", "--out", str(tmp_path)]) == 2
    assert "leaves no differential" in capsys.readouterr().err


def test_a_refusal_names_what_the_file_says(tmp_path, capsys):
    file = tmp_path / "sweep.yaml"
    for entry, said in (
        ("vary: {plant.friction_scale: [1 mm]}", "plant.friction_scale: 1 mm: "),
        ("vary: {plant.friction_scale: 1..2}", "vary: plant.friction_scale: 1..2: no such range"),
        ("set: {loop.raet: 1}\nseeds: 0:2", "loop.raet: 1: unknown key 'raet'"),
    ):
        file.write_text(f"experiment: cylinder-ideal-step\non: sim\n{entry}\n")
        code, _, told = run(capsys, file, "--configs", CONFIGS, "--out", tmp_path / "deep" / "er")
        assert code == 2 and said in told and "--" not in told
        assert not (tmp_path / "deep").exists()


def test_a_refusal_leaves_what_others_keep_and_what_is_finished(tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine")
    wrong = ("--vary", "plant.friction_scale=1 mm,2 mm", "--out", tmp_path)
    assert run(capsys, "cylinder-ideal-step", *SHORT, *wrong)[0] == 2
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
    right = ("--vary", "plant.friction_scale=1", "--out", tmp_path, "--workers", 1)
    assert run(capsys, "cylinder-ideal-step", *SHORT, *right)[0] == 0
    kept = (tmp_path / "points.jsonl").read_bytes()
    assert run(capsys, "cylinder-ideal-step", *SHORT, *wrong)[0] == 2
    assert (tmp_path / "points.jsonl").read_bytes() == kept and len(kept.splitlines()) == 1


def test_a_scheduler_that_is_not_there(tmp_path, capsys):
    code, _, told = run(
        capsys,
        "cylinder-ideal-step",
        *SHORT,
        *AXES,
        "--out",
        tmp_path,
        "--dask",
        "tcp://127.0.0.1:9",
    )
    assert code == 3 and "no Dask scheduler answers" in told
    assert not list(tmp_path.iterdir())


def test_without_pyarrow_there_is_a_csv_and_a_sentence_once(tmp_path, monkeypatch, capsys):
    import sweep_stub

    monkeypatch.syspath_prepend(Path(__file__).parent)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    sweep_stub.sweep(tmp_path, 1, 4, quiet=False)
    assert (tmp_path / "sweep.csv").exists() and not (tmp_path / "sweep.parquet").exists()
    assert capsys.readouterr().err.count("it takes pyarrow, pip install") == 1
    sweep_stub.sweep(tmp_path, 1, 4, quiet=False)
    assert "pyarrow" not in capsys.readouterr().err


def test_help_needs_nothing_heavy():
    code = (
        "import sys; from rig.cli import invoke; invoke(['sweep', '--help']); "
        "print([m for m in ('numpy', 'rig.sweeping', 'pydantic') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.endswith("[]\n")


FAULTS = "simulation.faults=[],[{at: 2.5 s, device: plant, fault: wire_cut, value: 1}]"


def test_points_that_fault_are_rows_and_their_runs_are_kept(tmp_path, capsys):
    firm = ("--set", "plant.friction_scale=1.2")
    arguments = (
        "cylinder-ideal-step",
        *SHORT,
        *firm,
        "--vary",
        FAULTS,
        "--seeds",
        "0:2",
        "--keep",
        "0",
    )
    code, _, told = run(capsys, *arguments, "--out", tmp_path / "all", "--workers", 2)
    rows = list(csv.DictReader((tmp_path / "all" / "sweep.csv").read_text().splitlines()))
    assert code == 0 and "2 ok, 2 faulted" in told
    assert [row["status"] for row in rows] == ["ok", "ok", "faulted", "faulted"]
    assert all("wire" in row["reason"] and not row["rise_time"] for row in rows[2:])
    kept = {folder.name for folder in (tmp_path / "all" / "runs").iterdir()}
    assert kept == {row["point"] for row in rows[2:]}
    code, _, told = run(
        capsys, *arguments, "--out", tmp_path / "queue", "--serial", "--cool-down", "10 ms"
    )
    queued = list(csv.DictReader((tmp_path / "queue" / "sweep.csv").read_text().splitlines()))
    assert code == 3 and "wire" in told
    assert queued == rows[:2]


def test_hardware_is_asked_for_before_a_queue_moves_it(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    code, _, told = run(
        capsys, "arm-elbow-turnback", "--configs", CONFIGS, "--out", tmp_path / "out", "--serial",
        "--on", "hardware", "--seeds", "0:2",
    )  # fmt: skip
    assert code in (2, 3) and told
    assert not (tmp_path / "out" / "points.jsonl").exists()
