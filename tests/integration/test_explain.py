"""`rig explain`: every word has its meaning, every fault its cause, check and mend."""

import json
import random
import re
import shlex
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import yaml
from explained import said

import rig
from rig.assembly import REGISTRY
from rig.cli.command_table import COMMANDS
from rig.cli.commands import invoke
from rig.explaining.ended_run import age_since, explain_run
from rig.explaining.glossary import glossary, without_keys
from rig.faults.catalogue import KINDS

ROOT = Path(rig.__file__).parents[1]
CONFIGS = ["--configs", str(ROOT / "configs")]


def test_every_key_measure_and_law_has_a_meaning():
    words = glossary()
    assert [word for word in words if len(word.text) < 2] == []
    names = {word.name for word in words if word.kind == "measure"}
    assert names == set(REGISTRY.measures(None, object))


def test_every_metric_of_every_experiment_is_explained():
    words = {word.name for word in without_keys() if word.kind.endswith("measure")}
    asked = {}
    for path in sorted((ROOT / "configs" / "experiments").glob("*.yaml")):
        metrics = yaml.safe_load(path.read_text()).get("metrics", {})
        asked |= {(spec or {}).get("measure", name): path.name for name, spec in metrics.items()}
    assert len(asked) > 80
    assert {name: of for name, of in asked.items() if name not in words} == {}


def test_no_measure_or_law_hides_a_key_of_the_same_name():
    others = {word.name for word in without_keys()}
    assert {word.name for word in glossary() if word.kind.endswith("key")} & others == set()


def test_drawn_words_of_files_are_known(capsys):
    words = random.Random(8).sample([w for w in glossary() if "." in w.name], 6)
    for word in words:
        code, out, _ = said(capsys, word.name)
        assert code == 0
        assert word.name in out
        assert " ".join(word.text.split()[:2]) in " ".join(out.split())


@pytest.mark.parametrize(
    ("name", "called", "keys"),
    [
        ("sine", "motion of cylinder", ("reference.kind", "amplitude", "tones")),
        ("cia402", "driver", ("devices.NAME.driver", "joints", "enable_time")),
        ("antagonistic-pair", "plant of cylinder", ("plant.model", "friction_scale")),
        ("canopen", "protocol", ("buses.NAME.protocol", "heartbeat")),
        ("arm", "mechanism", ("`mechanism`", "geometry")),
    ],
)
def test_a_part_is_known_with_what_names_it_and_what_it_takes(capsys, name, called, keys):
    code, out, _ = said(capsys, name)
    assert code == 0
    assert f"{name} ({called}): " in out
    for key in keys:
        assert key in out


def test_a_part_hides_no_key_of_its_name(capsys):
    out = said(capsys, "step")[1]
    assert "step (motion of cylinder)" in out and "reference.step (experiment key" in out


@pytest.mark.parametrize("command", ["run", "calibrate"])
def test_commands_are_known(capsys, command):
    code, out, _ = said(capsys, command)
    assert (code, COMMANDS[command][1] in out) == (0, True)


def test_a_typing_error_gets_the_nearest_names(capsys):
    code, _, err = said(capsys, "trackin_rms")
    assert code == 2
    assert "tracking_rms" in err


def test_a_law_of_a_profile_that_nobody_named_gets_the_command_that_names_it(capsys, tmp_path):
    (tmp_path / "rigs").mkdir()
    (tmp_path / "rigs" / "our-rig.yaml").write_text("controllers: {our-law: {}}\n")
    code, _, err = said(capsys, "our-law", "--configs", str(tmp_path))
    assert code == 2
    assert "rig explain our-law --rig our-rig" in err


@pytest.mark.parametrize(
    ("on", "asks", "more"),
    [
        ("hardware", "`rig check cylinder --on hardware`", ""),
        ("can0", "`rig check cylinder --on can0`", ""),
        ("can0=slcan:/dev/ttyACM0", "`rig check cylinder --on can0=slcan:/dev/ttyACM0`", ""),
        ("vcan0", "`rig check cylinder --on vcan0`", ""),
        ("virtual", "`rig check cylinder --on hardware`", "this run was on virtual, where no bus"),
    ],
)
def test_what_to_check_is_on_the_bus_that_the_run_had(tmp_path, on, asks, more):
    folder = tmp_path / "run"
    folder.mkdir()
    manifest = {
        "format": 1, "status": "faulted", "exit_code": 4, "rig": "cylinder", "backend": "hardware",
        "experiment": "cylinder-sine", "command": ["rig", "run", "cylinder-sine", "--on", on],
        "message": "encoder (node 0x20): does not answer SYNC", "started": "2026-11-21T03:45:12Z",
        "ended": "2026-11-21T03:46:12Z",
    }  # fmt: skip
    (folder / "manifest.json").write_text(json.dumps(manifest))
    told = dict(explain_run(folder))
    assert asks in told["check"]
    assert (more in told["check"]) if more else told["check"].endswith("the one named.")


