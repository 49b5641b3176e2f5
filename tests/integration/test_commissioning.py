"""The acceptance test: healthy rigs pass, and each planted defect is found where it has to be."""

import json
import shutil
from types import SimpleNamespace

import pytest
from planted import EARLIER, PLANTED, drawn_unit, no_dump_valve, rig_with

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.commissioning.operator import SimulatedOperator, WrittenAnswers
from rig.commissioning.session import CommissioningFacts, begin, commission, steps_of
from rig.commissioning.site import Site
from rig.config import find_configs, load_profile
from rig.run_facts import RunStatus

ENOUGH = {"pressure": 20e3, "way": 1e-3}


def perform(out, profile, plant=None, seed=0, skip=()):
    seen = dict.fromkeys(ENOUGH, 0.0)
    site = Site(profile, rig_with(seen, plant, seed), SimulatedOperator(), out)
    steps = [step for step in steps_of(profile) if step.name not in skip]
    record = begin(profile, [out], CommissioningFacts("virtual"), anew=True)
    said = []
    return commission(site, record, steps, out, said.append), record, seen


def unit(rig, seed):
    return drawn_unit(load_profile(rig, REGISTRY, (), find_configs(None)), seed)


def find(tmp_path, rig, plant, seed):
    step, words = PLANTED[plant]
    stopped, record, seen = perform(tmp_path, unit(rig, seed), plant, seed)
    assert stopped is not None, "nothing was found"
    assert stopped.split(": ")[0] in (step, *EARLIER.get(plant, ())), stopped
    assert words in stopped
    assert record["digest"] == ""
    bounds = {**ENOUGH, "way": 1.0} if step == "ends" else ENOUGH  # there hands move the rods
    for what, most in bounds.items():
        assert seen[what] <= most, f"{plant.__name__}: {what} {seen[what]}"


SOON = ("foreign_node", "normally_open", "no_dump_valve", "watchdog_off", "encoder_reversed")


@pytest.mark.parametrize(
    "plant",
    [plant for plant in PLANTED if plant.__name__ in SOON],
    ids=lambda plant: plant.__name__,
)
def test_a_planted_defect_is_found_at_its_step_before_anything_moves(tmp_path, plant):
    find(tmp_path, "cylinder", plant, 1)


def test_a_healthy_rig_is_not_refused(tmp_path):
    stopped, record, _ = perform(tmp_path, unit("cylinder", 0), skip=("first-motion",))
    assert stopped is None
    assert all(step["passed"] for step in record["steps"].values())


@pytest.mark.slow
@pytest.mark.sampled(8)
@pytest.mark.parametrize("seed", range(2, 4))
@pytest.mark.parametrize("plant", PLANTED, ids=lambda plant: plant.__name__)
def test_every_planted_defect_is_found_however_it_is_drawn(tmp_path, plant, seed):
    find(tmp_path, "cylinder", plant, seed)


@pytest.mark.slow
@pytest.mark.lengthy
@pytest.mark.parametrize("hundred", range(10))
def test_no_healthy_rig_of_a_thousand_is_refused(tmp_path, hundred):
    for seed in range(100 * hundred, 100 * hundred + 100):
        stopped, _, _ = perform(tmp_path, unit("cylinder", seed), seed=seed)
        assert stopped is None, f"seed {seed}: {stopped}"


def test_what_has_passed_is_not_done_again(tmp_path):
    profile = unit("cylinder", 1)
    stopped, _, _ = perform(tmp_path, profile, no_dump_valve)
    assert stopped.startswith("supply")
    again = begin(profile, [tmp_path], CommissioningFacts("virtual"), anew=False)
    assert [name for name, step in again["steps"].items() if step["passed"]] == [
        "bus", "identity", "emergency-stop",
    ]  # fmt: skip
    changed = unit("cylinder-low-speed", 1)
    other = begin(changed, [tmp_path], CommissioningFacts("virtual"), anew=False)
    assert other["steps"] == {}


def test_answers_that_are_none_are_refused_before_anything_is_opened(tmp_path, capsys):
    file = tmp_path / "answers.yaml"
    file.write_text("- pressed\n")
    assert invoke(["commission", "cylinder", "--dry-run", "--answers", str(file)]) == 2
    assert "answers.yaml has no keys and answers" in capsys.readouterr().err


def test_the_keys_of_answers_are_shown_and_answer_what_is_asked(tmp_path, capsys, monkeypatch):
    steps = [step for step in steps_of(unit("cylinder", 1)) if step.name in ("bus", "sensors")]
    monkeypatch.setattr("rig.commissioning.session.steps_of", lambda _: steps)
    monkeypatch.chdir(tmp_path)
    assert invoke(["commission", "cylinder", "--dry-run", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["answers_lack"] is None
    answers = {entry["key"]: entry["simulated"] for entry in shown["answers"]}
    assert set(answers) == {"sensors.agonist", "sensors.antagonist"}
    assert {entry["step"] for entry in shown["answers"]} == {"sensors"}
    assert invoke(["commission", "cylinder", "--dry-run"]) == 0
    assert "sensors.agonist" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []

    asked = []
    given = WrittenAnswers(answers, SimulatedOperator())
    monkeypatch.setattr("rig.cli.commission._operator", lambda *_: given)
    answer = given.answer
    monkeypatch.setattr(given, "answer", lambda task: (asked.append(task.key), answer(task))[1])
    (tmp_path / "configs").mkdir()
    assert invoke(["commission", "cylinder", "--out", "runs"]) == 0
    assert set(asked) == set(answers)


def test_ctrl_c_is_no_failure_of_the_rig_and_keeps_what_has_passed(tmp_path, capsys, monkeypatch):
    configs = tmp_path / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    steps = [s for s in steps_of(unit("cylinder", 1)) if s.name in ("bus", "first-motion")]
    monkeypatch.setattr("rig.commissioning.session.steps_of", lambda _: steps)
    words = ["commission", "cylinder", "--configs", str(configs), "--out", str(tmp_path / "runs")]
    words += ["--seed", "1"]
    # As Ctrl-C while it is connected or moves: the run ends in order, and says so.
    with monkeypatch.context() as pressed:
        aborted = SimpleNamespace(exit_code=130, status=RunStatus.ABORTED, message="interrupted")
        pressed.setattr("rig.experiment.run.run_experiment", lambda *_, **__: aborted)
        assert invoke(words) == 130
    told = capsys.readouterr().err
    assert "FAILED" not in told
    assert told.endswith(
        "interrupted; the rig is made safe; what has passed is kept, go on with: rig commission "
        f"{configs / 'rigs' / 'cylinder.yaml'} --on virtual --seed 1\n"
    )
    assert invoke(words) == 0
    told = capsys.readouterr().err
    assert "1/2 bus" not in told and "2/2 first-motion" in told
