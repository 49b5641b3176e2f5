"""Limits of other cylinders that a profile inherits are told with what they come to on its own."""

import math
import random

import pytest

from rig.assembly import REGISTRY
from rig.cli import inherited, invoke
from rig.config import load_profile
from rig.config.names import find_configs


def said_of(tmp_path, text):
    path = tmp_path / "ours.yaml"
    path.write_text(text)
    search = find_configs()
    sentences = inherited.inherited_sentences(load_profile(path, REGISTRY, (), search), search)
    return [sentence for sentence in sentences if sentence.startswith("limits.")]


def test_both_limits_are_told_with_what_they_come_to(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sizes = "bore: 32 mm, rod: 12 mm, stroke: 100 mm, home: 40 mm"
    text = (
        f"extends: cylinder\nname: ours\ncylinder: {{{sizes}}}\n"
        f"plant: {{cylinder: {{bore: 32 mm, rod: 12 mm, stroke: 100 mm}}, home: 40 mm}}\n"
        "devices: {encoder-agonist: {stroke: 100 mm}, encoder-antagonist: {stroke: 100 mm}}\n"
    )
    (tmp_path / "ours.yaml").write_text(text)
    assert invoke(["check", "ours.yaml"]) == 0
    (told,) = (x for x in capsys.readouterr().err.splitlines() if x.startswith("warning: limits."))
    assert told.startswith("warning: limits.pair_force, limits.position: from ")
    assert "pair_force 60 N is 86.81 kPa on this bore; " in told
    assert "position -20 mm … 20 mm, the stroke allows ±40 mm. " in told
    assert told.endswith("say in ours.yaml what is meant")


@pytest.mark.parametrize("seed", range(6))
def test_only_what_a_dimension_counts_for_is_told(tmp_path, seed):
    chance = random.Random(seed)
    bore = 0.1 * chance.randint(200, 400)
    of_bore = said_of(tmp_path, f"extends: cylinder\ncylinder: {{bore: {bore} mm}}\n")
    kilopascal = 60.0 / (0.25 * math.pi * (bore**2 - 5.0**2) * 1e-6) * 1e-3
    (told,) = of_bore
    assert told.startswith("limits.pair_force: ") and f"is {kilopascal:.4g} kPa on" in told
    (told,) = said_of(tmp_path, "extends: cylinder\ncylinder: {stroke: 80 mm, home: 40 mm}\n")
    assert told.startswith("limits.position: ")


def test_what_a_profile_says_itself_is_not_told(tmp_path):
    own = "limits: {pair_force: 100 N, position: [-9 mm, 9 mm]}"
    text = f"extends: cylinder\ncylinder: {{bore: 32 mm, stroke: 80 mm, home: 40 mm, {own}}}\n"
    assert said_of(tmp_path, text) == []
    assert said_of(tmp_path, "extends: cylinder\ncylinder: {moving_mass: 1 kg}\n") == []


def test_a_ring_has_its_tension_told(tmp_path):
    (told,) = said_of(tmp_path, "extends: joint\njoint: {bore: 20 mm}\n")
    assert told.startswith("limits.tension: ") and "tension 90 N is 305.6 kPa on this bore" in told