@pytest.mark.parametrize(
    ("fault", "named"),
    [("wire_break", "monitor"), ("silent", "silent"), ("emergency_stop", "emergency_stop")],
)
def test_a_run_that_stopped_is_explained(tmp_path, capsys, fault, named):
    runs = tmp_path / "runs"
    injected = f"simulation.faults=[{{at: 1.2 s, device: regulators, fault: {fault}}}]"
    code = invoke(["run", "cylinder-sine", "--no-report", "--out", str(runs), "--set", injected])
    assert code == 4
    err = capsys.readouterr().err
    [run] = runs.iterdir()
    assert f"rig explain {run}" in err
    code, out, _ = said(capsys, str(run), "--json")
    told = json.loads(out)
    assert code == 0
    assert named in [entry["text"] for entry in told if entry["label"] == "kind"], told
    assert {"means", "causes", "check", "mend"} <= {entry["label"] for entry in told}
    assert not any(" RIG" in entry["text"] for entry in told)
    events = [json.loads(line) for line in (run / "events.jsonl").read_text().splitlines()]
    [event] = [event for event in events if event["kind"] == "injected"]
    [fault_event] = [event for event in events if event["kind"] == "fault"]
    channel = {"channel": "agonist"} if fault == "wire_break" else {}
    told = {"fault": fault, "where": "regulators", "magnitude": None, **channel}
    assert event["data"] == told
    assert fault_event["t"] - 0.1 < event["t"] < fault_event["t"], "cause before effect"


def test_frames_that_a_bus_loses_are_no_silence_of_one_device(tmp_path, capsys):
    kinds = {}
    for fault in (
        "device: can0, fault: frame_loss, value: 0.4",
        "device: regulators, fault: silent",
    ):
        injected = f"simulation.faults=[{{at: 1.2 s, {fault}}}]"
        args = ["run", "cylinder-sine", "--no-report", "--out", str(tmp_path), "--set", injected]
        assert invoke(args) == 4
        capsys.readouterr()
        _, out, _ = said(capsys, "--runs", str(tmp_path), "--json")
        kinds[fault] = [entry["text"] for entry in json.loads(out) if entry["label"] == "kind"]
    assert [*kinds.values()] == [["frames_lost"], ["not_safe", "silent"]]


@pytest.mark.parametrize(
    ("fault", "words", "expected"),
    [
        ("agonist.leak, value: 4e-8", "leaks behind its tube", ["pulls_disagree"]),
        ("supply_lost, value: 100e3", "no chamber gets beyond 9", ["supply", "leak"]),
    ],
)
def test_each_suspect_of_a_diagnosis_has_its_kind(tmp_path, capsys, fault, words, expected):
    """The message of either speaks of regulators and monitors first."""
    runs = tmp_path / "runs"
    broken = f"simulation.faults=[{{at: 6 s, device: plant, fault: {fault}}}]"
    args = ["run", "cylinder-sine", "--no-report", "--out", str(runs), "--set", broken]
    assert invoke(args) == 4
    [run] = runs.iterdir()
    capsys.readouterr()
    _, out, _ = said(capsys, str(run), "--json")
    told = json.loads(out)
    text = " ".join(entry["text"] for entry in told if entry["label"] in ("message", "diagnosis"))
    assert words in text
    assert [entry["text"] for entry in told if entry["label"] == "kind"] == expected


