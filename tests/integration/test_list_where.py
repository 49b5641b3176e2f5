"""`rig list runs --where`: the runs of which something is true, judged against their metrics."""

import json
import random
import re
import shutil

import pytest

import rig
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
    names = [entry["name"] for entry in json.loads(capsys.readouterr().out)]
    assert [run.path.name for run in rig.runs(out, where=where)] == names  # the same from Python
    return set(names)


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
        ("rise_time > 5 s", lambda run: False),
        ("status = crashed", lambda run: False),
    ],
)
def test_the_runs_of_which_it_is_true(where, is_true, runs, capsys):
    out, made = runs
    assert found(out, where, capsys) == {name for name, run in made.items() if is_true(run)}


@pytest.mark.parametrize("where", ["rise_time < 1 s", "rig = joint and rise_time < 1 s"])
def test_a_run_is_listed_with_the_metric_that_was_asked_for(where, runs, capsys):
    assert invoke(["list", "runs", "--out", str(runs[0]), "--where", where]) == 0
    shown = capsys.readouterr().out
    assert "rise_time 0.2 s" in shown
    assert "marker_rms" not in shown


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("marker_rms < 0.2 kPa", "marker_rms"), ("marker_rms < wide", "marker_rms"),
        ("marker_rms", "no comparison"), ("", "no comparison"), ("status < ok", "a word"),
        ("marker_rms < 1 mm or rig = joint", "marker_rms"),
        ("__import__('os').system('x')", "no comparison"),
        ("marker_rsm < 1 mm", "did you mean marker_rms?"), ("x < 1", "there are: backend, exp"),
        ("status = okay", "did you mean ok?"), ("status = x", "there are: aborted, crashed"),
        ("status != fine", "'fine'"),
    ],
)  # fmt: skip
def test_what_is_no_question_is_a_sentence(where, words, runs, capsys):
    assert invoke(["list", "runs", "--out", str(runs[0]), "--where", where]) == 2
    assert words in capsys.readouterr().err
    with pytest.raises(rig.ConfigurationError, match=re.escape(words)):
        rig.runs(runs[0], where=where)


def test_a_metric_that_no_run_has_a_value_of_is_known_all_the_same(runs, tmp_path, capsys):
    out, made = runs
    name = next(name for name, run in made.items() if run["rise_time"] is None)
    shutil.copytree(out / name, tmp_path / name)
    assert found(tmp_path, "rise_time < 1 s", capsys) == set()


def test_a_run_that_cannot_be_read_is_found_by_that(runs, tmp_path, capsys):
    name = shutil.copytree(next(runs[0].iterdir()), tmp_path / "torn").name
    (tmp_path / name / "manifest.json").write_text("{")
    assert invoke(["list", "runs", "--out", str(tmp_path), "--where", "status = unreadable"]) == 0
    assert "torn" in capsys.readouterr().out


def test_where_there_are_no_runs_no_metric_is_wrong(tmp_path, capsys):
    assert found(tmp_path, "marker_rms < 0.2 mm", capsys) == set()
    assert rig.runs(tmp_path, where="marker_rms < 0.2 mm") == []


def test_only_runs_are_asked_for(runs, capsys):
    assert invoke(["list", "rigs", "--where", "status = ok"]) == 2
    assert "--where is for runs" in capsys.readouterr().err


def test_a_run_that_cannot_be_read_is_said_and_none_is_told_from_none_such(runs, tmp_path, capsys):
    for path in list(runs[0].iterdir())[:3]:
        shutil.copytree(path, tmp_path / path.name)
    spoilt = min(path.name for path in tmp_path.iterdir())
    (tmp_path / spoilt / "manifest.json").write_text("{")
    assert invoke(["list", "runs", "--out", str(tmp_path), "--where", "rig = crane"]) == 0
    told = capsys.readouterr().err
    assert f"{spoilt} cannot be read" in told
    assert f"of the 3 runs in {tmp_path} none has rig = crane" in told


def test_cases_of_a_campaign_are_listed_by_their_path(runs, tmp_path, capsys):
    out, made = runs
    case = tmp_path / "campaigns" / "seed-3" / "joint-7-leak"
    shutil.copytree(out, case)
    (tmp_path / "campaigns" / "seed-3" / "itself").symlink_to(tmp_path / "campaigns")
    assert invoke(["list", "runs", "--out", str(tmp_path / "campaigns"), "--json"]) == 0
    listed = [run["name"] for run in json.loads(capsys.readouterr().out)]
    assert sorted(listed) == sorted(f"seed-3/joint-7-leak/{name}" for name in made)
    # A folder with runs of its own lists these alone.
    assert found(out, "rig != joint-wide", capsys) == set(made)
