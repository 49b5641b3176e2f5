"""The folder that a case of `rig faults run` leaves says what was wrong, and repeats it."""

import json
from pathlib import Path

import numpy as np
import pytest

from rig.cli import invoke
from rig.explaining.ended_run import explain_run
from rig.run_folder import RunFolder

SLOW = (
    "extends: cylinder-ideal\nname: cylinder-slow\n"
    "buses: {can0: {heartbeat: 50 ms, heartbeat_timeout: 150 ms}}\n"
)
SINE = (
    "name: sine\nrig: slow.yaml\ncontroller: cascade\nreference:\n  kind: sine\n"
    "  amplitude: 9 mm\n  tones:\n    - {frequency: 1 Hz, periods: 5}\n"
)
KILLED = """\
rig: slow.yaml
experiment: sine.yaml
fault: program_killed
when: {phase: run, after: 0.3 s}
"""
OFFSET = """\
rig: cylinder
experiment: cylinder-sine
fault: monitor_offset
where: plant agonist
magnitude: 40 kPa
when: {phase: run, after: 0.3 s}
"""
HARMLESS = """\
rig: cylinder
experiment: cylinder-sine
fault: readings_twice
where: encoder-agonist
lasts: 0.2 s
when: {phase: run, after: 0.3 s}
"""
RIDDEN = """\
rig: cylinder
experiment: cylinder-sine
fault: sdo_silent
where: regulators
when: {phase: run, after: 0.3 s}
"""


def write(name, text):
    Path(name).write_text(text)


def folders(at):
    return [path.parent for path in sorted(Path(at).glob("**/manifest.json"))]


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """What a hazard left and what was printed of it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("killed"))
        write("slow.yaml", SLOW)
        write("sine.yaml", SINE)
        write("case.yaml", KILLED)
        assert invoke(["faults", "run", "case.yaml", "--out", "out"]) == 1
        (folder,) = folders("out")
        yield folder.resolve()


def test_a_folder_says_that_it_ended_in_a_hazard(killed, capsys):
    manifest = RunFolder.open(killed).manifest
    (wrong,) = manifest["wrongs"]
    assert wrong.startswith("hazard: ")
    assert manifest["command"] == ["rig", "faults", "run", "case.yaml"]
    assert any(r.label == "truth" and r.text == wrong for r in explain_run(killed))
    assert invoke(["report", str(killed)]) == 0
    assert wrong.split(";")[0] in (killed / "report.html").read_text()
    capsys.readouterr()


def test_all_of_a_folder_has_one_clock(killed):
    events = RunFolder.open(killed).events()
    (injected,) = [event for event in events if event["kind"] == "injected"]
    hazards = [event for event in events if event["kind"] == "hazard"]
    truth, told = np.load(killed / "truth.npz"), json.loads((killed / "truth.json").read_text())
    assert told["t"] == "s since the run began, as in events.jsonl"
    (position,) = np.flatnonzero(truth["columns"] == "position")
    beyond = np.abs(truth["truth"][:, position]) > 0.024
    first = truth["t"][np.argmax(beyond)]
    assert min(event["t"] for event in hazards) == pytest.approx(first, abs=1.1e-3)
    assert injected["t"] < first < injected["t"] + 0.4
    (wrong,) = RunFolder.open(killed).manifest["wrongs"]
    assert f"first at {first:.3f} s" in wrong
    assert f"the fault at {injected['t']:.3f} s" in wrong


def test_each_column_of_the_truth_has_a_meaning_of_its_own(killed):
    columns = json.loads((killed / "truth.json").read_text())["columns"]
    assert len({column["description"] for column in columns}) == len(columns)


def test_a_rerun_breaks_it_again(killed, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert invoke(["rerun", str(killed), "--json"]) == 1
    again = json.loads(capsys.readouterr().out)
    assert again["hazard"]
    assert again["compared"]
    assert again["difference"] is None
    assert Path(again["folder"]).is_relative_to(tmp_path)
    assert again["again"] == "rig faults run case.yaml"
    assert invoke(["rerun", again["folder"]]) == 1
    assert "every cycle is as it was" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("scenario", "outcome", "told"),
    [
        (OFFSET, "seen", "plant agonist, 40 kPa"),
        (RIDDEN, "ridden out", "regulators"),
        (HARMLESS, "excused", "encoder-agonist, for 0.2 s"),
    ],
    ids=["seen", "ridden", "excused"],
)
def test_what_went_well_is_kept_if_asked_for(
    monkeypatch, tmp_path, capsys, scenario, outcome, told
):
    monkeypatch.chdir(tmp_path)
    write("case.yaml", scenario)
    assert invoke(["faults", "run", "case.yaml", "--json"]) == 0
    (case,) = json.loads(capsys.readouterr().out)
    assert case["outcome"] == outcome
    assert not folders("faults")
    assert invoke(["faults", "run", "case.yaml", "--keep-all"]) == 0
    (folder,) = folders("faults")
    assert "wrongs" not in RunFolder.open(folder).manifest
    (injected,) = [e for e in RunFolder.open(folder).events() if e["kind"] == "injected"]
    assert injected["message"].endswith(f": {told}")
    table = json.loads((folder.parents[1] / "campaign.json").read_text())["rows"]
    counts = [table[0][word] for word in ("seen", "ridden out", "excused")]
    assert counts == [word == outcome for word in ("seen", "ridden out", "excused")]


def test_a_failure_is_printed_with_its_folder(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    write("slow.yaml", SLOW)
    write("sine.yaml", SINE)
    write("case.yaml", KILLED)
    assert invoke(["faults", "run", "case.yaml", "--out", "out"]) == 1
    (folder,) = folders("out")
    assert f"    {folder}\n" in capsys.readouterr().err