def test_a_missed_bound_is_explained(tmp_path, capsys):
    runs = tmp_path / "runs"
    bound = 'metrics.tracking_rms_01={measure: tracking_rms, max: "1 nm"}'
    args = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(runs)]
    assert invoke([*args, "--set", bound]) == 1
    capsys.readouterr()
    code, out, _ = said(capsys, "--runs", str(runs))
    assert code == 0
    assert "tracking_rms_01 is" in out
    assert re.search(r"is [\d.]+ µm, max 0.001 µm;", out), "in the unit of the run's own table"
    assert "rig explain tracking_rms`" in out.replace("\n ", "")
    assert "next: Is the rig as its profile says? `rig status cylinder`" in out


def test_what_a_command_has_set_is_looked_at_first_where_a_bound_was_missed(tmp_path, capsys):
    """Also by the `rig check` that is named: what the files say is not what ran."""
    runs = str(tmp_path / "runs")
    args = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", runs]
    rates = ("position_rate=200", "velocity_rate=250")
    fast = [word for rate in rates for word in ("--set", f"controllers.cascade.{rate}")]
    bound = ["--set", "metrics.air_used.max=1e-9"]
    assert invoke([*args, *fast, *bound]) == 1
    warned = capsys.readouterr().err
    assert "warning: the loop of cascade is not stable by the linear model (phase" in warned
    check = f"rig check cylinder-step {' '.join([*fast, *bound])}"
    assert f": {check}\n" in warned
    assert invoke(shlex.split(check)[1:]) == 0  # as it stands
    assert "no: friction holds it" in capsys.readouterr().out
    manifest = next(Path(runs).glob("*/manifest.json"))
    manifest.write_text(json.dumps({
        **json.loads(manifest.read_text()), "command": ["rig", *args, *fast, *bound]
    }))  # fmt: skip
    out = " ".join(said(capsys, "--runs", runs)[1].split())
    assert "set: otherwise than the files by this run's command: controllers.cascade." in out
    assert f"taken back by `rig {' '.join(args)}`" in out
    assert f"rig check cylinder-step --rig cylinder {' '.join([*fast, *bound])}`" in out


def test_nobody_is_warned_of_a_loop_that_the_files_say(tmp_path, capsys):
    args = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(tmp_path)]
    assert invoke([*args, "--set", "controllers.cascade.position_rate=40"]) == 0
    assert "warning" not in capsys.readouterr().err


def test_every_bound_that_one_measure_missed_is_explained(tmp_path, capsys):
    runs = tmp_path / "runs"
    args = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(runs)]
    for name in ("first", "second"):
        args += ["--set", f'metrics.{name}={{measure: tracking_rms, max: "1 nm"}}']
    assert invoke(args) == 1
    capsys.readouterr()
    _, out, _ = said(capsys, "--runs", str(runs))
    assert "first is" in out
    assert "second is" in out


def test_a_run_that_was_refused_is_what_is_explained(tmp_path, capsys):
    """It has left no folder: the run before it is not what somebody asks about."""
    runs = tmp_path / "runs"
    run = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(runs)]
    assert invoke([*run, "--set", "reference.levels=7"]) == 2
    code, out, _ = said(capsys, "--runs", str(runs))
    assert code == 0, "before any run"
    assert "exit code 2" in out and "--set reference.levels=7" in " ".join(out.split())

    assert "\n      reference.levels=7\n      ^\n" in out, "the caret stays below its word"

    assert invoke(run) == 0
    capsys.readouterr()
    _, out, _ = said(capsys, "--runs", str(runs))
    assert out.startswith("run: "), "a run that came later is the newest attempt"
    [folder] = runs.iterdir()

    assert invoke([*run, "--on", "nowhere"]) == 2, "click has refused it"
    capsys.readouterr()
    _, out, _ = said(capsys, "--runs", str(runs), "--json")
    told = {entry["label"]: entry["text"] for entry in json.loads(out)}
    assert "--on nowhere" in told["refused"] and "exit code 2" in told["refused"]
    assert "nowhere" in told["message"]
    assert told["kind"] and told["mend"]
    assert f"rig explain {folder}" in told["before"]

    _, out, _ = said(capsys, "--runs", str(tmp_path / "others"))
    assert "nowhere" not in out, "a refusal belongs to its folder of runs"
    _, out, _ = said(capsys, str(folder))
    assert out.startswith("run: "), "who names a run gets it"


