"""`rig list runs --where`: the runs of which something is true, judged against their metrics."""

import json
import random

import pytest

from rig.cli import invoke


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return a folder of made runs, and their metrics by name: drawn, in SI."""
    out, chance = tmp_path_factory.mktemp("runs"), random.Random(6)
    made = {}
    for k in range(30):
        name = f"2026-11-22T00{k:02d}00Z-joint-circle-sim"
        (out / name).mkdir()
        rms = chance.uniform(0.05e-3, 0.4e-3)
        manifest = {
            "status": chance.choice(["ok", "failed", "faulted"]), "experiment": "joint-circle",
            "backend": "sim", "rig": chance.choice(["joint", "joint-fine"]),
            "law": chance.choice(["pid", "cascade"]),
        }  # fmt: skip
        metrics = [{"name": "marker_rms", "value": rms, "unit": "m"},
                   {"name": "rise_time", "value": None if k % 2 else 0.2, "unit": "s"}]  # fmt: skip
        (out / name / "manifest.json").write_text(json.dumps(manifest))
        (out / name / "metrics.json").write_text(json.dumps({"metrics": metrics}))
        made[name] = {**manifest, "marker_rms": rms, "rise_time": metrics[1]["value"]}
    return out, made


def found(out, where, capsys):
    assert invoke(["list", "runs", "--out", str(out), "--json", "--where", where]) == 0
    return {entry["name"] for entry in json.loads(capsys.readouterr().out)}


@pytest.mark.parametrize(
    ("where", "is_true"),
    [
        ("marker_rms < 0.2 mm", lambda run: run["marker_rms"] < 0.2e-3),
        ("marker_rms>=150um", lambda run: run["marker_rms"] >= 150e-6),
        ("status = ok", lambda run: run["status"] == "ok"),
        ("law != pid", lambda run: run["law"] != "pid"),
        ("rise_time <= 0.3 s", lambda run: run["rise_time"] is not None),
        (
            "marker_rms < 0.3 mm and rig = joint and law == 'cascade'",
            lambda run: (
                run["marker_rms"] < 0.3e-3 and (run["rig"], run["law"]) == ("joint", "cascade")
            ),
        ),
        ("no_such_metric < 1", lambda run: False),
    ],
)
def test_the_runs_of_which_it_is_true(where, is_true, runs, capsys):
    out, made = runs
    assert found(out, where, capsys) == {name for name, run in made.items() if is_true(run)}


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("marker_rms < 0.2 kPa", "marker_rms"), ("marker_rms < wide", "marker_rms"),
        ("marker_rms", "no comparison"), ("", "no comparison"), ("status < ok", "a word"),
        ("marker_rms < 1 mm or rig = joint", "marker_rms"),
        ("__import__('os').system('x')", "no comparison"),
    ],
)  # fmt: skip
def test_what_is_no_question_is_a_sentence(where, words, runs, capsys):
    assert invoke(["list", "runs", "--out", str(runs[0]), "--where", where]) == 2
    assert words in capsys.readouterr().err


def test_only_runs_are_asked_for(runs, capsys):
    assert invoke(["list", "rigs", "--where", "status = ok"]) == 2
    assert "--where is for runs" in capsys.readouterr().err
