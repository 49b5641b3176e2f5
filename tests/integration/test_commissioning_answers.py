"""A file of answers is checked before the first step: keys, what is missing, and each form."""

import random
from types import SimpleNamespace

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.commissioning.answers import check_answers
from rig.commissioning.forms import anything, one_of, reading, whose_reading
from rig.commissioning.operator import Task
from rig.commissioning.questions import Question, Rehearsed, questions_of
from rig.commissioning.session import steps_of
from rig.config import find_configs, load_profile
from rig.hal import ConfigurationError

PROFILE = load_profile("cylinder", REGISTRY, (), find_configs(None))
TASKS = [
    Task("cable.gauges", "", None, one_of("yes", "no")),
    Task("sensors.agonist", "", None, reading("m", "0.5 mm")),
    Task("actuators.agonist.8", "", None, whose_reading(["agonist"], "Pa", "8 kPa"),
         "actuators.agonist."),
    Task("actuators.agonist.11.3", "", None, whose_reading(["agonist"], "Pa", "8 kPa"),
         "actuators.agonist."),
    Task("leak.soap", "", None, anything),
]  # fmt: skip
GOOD = {
    "cable.gauges": "yes", "sensors.agonist": "0.5 mm", "actuators.agonist.8": "agonist 7.9 kPa",
    "actuators.agonist.14.7": "agonist 15 kPa", "leak.soap": "none",
}  # fmt: skip


def rehearsed(stopped=None):
    questions = [Question(task.key, task.key.partition(".")[0], "", "") for task in TASKS]
    return Rehearsed(questions, {task.key: task for task in TASKS}, stopped)


def said(given, **how):
    with pytest.raises(ConfigurationError) as caught:
        check_answers("answers.yaml", given, rehearsed(how.pop("stopped", None)), **how)
    return str(caught.value)


def test_what_answers_all_passes():
    check_answers("answers.yaml", GOOD, rehearsed())


@pytest.mark.parametrize("key", ["sensors.agonits", "actuators.agonist.high", "leaksoap", "x"])
def test_a_key_that_nothing_asks_for_is_told_the_nearest(key):
    told = said({**GOOD, key: "yes"})
    assert f"{key!r} is never asked; " in told
    near = {"sensors.agonits": "sensors.agonist", "leaksoap": "leak.soap"}.get(key)
    assert near is None or f"did you mean {near}?" in told
    check_answers("answers.yaml", {**GOOD, key: "yes"}, rehearsed("leak: of a defect"))


@pytest.mark.parametrize("seed", range(5))
def test_every_missing_answer_is_told_at_once(seed):
    chance = random.Random(seed)
    lost = chance.sample(["cable.gauges", "sensors.agonist", "leak.soap"], chance.randint(1, 3))
    told = said({key: answer for key, answer in GOOD.items() if key not in lost})
    assert all(key in told.partition("no answer to ")[2] for key in lost)
    taken = [task.key.partition(".")[0] for task in TASKS]
    left = [step for step in taken if f"{step}." not in " ".join(lost)]
    check_answers(
        "answers.yaml", {k: a for k, a in GOOD.items() if k not in lost}, rehearsed(), left
    )


def test_of_keys_that_end_in_a_measured_number_one_will_do():
    rungs = [key for key in GOOD if key.startswith("actuators")]
    one = {key: answer for key, answer in GOOD.items() if key != rungs[0]}
    check_answers("answers.yaml", one, rehearsed())
    none = {key: answer for key, answer in GOOD.items() if key not in rungs}
    assert "no answer to actuators.agonist.…" in said(none)


