"""`rig faults`: a campaign that finds what is dangerous, says so, and is never wrongly content."""

import json
import re
from dataclasses import replace
from pathlib import Path
from shutil import copy

import numpy as np
import pytest
from click.testing import CliRunner

from rig.cli.faults import faults
from rig.faults.catalogue import KINDS
from rig.faults.kind import Magnitudes

CONFIGS = Path(__file__).parents[2] / "configs"


def run(*arguments):
    return CliRunner().invoke(faults, [*map(str, arguments)], standalone_mode=False)


def campaign(out, seed):
    """Return what the newest campaign of a seed came to."""
    numbered = {
        int(found[1] or 1): path
        for path in out.iterdir()
        if (found := re.fullmatch(rf"seed-{seed}(?:-(\d+))?", path.name))
    }
    return json.loads((numbered[max(numbered)] / "campaign.json").read_text())


def test_a_run_without_a_fault_is_no_failure(tmp_path):
    result = run("run", "cylinder", "--only", "nothing", "--random", 4, "--out", tmp_path)
    assert result.return_value == 0, result.output
    (row,) = campaign(tmp_path, 0)["rows"]
    assert (row["n"], row["hazards"], row["false trips"]) == (4, 0, 0)
    assert not [path for path in (tmp_path / "seed-0").iterdir() if path.is_dir()]


def test_the_folder_of_runs_is_said_as_everywhere(tmp_path):
    runs = tmp_path / "mine"
    result = run("run", "cylinder", "--only", "nothing", "--runs", runs)
    assert result.return_value == 0, result.output
    assert (runs / "faults" / "seed-0" / "campaign.json").exists()
    both = run("run", "cylinder", "--only", "nothing", "--runs", runs, "--out", tmp_path)
    assert "--out is where campaigns lie" in str(both.exception)


def test_a_campaign_is_kept_beside_an_earlier_one_of_its_seed(tmp_path):
    for fault in ("encoder_alarm", "nothing", "wire_break"):
        result = run("run", "cylinder", "--only", fault, "--out", tmp_path)
        assert result.return_value == 0, result.output
    kept = {
        path.parent.name: json.loads(path.read_text())["cases"][0]["case"]["first"]["kind"]
        for path in tmp_path.glob("*/campaign.json")
    }
    assert kept == {"seed-0": "encoder_alarm", "seed-0-2": "nothing", "seed-0-3": "wire_break"}
    assert all((tmp_path / name / "campaign.html").is_file() for name in kept)
    assert result.stderr.rstrip().endswith(str(tmp_path / "seed-0-3" / "campaign.html"))


