"""Words that somebody new meets: what stopped a run, what was read as what, what comes next."""

import json
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import yaml

from rig.cli import invoke
from rig.config import find_configs
from rig.experiment.peaks import peaks_of
from rig.experiment.plan import load_plan
from rig.explaining.ended_run import explain_run
from rig.explaining.faults import topic_of
from rig.scaffolding.packages import package_files

SHIPPED = find_configs()[0].resolve()


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_with(fault, *more):
    words = ["run", "cylinder-step", "--no-report", "--set", f"simulation.faults=[{fault}]", *more]
    code = invoke(words)
    runs = sorted(find_runs().iterdir())
    return code, runs[-1] if runs else None


def find_runs():
    folder = Path("runs")
    folder.mkdir(exist_ok=True)
    return folder


def kinds(run):
    return [text for label, text in explain_run(run) if label == "kind"]


def test_a_device_of_another_kind_is_not_identified(here):
    code, run = run_with("{at: 0 s, device: encoder-agonist, fault: wrong_device_type}")
    assert code == 3
    assert kinds(run) == ["not_identified"]


def ended(folder, message, diagnosis=None, ago=0.0, status="faulted"):
    """Write a run's folder as one that ended so, so many seconds ago."""
    then = (datetime.now(UTC) - timedelta(seconds=ago)).isoformat()
    folder.mkdir()
    manifest = {
        "status": status, "exit_code": 4, "message": message, "started": then, "ended": then,
        "experiment": "e", "rig": "r",
    }  # fmt: skip
    (folder / "manifest.json").write_text(json.dumps(manifest))
    events = [] if diagnosis is None else [{"t": 1.0, "kind": "diagnosis", "message": diagnosis}]
    (folder / "events.jsonl").write_text("".join(json.dumps(event) + "\n" for event in events))
    return folder


SLOW = "the last second fits best: regulator of antagonist: the profile says 40 rad/s, I see 26"


def test_what_was_seen_to_oscillate_comes_before_what_would_fit_as_well(here):
    message = "the pair oscillates at 6.8 Hz, 11 mm peak to peak, about its reference"
    assert kinds(ended(here / "a", message, SLOW)) == ["oscillation", "regulator_slow"]
    other = "following error of the pair is 5 mm"
    assert kinds(ended(here / "b", other, SLOW))[0] == "regulator_slow", "else it knows best"


def test_a_bound_that_was_just_missed_is_told_with_digits_that_show_it(here):
    folder = ended(here / "a", None, status="failed")
    row = {"name": "off", "value": 1.00003e-3, "unit": "m", "bound": 1e-3, "bound_kind": "max"}
    metrics = {"metrics": [{**row, "pass": False, "segments": "*"}]}
    (folder / "metrics.json").write_text(json.dumps(metrics))
    text = next(remark.text for remark in explain_run(folder) if remark.label == "missed")
    assert text.startswith("off is 1.00003 mm, max 1 mm; ")


@pytest.mark.parametrize(
    ("ago", "said"),
    [(5.0, ""), (61.0, ", 1 min ago"), (7200.0, ", 2 h ago"), (3.1 * 86_400, ", 3 d ago")],
)
def test_an_older_run_is_said_to_be_one(here, ago, said):
    first = explain_run(ended(here / "a", "it broke", ago=ago))[0]
    assert first.text == f"a: faulted, exit code 4{said}"


def test_the_page_of_a_run_that_stopped_says_why_and_what_to_do(here):
    fault = "{at: 1.2 s, device: regulators, fault: wire_break}"
    words = ["--set", f"simulation.faults=[{fault}]", "--set", "figures=[timing]"]
    assert invoke(["run", "cylinder-step", *words]) == 4
    (run,) = find_runs().iterdir()
    page = (run / "report.html").read_text()
    topic = next(text for label, text in explain_run(run) if label == "kind")
    assert "Why it stopped" in page and topic in page
    for label in ("means", "causes", "check", "mend"):
        assert f"<dt>{label}</dt>" in page
    assert f"rig explain {run.name}" in page


def test_a_tube_that_is_off_is_among_the_candidates_of_a_pair_against_its_pull():
    topic = topic_of(
        "encoder-agonist and encoder-antagonist are swapped, or the tubes of agonist and "
        "antagonist, or one of these tubes is off: the rods move against their pull"
    )
    assert topic.name == "swapped"
    assert "tube that has slipped off" in topic.causes


def test_faults_are_listed_as_a_profile_writes_them(here, capsys):
    assert invoke(["faults", "list", "cylinder", "--json"]) == 0
    rows = {row["fault"]: row for row in json.loads(capsys.readouterr().out)}
    written = {name: row["in simulation.faults"] for name, row in rows.items()}
    assert written["wire_cut"].startswith("{device: plant, fault: wire_cut")
    assert written["encoder_scale"].startswith("{device: encoder-agonist, fault: scale")
    assert sum(map(bool, written.values())) > 20