@pytest.mark.parametrize(
    ("key", "answer", "expected"),
    [
        ("cable.gauges", "True", "yes or no"),
        ("cable.gauges", "maybe", "yes or no"),
        ("sensors.agonist", "0.5 kPa", "a reading as 0.5 mm"),
        ("sensors.agonist", "half", "a reading as 0.5 mm"),
        ("sensors.agonist", "nan", "a reading as 0.5 mm"),
        ("actuators.agonist.8", "8 kPa", "one of agonist and what it shows, as agonist 8 kPa"),
        ("actuators.agonist.12.9", "agonist 8 mm", "a reading as agonist 8 kPa"),
        ("actuators.agonist.12.9", "agonist", "a reading as agonist 8 kPa"),
    ],
)
def test_an_answer_in_another_form_is_told_what_is_expected(key, answer, expected):
    assert f"{key} is {answer!r}, expected {expected}" in said({**GOOD, key: answer})
    assert expected in said({**GOOD, key: answer}, lacking=())


def test_a_reading_that_tells_nothing_and_none_where_it_may_be():
    assert reading("N", "80 N", 10.0)("5 N") == "at least 10 N"
    assert whose_reading(["q1"], "rad", "1 deg", or_none=True)("none") == ""
    assert whose_reading(["q1"], "rad", "1 deg")("none") != ""


@pytest.fixture
def opened(tmp_path, monkeypatch):
    """Return a lab, and which steps are taken there."""
    taken = []
    steps = [step for step in steps_of(PROFILE) if step.name in ("bus", "sensors")]
    asked = questions_of(PROFILE, steps)

    def step(own):
        return SimpleNamespace(
            name=own.name, does=own.does, expects=own.expects,
            perform=lambda site: (taken.append(own.name), own.perform(site))[1],
        )  # fmt: skip

    monkeypatch.setattr("rig.commissioning.session.steps_of", lambda _: list(map(step, steps)))
    monkeypatch.setattr("rig.commissioning.questions.questions_of", lambda *_: asked)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").mkdir()
    file = tmp_path / "answers.yaml"

    def commission(answers, *words):
        file.write_text(yaml.safe_dump(answers))
        taken.clear()
        return invoke(["commission", "cylinder", "--answers", str(file), *words]), list(taken)

    return commission


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"sensors.agonits": "0.5 mm"}, "did you mean sensors.agonist?"),
        ({"sensors.agonist": None}, "no answer to sensors.agonist"),
        ({"sensors.agonist": "plenty"}, "expected a reading as 0.5 mm"),
        ({"sensors.agonist": True}, "expected a reading as 0.5 mm"),
    ],
)
@pytest.mark.parametrize("words", [(), ("--dry-run",)])
def test_no_step_is_taken_with_answers_that_will_not_do(opened, capsys, change, expected, words):
    answers = {"sensors.agonist": "0.5 mm", "sensors.antagonist": "0.5 mm", **change}
    given = {key: answer for key, answer in answers.items() if answer is not None}
    assert opened(given, *words) == (2, [])
    told = capsys.readouterr().err
    assert expected in told and "the file of answers" in told


def test_what_has_passed_needs_no_answer_any_more(opened, capsys):
    answers = {"sensors.agonist": "0.5 mm", "sensors.antagonist": "0.5 mm"}
    assert opened(answers) == (0, ["bus", "sensors"])
    assert opened({}) == (0, [])
    code, taken = opened({}, "--anew")
    assert (code, taken) == (2, [])
    assert "no answer to sensors.agonist, sensors.antagonist" in capsys.readouterr().err


def test_a_step_of_every_mechanism_takes_what_simulated_hands_answer():
    for rig, lengthy in (("cylinder", ("load", "first-motion")), ("arm", ("ends", "first-motion"))):
        profile = load_profile(rig, REGISTRY, (), find_configs(None))
        steps = [step for step in steps_of(profile) if step.name not in lengthy]
        asked = questions_of(profile, steps)
        assert asked.stopped is None
        check_answers("it", {q.key: q.simulated for q in asked.questions}, asked)
        stems = {task.stem for task in asked.tasks.values() if task.stem}
        assert stems == ({"actuators.agonist.", "actuators.antagonist."} if rig == "cylinder"
                         else set())  # fmt: skip
