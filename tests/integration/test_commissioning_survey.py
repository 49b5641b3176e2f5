"""The first step of the acceptance test says all that differs on the buses, not only the first."""

import json
import random

import pytest
from planted import foreign_node, nodes, silent_node

from rig.assembly import REGISTRY, Backend, build_rig
from rig.assembly.survey import Answer, expected_on
from rig.assembly.survey_words import differences_in_words, say_renumbered
from rig.cli import invoke
from rig.commissioning.operator import SimulatedOperator
from rig.commissioning.session import CommissioningFacts, begin, commission
from rig.commissioning.site import Site
from rig.commissioning.steps.identity import OnTheBus
from rig.config import find_configs, load_profile
from rig.hal.frames import Found

PROFILE = load_profile("cylinder", REGISTRY, (), find_configs(None))


def take(tmp_path, plant, overrides=()):
    """Take the step on a rig that is otherwise than its profile."""

    def make_rig(its):
        rig = build_rig(
            load_profile("cylinder", REGISTRY, overrides, find_configs()), Backend.VIRTUAL
        )
        rig.profile = its
        plant(rig)
        return rig

    site = Site(PROFILE, make_rig, SimulatedOperator(), tmp_path)
    record = begin(PROFILE, [tmp_path], CommissioningFacts("virtual"), anew=True)
    stopped = commission(site, record, [OnTheBus()], tmp_path, lambda text: None)
    return stopped, record


@pytest.mark.parametrize("seed", range(3))
def test_a_wrong_node_number_is_told_as_one(tmp_path, seed):
    chance = random.Random(seed)
    wanted = {item.name: item for item in expected_on(PROFILE, "can0")}
    name = chance.choice(sorted(wanted))
    taken = {item.number for item in wanted.values()}
    number = chance.choice([n for n in range(1, 127) if n not in taken])
    stopped, record = take(tmp_path, lambda rig: None, [f"devices.{name}.node={number}"])
    place = f"bus can0, node 0x{wanted[name].number:02X}"
    clauses = {
        f"{name} ({place}): does not answer",
        f"an unknown device (bus can0, node 0x{number:02X}): not in the profile",
    }
    said = record["steps"]["bus"]["said"]
    *found, advice = said.split("; ")
    assert set(found) == clauses
    assert advice.startswith(f"node 0x{number:02X} may be {name} with another node number")
    assert stopped == f"bus: {said}"


def test_whoever_is_missing_and_whoever_is_something_else_are_both_told(tmp_path):
    def plant(rig):
        foreign_node(rig, random.Random(1))  # an encoder
        nodes(rig)["regulators"].inject("silent")

    stopped, _ = take(tmp_path, plant)
    assert "regulators (bus can0, node 0x10): does not answer" in stopped
    assert "an unknown device" in stopped and "not in the profile" in stopped
    assert "may be" not in stopped


@pytest.mark.parametrize(
    ("lost", "unknown"),
    [
        (1, [Found(0x37, profile=401)]),  # another type
        (1, [Found(0x37, profile=406, answers=0)]),  # has not said what it is
        (1, [Found(0x37, profile=406, serials=(1, 2), answers=2)]),  # two of them
        (2, [Found(0x37, profile=406)]),
        (1, [Found(0x37, profile=406), Found(0x38, profile=406)]),
    ],
)
def test_what_may_be_several_is_not_guessed(lost, unknown):
    wanted = [item for item in expected_on(PROFILE, "can0") if item.profile == 406]
    answers = [Answer("can0", w.number, w.name, None, ("does not answer",)) for w in wanted[:lost]]
    answers += [Answer("can0", one.node, "", one, ("not in the profile",)) for one in unknown]
    assert say_renumbered(PROFILE, answers) is None
    assert len(differences_in_words(answers)) == lost + len(unknown)


def test_the_record_and_json_say_it_all(tmp_path, capsys, monkeypatch):
    built = build_rig

    def planted(its, *how):
        rig = built(its, *how)
        silent_node(rig, random.Random(2))
        foreign_node(rig, random.Random(2))
        return rig

    monkeypatch.setattr("rig.assembly.build_rig", planted)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").mkdir()
    assert invoke(["commission", "cylinder", "--json"]) == 3
    said = json.loads(capsys.readouterr().out)["steps"]["bus"]["said"]
    assert "does not answer" in said and "an unknown device" in said
    assert said in (tmp_path / "configs/commissioning/cylinder.yaml").read_text().replace(
        "\n      ", " "
    )