def test_every_fault_that_is_listed_so_is_one_that_a_profile_may_have(here, capsys):
    """What the list writes is taken: with a number in the place of what is left open."""
    assert invoke(["faults", "list", "cylinder", "--json"]) == 0
    written = [row["in simulation.faults"] for row in json.loads(capsys.readouterr().out)]
    faults = []
    for text in filter(None, written):
        entry = yaml.safe_load(text.replace("…", "0.5"))
        faults.append(f"{{at: 90 s, {json.dumps(entry)[1:-1]}}}".replace('"', ""))
    quick = ("reference.repeats=1", "reference.dwell=0.5 s", "reference.rise=0.1 s")
    options = [f"simulation.faults=[{', '.join(faults)}]", *quick]
    words = [word for option in options for word in ("--set", option)]
    assert invoke(["run", "cylinder-step", "--no-report", *words]) in (0, 1), faults


@pytest.mark.parametrize("device", ["plant agonist", "nobody"])
def test_a_fault_of_a_device_that_is_none_says_where_the_names_are(here, capsys, device):
    assert run_with(f"{{at: 0 s, device: {device}, fault: wire_cut}}") == (2, None)
    assert "`rig faults list RIG`" in capsys.readouterr().err


def test_a_fault_that_a_device_has_not_says_where_the_names_are(here, capsys):
    code, _ = run_with("{at: 0 s, device: encoder-agonist, fault: encoder_scale}")
    said = capsys.readouterr().err
    assert code == 2 and "known are" in said and "`rig faults list RIG`" in said


def test_a_profile_of_ones_own_can_be_broken(here, capsys):
    (here / "own.yaml").write_text("extends: cylinder\ndescription: Ours\n")
    words = ["faults", "run", "own.yaml", "--only", "encoder_alarm", "--seed", "3", "--json"]
    assert invoke(words) == 0
    (case,) = json.loads(capsys.readouterr().out)
    assert case["case"]["rig"] == "own.yaml"
    assert invoke([*words, "--experiment", "cylinder-step"]) == 0


def test_a_tab_is_told_in_one_sentence(here, capsys):
    (here / "bad.yaml").write_text("name: bad\n\trig: cylinder\n")
    assert invoke(["check", "bad.yaml"]) == 2
    assert "a tab has no place in this file; use spaces" in capsys.readouterr().err


def test_a_number_without_a_unit_is_told_with_what_came_of_it(here, capsys):
    assert invoke(["check", "cylinder-sine", "--set", "reference.amplitude=10"]) == 2
    assert "reference.amplitude: 10 has no unit and is read as 10 m" in capsys.readouterr().err
    assert invoke(["check", "cylinder-sine", "--set", "reference.amplitude=10 m"]) == 2
    assert "no unit" not in capsys.readouterr().err
    assert invoke(["check", "cylinder-sine", "--set", "reference.amplitude=0.008"]) == 0


@pytest.mark.parametrize(("tone", "amplitude"), [(0.2, 8.0), (1.0, 3.0)])
def test_peaks_of_a_sine_are_those_of_its_formula(tone, amplitude):
    tones = f"reference.tones=[{{frequency: {tone} Hz, periods: 2}}]"
    plan = load_plan("cylinder-sine", [tones, f"reference.amplitude={amplitude} mm", "metrics={}"])
    speed, acceleration = peaks_of(plan)
    w = 2.0 * 3.141592653589793 * tone
    assert speed.value == pytest.approx(1e-3 * amplitude * w, rel=1e-3)
    assert acceleration.value == pytest.approx(1e-3 * amplitude * w * w, rel=1e-3)
    assert speed.limit == plan.profile.mechanism_settings.limits.speed
    assert speed.at % (0.5 / tone) == pytest.approx(0.25 / tone, abs=0.02)


def test_check_prints_peaks_beside_limits(here, capsys):
    assert invoke(["check", "cylinder-sine"]) == 0
    assert re.search(
        r"peak speed +27\.4\d mm/s at 40\.5 s; limit 500 mm/s", capsys.readouterr().out
    )


def test_a_comparison_counts_and_marks_what_only_friction_holds(here, capsys):
    line = ["compare", "cylinder-step", "--on", "sim", "--controllers", "cascade,pid"]
    assert invoke([*line, "--set", "reference.repeats=1"]) in (0, 1)
    told = capsys.readouterr()
    (row,) = [text for text in told.out.splitlines() if text.startswith("linear loop")]
    assert row.split("  ")[-1].strip() == "by friction only" and "stable" in row
    if "at a time" in told.err:  # with one processor there is a progress line instead
        assert "1 of 2 done: " in told.err and "2 of 2 done: " in told.err


def test_where_no_calibration_could_be_kept_nothing_moves(here, capsys):
    rigs = here / "configs" / "rigs"
    rigs.mkdir(parents=True)
    (rigs / "cylinder.yaml").write_text((SHIPPED / "rigs" / "cylinder.yaml").read_text())
    (here / "configs" / "calibration").write_text("a file in the way")
    words = ["--yes", "--on", "sim", "--configs", "configs"]
    assert invoke(["calibrate", "cylinder", "response", *words]) == 2
    assert "cannot be kept in" in capsys.readouterr().err
    assert not (here / "runs").exists()


def test_a_new_sensor_is_drawn_by_its_first_experiment():
    made = package_files("driver", "oil-gauge")
    (text,) = [text for path, text in made.items() if "experiments" in path.parts]
    assert yaml.safe_load(text)["figures"][-1] == "device.oil_gauge_value"
    (device,) = [text for path, text in made.items() if path.name == "device.py"]
    assert "_value" in device