@pytest.mark.parametrize("wrong", ["cylinder-nix", "case.yaml"])
def test_what_cannot_be_run_leaves_no_folder(tmp_path, wrong, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("case.yaml").write_text("rig: cylinder\nexperiment: cylinder-sine\nfalt: leak\n")
    assert run("run", wrong, "--out", "out").exception is not None
    assert not Path("out").exists()


@pytest.mark.parametrize("seed", [3, 9])
def test_a_fault_is_seen_named_and_written_down(tmp_path, seed):
    """The same line gives the same case, with the same reaction."""
    line = ("run", "cylinder", "--only", "encoder_alarm", "--seed", seed, "--out", tmp_path)
    results, cases = [], []
    for _ in range(2):
        results.append(run(*line))
        cases.append(campaign(tmp_path, seed)["cases"][0])
    assert [result.return_value for result in results] == [0, 0], results[0].output
    assert cases[0] == cases[1]
    assert cases[0]["case"]["first"]["where"] in cases[0]["ending"]["message"]


@pytest.fixture(scope="module")
def hazardous(tmp_path_factory):
    """A campaign of killed masters on a rig that notices late: its result and its folder."""
    folder = tmp_path_factory.mktemp("hazardous")
    result = run(
        "run", "cylinder-slow", "--only", "program_killed", "--random", 25, "--seed", 40_000,
        "--configs", make_slow_to_notice(folder), "--out", folder,
    )  # fmt: skip
    return result, folder


def test_a_hazard_is_found_judged_after_the_program_and_kept(hazardous):
    """A killed master with slow watchdogs throws the pair into its end, and nobody says so."""
    result, out = hazardous
    assert result.return_value == 1, result.output
    content = campaign(out, 40_000)
    failed = [case for case in content["cases"] if case["hazard"]]
    assert failed
    for case in failed:
        (violation, *_) = case["ending"]["violations"]
        assert violation["t"] > case["ending"]["broke_at"]
        assert re.fullmatch(
            r"rig faults run cylinder-slow --only program_killed --seed \d+ --configs .*/configs",
            case["again"],
        )
    folders = [path for path in (out / "seed-40000").iterdir() if path.is_dir()]
    assert len(folders) == len(failed)
    (run_folder,) = folders[0].iterdir()
    events = [json.loads(line) for line in (run_folder / "events.jsonl").read_text().splitlines()]
    (injected,) = [event for event in events if event["kind"] == "injected"]
    assert injected["data"]["fault"] == "program_killed"
    truth = np.load(run_folder / "truth.npz")
    assert "position" in truth["columns"]
    described = json.loads((run_folder / "truth.json").read_text())
    assert [column["name"] for column in described["columns"]] == truth["columns"].tolist()
    assert all(column["unit"] and column["description"] for column in described["columns"])
    assert truth["t"][-1] >= min(case["ending"]["broke_at"] for case in failed) + 1.4


def quiet(configs, out, *more):
    """Return the exit code and the runs of some seconds in which nothing is broken."""
    words = ("--quiet", 2e-3, "--workers", 1, "--configs", configs, "--out", out, "--json", *more)
    result = run("run", "cylinder-slow", *words)
    return result.return_value, json.loads(result.stdout)


@pytest.mark.parametrize("seed", [5, 6])
def test_quiet_hours_are_drawn_counted_and_not_tripped_in(tmp_path, slow_to_notice, seed):
    code, runs = quiet(slow_to_notice, tmp_path / "out", "--seed", seed)
    assert code == 0
    assert not [one for one in runs if one["trip"]]
    assert sum(one["duration"] for one in runs) >= 2e-3 * 3600.0
    options = {option for one in runs for option in one["run"]["options"]}
    assert len(options) == 2 * len(runs), "every run has a seed and a unit of its own"
    (kept,) = (tmp_path / "out" / f"seed-{seed}").iterdir()
    assert json.loads(kept.read_text()) == {"runs": runs}


@pytest.mark.parametrize("at", np.random.default_rng(24).uniform(2.0, 6.0, 2).round(2).tolist())
def test_a_stop_in_quiet_hours_is_a_false_trip(tmp_path, slow_to_notice, at):
    """What the profile itself has break is nothing that the campaign knows of."""
    profile = slow_to_notice / "rigs" / "cylinder-slow.yaml"
    fault = f"{{at: {at}, device: encoder-agonist, fault: alarm}}"
    profile.write_text(f"{profile.read_text()}simulation: {{faults: [{fault}]}}\n")
    code, runs = quiet(slow_to_notice, tmp_path / "out")
    assert code == 1
    assert {(one["trip"], one["code"]) for one in runs} == {(True, 4)}
    assert all("encoder-agonist" in one["message"] for one in runs)
    assert all(one["again"].startswith("rig run sine-slow --rig cylinder-slow") for one in runs)
    assert len([*(tmp_path / "out" / "seed-0").glob("*/")]) == len(runs)


def test_what_the_simulation_refuses_is_no_fault_and_no_pass(tmp_path, monkeypatch):
    """It never broke: a program that stops for it has not seen anything."""
    signed = Magnitudes(1.2, 6.0, "1", signed=True)  # a file with this size is refused otherwise
    slow = replace(KINDS["regulator_slow"], magnitude=signed)
    monkeypatch.setitem(KINDS, "regulator_slow", slow)
    file = tmp_path / "case.yaml"
    file.write_text(
        CASE.replace("fault: wire_cut", "fault: regulator_slow\nmagnitude: -3").replace(
            "when: {phase: run", "when: {phase: approach"
        )
    )
    result = run("run", file, "--out", tmp_path)
    assert result.return_value == 1, result.output
    (case,) = campaign(tmp_path, 0)["cases"]
    assert case["crashed"]
    assert "the simulation refuses regulator_slow at plant agonist" in case["wrongs"][0]


def test_a_worker_that_dies_is_no_pass(tmp_path, monkeypatch):
    monkeypatch.setattr("rig.faults.campaign.perform_unit", lambda *rest: None)
    result = run("run", "cylinder", "--only", "nothing", "--out", tmp_path)
    assert result.return_value == 1
    assert campaign(tmp_path, 0)["cases"][0]["crashed"]


def test_what_nothing_could_keep_off_is_said_not_to_be_counted(tmp_path):
    told = run("run", "cylinder", "--only", "wire_cut", "--out", tmp_path)
    assert told.return_value == 0, told.output
    note = "not counted: what nothing could keep off after wire_cut. Where a wire, a tube or a"
    assert note in told.stderr
    assert note in (tmp_path / "seed-0" / "campaign.html").read_text()
    quiet_one = run("run", "cylinder", "--only", "encoder_alarm", "--out", tmp_path)
    assert "not counted" not in quiet_one.output


def test_a_scenario_beside_a_profile_is_no_experiment_of_it(tmp_path):
    (tmp_path / "mine.yaml").write_text("extends: cylinder\nname: mine\n")
    before = run("list", tmp_path / "mine.yaml")
    (tmp_path / "tube.yaml").write_text(
        "rig: ./mine.yaml\nexperiment: cylinder-sine\nfault: leak\nwhere: plant agonist\n"
        "magnitude: 2e-8 m^3/(s Pa)\n"
    )
    after = run("list", tmp_path / "mine.yaml")
    assert before.return_value == after.return_value == 0, after.output
    assert before.output == after.output


def test_the_page_shows_what_went_wrong_and_runs_nothing(hazardous):
    _, out = hazardous
    page = (out / "seed-40000" / "campaign.html").read_text()
    assert "default-src 'none'" in page
    assert "program_killed" in page


def test_every_fault_of_a_rig_is_listed():
    listed = json.loads(run("list", "cylinder", "--json").output)
    names = {entry["fault"] for entry in listed}
    assert {"wire_cut", "regulator_slow", "setpoints_late", "program_killed"} <= names
    assert all(entry["what"] and entry["where"] for entry in listed)
    settings = {entry["fault"]: entry["in simulation.faults"] for entry in listed}
    assert settings["wire_cut"].endswith("value: 0}  # value: 0 agonist, 1 antagonist")
    assert settings["leak"].endswith("value: …}"), "how much is no number of a channel"


def test_a_list_of_faults_has_narrow_rows_and_no_empty_magnitude():
    """Six columns of a listing did not fit on any terminal; settings have a table of their own."""
    first, settings, _ = run("list", "cylinder").output.split("\n\n")
    header, *rows = first.splitlines()[1:]
    assert header.split() == ["fault", "what", "where", "magnitude"]
    assert all(len(row) > header.index("magnitude") for row in rows)
    assert max(map(len, rows)) < 160
    (cut,) = [row for row in settings.splitlines() if row.startswith("wire_cut ")]
    assert cut.endswith("value: 0}  # value: 0 agonist, 1 antagonist")


def test_what_a_rig_cannot_suffer_is_listed_as_refused():
    _, refused = run("list", "cylinder").output.split("# refused on cylinder")
    names = {line.split()[0] for line in refused.splitlines()[2:] if line.strip()}
    assert {"drive_fault", "camera_blind", "push", "unplugged"} <= names
    assert not {"wire_cut", "bus_off", "emergency_stop"} & names


@pytest.fixture
def slow_to_notice(tmp_path):
    return make_slow_to_notice(tmp_path)


def make_slow_to_notice(folder):
    """Make a cylinder whose nodes notice only after 150 ms that nobody commands them any more.

    On ideal regulators: those that are sold go to a new setpoint so slowly that less happens.
    """
    configs = folder / "configs"
    for kind in ("rigs", "experiments"):
        (configs / kind).mkdir(parents=True)
    for parent in ("cylinder", "cylinder-ideal"):
        copy(CONFIGS / "rigs" / f"{parent}.yaml", configs / "rigs")
    (configs / "rigs" / "cylinder-slow.yaml").write_text(
        "extends: cylinder-ideal\nname: cylinder-slow\n"
        "buses: {can0: {heartbeat: 50 ms, heartbeat_timeout: 150 ms}}\n"
    )
    (configs / "experiments" / "sine-slow.yaml").write_text(
        "name: sine-slow\nrig: cylinder-slow\ncontroller: cascade\nreference:\n  kind: sine\n"
        "  amplitude: 9 mm\n  tones:\n    - {frequency: 1 Hz, periods: 5}\n"
    )
    return configs


CASE = """\
rig: cylinder
experiment: cylinder-sine
fault: wire_cut
where: plant agonist
when: {phase: run, after: 0.2 s}
"""


MOMENTS = np.random.default_rng(33)


@pytest.mark.parametrize(
    ("moment", "then"),
    [
        (f"phase: stop, after: {MOMENTS.uniform(3.0, 100.0):.1f} s", ""),
        (f"phase: release, after: {MOMENTS.uniform(3.0, 100.0):.1f} s", ""),
        (f"phase: run, after: {MOMENTS.uniform(60.0, 100.0):.1f} s", ""),
        (
            "phase: run, after: 0.2 s",
            "then: {fault: silent_for_good, where: regulators, after: 9 s}",
        ),
    ],
)
def test_what_did_not_happen_was_not_ridden_through(tmp_path, moment, then):
    file = tmp_path / "late.yaml"
    case = CASE.replace("phase: run, after: 0.2 s", moment).replace("-sine", "-step")
    file.write_text(case + then)
    result = run("run", file, "--out", tmp_path)
    assert result.return_value == 2, result.output
    (case,) = campaign(tmp_path, 0)["cases"]
    assert (case["never"], case["crashed"]) == (True, False)
    phase, after = re.match(r"phase: (\w+), after: ([\d.]+) s", moment).groups()
    assert f"never happened: wire_cut {float(after):.3g} s into {phase}" in result.output
    (row,) = campaign(tmp_path, 0)["rows"]
    assert row["never"] == 1


def test_a_file_is_repeated_by_its_name_and_a_chosen_experiment_is_named(tmp_path):
    file = tmp_path / "case.yaml"
    file.write_text(CASE)
    run("run", file, "--out", tmp_path)
    assert campaign(tmp_path, 0)["cases"][0]["again"] == f"rig faults run {file}"
    chosen = ("run", "cylinder", "--only", "encoder_alarm", "--experiment", "cylinder-step")
    run(*chosen, "--out", tmp_path)
    again = campaign(tmp_path, 0)["cases"][0]["again"]
    assert again.endswith("--only encoder_alarm --seed 0 --experiment cylinder-step")


SILENCE = """
rig: {rig}
experiment: {experiment}
fault: sync_lost
where: can0
lasts: {lasts} s
when: {{phase: {phase}, after: {after} s}}
"""


@pytest.mark.parametrize(
    ("rig", "experiment", "phase", "after", "lasts"),
    [
        ("cylinder", "cylinder-sine", "run", 0.7, 30),
        ("cylinder", "cylinder-sine", "release", 0.001, 0.7),
        ("joint", "joint-circle", "run", 0.9, 0.3),
        pytest.param("joint-ideal", "joint-poses", "stop", 0.0, 0.2, marks=pytest.mark.slow),
        pytest.param("joint", "joint-circle", "energise", 0.2, 30, marks=pytest.mark.slow),
        pytest.param("joint-valves", "joint-valves-circle", "run", 1.7, 30, marks=pytest.mark.slow),
    ],
)
def test_setpoints_that_act_with_a_sync_that_does_not_come_are_not_waited_for(
    tmp_path, rig, experiment, phase, after, lasts
):
    file = tmp_path / "case.yaml"
    said = {"rig": rig, "experiment": experiment, "phase": phase, "after": after, "lasts": lasts}
    file.write_text(SILENCE.format(**said))
    result = run("run", file, "--out", tmp_path)
    assert result.return_value == 0, result.output


@pytest.mark.parametrize("after", [5, 60])
def test_an_interface_without_buffers_is_told_while_it_connects(tmp_path, after):
    file = tmp_path / "case.yaml"
    file.write_text(
        "rig: arm-odrive\nexperiment: arm-elbow-circle\nfault: no_buffers\nwhere: can0\n"
        f"when: {{phase: connect, after: {after} ms}}\n"
    )
    run("run", file, "--out", tmp_path)
    (case,) = campaign(tmp_path, 0)["cases"]
    assert not case["crashed"]


@pytest.mark.parametrize("rig", ["cylinder-locked", "joint-locked"])
def test_chambers_that_are_meant_to_keep_their_pressure_are_no_hazard(tmp_path, rig):
    result = run("run", rig, "--only", "nothing", "--out", tmp_path)
    assert result.return_value == 0, result.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("cylinder", "--full", "--random", "3"), "two things"),
        (("{file}", "--only", "silent"), "says itself"),
        (("{file}", "--quiet", "1"), "says itself"),
        (("cylinder", "--quiet", "1", "--random", "3"), "breaks nothing"),
        (("cylinder", "--out", "/dev/null/x"), "choose another place with --out"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_runs(tmp_path, arguments, said):
    file = tmp_path / "case.yaml"
    file.write_text(CASE)
    out = () if "--out" in arguments else ("--out", tmp_path)
    result = run("run", *[part.format(file=file) for part in arguments], *out)
    assert said in str(result.exception)


GENERATOR = np.random.default_rng(17)


@pytest.mark.parametrize("after", GENERATOR.uniform(0.0, 8.0, 2).round(3).tolist())
@pytest.mark.parametrize(
    ("procedure", "fault", "where"),
    [("response", "wire_cut", "plant agonist"), ("encoders", "program_killed", "program")],
)
def test_a_procedure_is_broken_while_it_calibrates(tmp_path, after, procedure, fault, where):
    file = tmp_path / "calibrating.yaml"
    file.write_text(
        f"rig: cylinder\nexperiment: {procedure}\nfault: {fault}\nwhere: {where}\n"
        f"when: {{phase: calibration, after: {after}}}\n"
    )
    result = run("run", file, "--out", tmp_path)
    assert result.return_value == 0, result.output
    (case,) = campaign(tmp_path, 0)["cases"]
    assert case["ending"]["broke_at"] is not None
    assert case["ending"]["code"] == (4 if fault == "wire_cut" else None), case["ending"]
    (row,) = campaign(tmp_path, 0)["rows"]
    assert row["phases"]["calibration"] == [1, 0]


@pytest.mark.parametrize("cycle", GENERATOR.integers(1, 40, 2).tolist())
@pytest.mark.parametrize(
    ("fault", "code", "said"),
    [
        ("interrupted", 130, "interrupted"),
        ("disk_full", 2, "File too large"),
        ("controller_nan", 4, "nan"),
        ("program_killed", None, "killed"),
        ("reader_gone", 130, "stopped by the operator"),
    ],
)
def test_what_breaks_in_a_rehearsal_is_not_forgotten(tmp_path, fault, code, said, cycle):
    """Nothing is opened yet: the run is refused, or goes on and sees it."""
    file = tmp_path / "rehearsed.yaml"
    file.write_text(
        f"rig: cylinder\nexperiment: cylinder-sine\nfault: {fault}\n"
        f"when: {{phase: rehearsal, after: {cycle} ms}}\n"
    )
    result = run("run", file, "--out", tmp_path)
    assert result.return_value == 0, result.output
    (case,) = campaign(tmp_path, 0)["cases"]
    assert (case["ending"]["code"], case["wrongs"]) == (code, []), case["ending"]
    assert said in case["ending"]["message"]


def test_files_of_two_experiments_run_both(tmp_path):
    """They were drawn with nothing that they could share a run by."""
    for experiment in ("cylinder-sine", "cylinder-step"):
        text = CASE.replace("cylinder-sine", experiment)
        (tmp_path / f"{experiment}.yaml").write_text(text)
    files = [tmp_path / "cylinder-sine.yaml", tmp_path / "cylinder-step.yaml"]
    assert run("run", *files, "--out", tmp_path / "both").return_value == 0
    endings = [case["ending"] for case in campaign(tmp_path / "both", 0)["cases"]]
    for file, ending in zip(files, endings, strict=True):
        run("run", file, "--out", tmp_path / "alone")
        (case,) = campaign(tmp_path / "alone", 0)["cases"]
        assert case["ending"] == ending