def test_a_refusal_is_found_however_its_folder_was_spelled(tmp_path, capsys, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert invoke(["run", "cylinder-sine", "--set", "zz=1", "--out", "../here/runs"]) == 2
    code, out, _ = said(capsys, "latest")
    assert code == 0
    assert out.startswith("refused: ")


def test_a_run_that_ended_by_an_error_is_none_that_was_refused(tmp_path, capsys, monkeypatch):
    """Code of the user's own that raises ends the command as a wrong file does: exit code 2."""
    runs = tmp_path / "runs"
    monkeypatch.setattr("rig.cli.run.show", lambda result: {}["nothing"])
    monkeypatch.setattr("rig.assembly.contract_check.whose_bug", lambda error: "their code")
    run = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(runs)]
    assert invoke(run) == 2
    capsys.readouterr()
    _, out, _ = said(capsys, "--runs", str(runs))
    assert out.startswith("run: ")


def test_a_column_of_a_log_is_explained_by_the_newest_run_or_by_a_rig(tmp_path, capsys):
    runs = tmp_path / "runs"
    code, _, err = said(capsys, "truth.supply", "--runs", str(runs))
    assert code == 2 and "--rig PROFILE" in err
    code, out, _ = said(capsys, "reading.position_agonist", "--rig", "cylinder")
    assert code == 0
    assert out.startswith("reading.position_agonist (log column of cylinder): ")
    assert out.rstrip().endswith(", m")

    run = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(runs)]
    assert invoke(run) == 0
    [folder] = runs.iterdir()
    capsys.readouterr()
    code, out, _ = said(capsys, "truth.supply", "--runs", str(runs))
    assert code == 0
    assert f"log column of {folder.name}" in " ".join(out.split())


def test_a_spoilt_note_of_a_refusal_is_none(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    runs = tmp_path / "runs"
    assert invoke(["run", "cylinder-stepp", "--out", str(runs)]) == 2
    (tmp_path / "rig" / "refused.json").write_text('{"runs": 3')
    capsys.readouterr()
    code, _, err = said(capsys, "--runs", str(runs))
    assert code == 2 and f"there is no run in {runs} yet" in err


@pytest.mark.parametrize(
    ("ago", "said"),
    [(3, ""), (11, ", 11 s ago"), (59, ", 59 s ago"), (90, ", 2 min ago"), (7300, ", 2 h ago"),
     (200_000, ", 2 d ago")],
)  # fmt: skip
def test_how_long_ago_a_run_ended_is_said_if_another_may_be_meant(ago, said):
    assert age_since((datetime.now(UTC) - timedelta(seconds=ago)).isoformat()) == said


def test_a_run_whose_process_was_killed_is_explained(tmp_path, capsys):
    """Whoever asks first finds it so; nobody else need have looked at the folder before."""
    runs = tmp_path / "runs"
    args = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(runs)]
    assert invoke(args) == 0
    [run] = runs.iterdir()
    manifest = json.loads((run / "manifest.json").read_text())
    manifest.update(status="running", exit_code=None, ended=None)
    (run / "manifest.json").write_text(json.dumps(manifest))
    capsys.readouterr()
    code, out, _ = said(capsys, "--runs", str(runs))
    assert code == 0
    assert "crashed" in out and "kind: process_died" in out
    assert f"rig report {run.name}" in " ".join(out.split())


@pytest.mark.parametrize(
    "word", ["sensitivity", "stable", "linear loop", "sim", "virtual", "vcan", "hardware"]
)
def test_words_of_tables_and_options_are_known(capsys, word):
    code, out, _ = said(capsys, word)
    assert code == 0
    assert out.startswith(f"{word}: ")


def test_a_metric_of_one_stretch_is_explained_by_its_measure(capsys):
    code, out, _ = said(capsys, "tracking_rms_0.1hz")
    assert code == 0
    assert "tracking_rms (measure of cylinder)" in out and "'0.1hz'" in " ".join(out.split())
    assert said(capsys, "tracking_rmz_0.1hz")[0] == 2


@pytest.mark.parametrize("figure", ["tracking", "timing"])
def test_a_figure_is_explained(capsys, figure):
    code, out, _ = said(capsys, figure)
    assert code == 0
    assert f"{figure} (figure" in out


def test_each_fault_that_can_be_planted_is_a_word():
    listed = {word.name: word.text for word in without_keys() if word.kind == "fault in simulation"}
    assert set(listed) == set(KINDS)
    assert "A pressure monitor repeats its value." in listed["monitor_frozen"]
