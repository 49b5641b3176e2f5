"""All that is wrong in a file is told in one pass: broken rules beside what cannot be read."""

import random

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.cli import invoke
from rig.config import ProfileError, load_profile
from rig.config.dump import plain_of
from rig.config.names import find_configs

RULES = {
    "cylinder": {
        "give either voltage or current": (
            "devices.regulators.channels.agonist.monitor.current=[4 mA, 20 mA]",
            ("monitor.voltage", "monitor.current"),
        ),
        "does not rise; give the line's lower end first": (
            "devices.regulators.channels.antagonist.setpoint.raw=[30000, 0]",
            ("setpoint.raw", "setpoint.type"),
        ),
        "a reading outside would never be a fault": (
            "devices.encoder-agonist.overtravel=61 mm", ("overtravel", "stroke"),
        ),
        "does not fit into bore": ("cylinder.rod=17 mm", ("rod", "bore")),
        "is outside limits.pressure": (
            "cylinder.base_pressure=9 bar", ("base_pressure", "limits.pressure"),
        ),
        "friction at rest is at least that of sliding": (
            "cylinder.friction.breakaway=1 N", ("friction.breakaway", "friction.coulomb"),
        ),
        "the lower limit": ("cylinder.limits.position=[5 mm, -5 mm]", ("limits.position",)),
        "one late heartbeat would stop the rig": (
            "buses.can0.heartbeat_timeout=15 ms", ("heartbeat", "heartbeat_timeout"),
        ),
    },
    "legs": {
        "voltage is not a rising pair": ("devices.servos.voltage=[16 V, 9 V]", ("voltage",)),
        "have the same id": (
            "devices.servos.joints.right_knee.id=1", ("right_hip_yaw.id", "right_knee.id"),
        ),
        "echo takes health": (
            "devices.servos.health=false", ("health", "echo"),
        ),
    },
}  # fmt: skip
MORE = {"legs": ("devices.servos.echo=true",)}
NOTHING = "~nothing of the kind~"


def leaves(plain, path=()):
    if isinstance(plain, dict):
        for key, below in plain.items():
            yield from leaves(below, (*path, key))
    elif isinstance(plain, int | float) and not isinstance(plain, bool):
        yield ".".join(path)


def settings_of(rig):
    """Return the settings of a rig that are numbers, without calibrations and what names others."""
    plain = plain_of(load_profile(rig, REGISTRY, (), find_configs()))
    kept = {key: plain[key] for key in ("loop", "devices", "buses", plain["mechanism"], "plant")}
    text = yaml.safe_dump(kept)
    return [name for name in leaves(yaml.safe_load(text)) if not name.endswith("serial")]


def told(rig, options):
    with pytest.raises(ProfileError) as caught:
        load_profile(rig, REGISTRY, (*MORE.get(rig, ()), *options), find_configs())
    return {(str(d.mark), d.message) for d in caught.value.diagnostics}


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rig", RULES)
def test_rules_and_what_cannot_be_read_are_told_together(rig, seed):
    """As many as drawn, and none that is there only beside another."""
    chance = random.Random(f"{rig} {seed}")
    drawn = chance.sample(sorted(RULES[rig]), chance.randint(1, len(RULES[rig])))
    rules = [RULES[rig][words] for words in drawn]
    needed = tuple(name for _, names in rules for name in names)
    free = [name for name in settings_of(rig) if not name.endswith(needed)]
    wrong = chance.sample(free, chance.randint(1, 4))
    options = [*(option for option, _ in rules), *(f"{name}={NOTHING}" for name in wrong)]
    together = told(rig, options)
    assert {words for words in drawn if not any(words in said for _, said in together)} == set()
    for name in wrong:
        last = name.rpartition(".")[2]
        assert any(last in said and "~nothing" in said for _, said in together), (name, together)
    alone = set().union(*(told(rig, [option]) for option in options))
    assert together <= alone


@pytest.mark.parametrize("seed", range(4))
def test_what_is_left_out_hides_no_rule(seed, tmp_path):
    """A key that is missing, a key that there is not, a rule: all three."""
    chance = random.Random(seed)
    plain = plain_of(load_profile("cylinder", REGISTRY, ("calibration=false",), find_configs()))
    left_out = chance.choice(["home", "moving_mass", "encoder_agonist", "friction"])
    del plain["cylinder"][left_out]
    plain["cylinder"]["rod"] = plain["cylinder"]["bore"] * chance.uniform(1.0, 2.0)
    plain["cylinder"]["shoe_size"] = 43
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(plain))
    said = {message for _, message in told(path, ())}
    assert f"key {left_out!r} is missing" in said
    assert "unknown key 'shoe_size'" in said
    assert len([message for message in said if "does not fit into bore" in message]) == 1
    assert len(said) == 3, said


def said_by(capsys, *words):
    assert invoke(["check", *map(str, words)]) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("seed", range(4))
def test_rules_between_parts_are_told_together(seed, tmp_path, capsys):
    """Of the rig and of the experiment, with the places of both ends."""
    chance = random.Random(seed)
    node, pressure = chance.randrange(1, 120), chance.randrange(600, 5000)
    profile = {
        "nodes": "devices:"
        f" {{encoder-agonist: {{node: {node}}}, encoder-antagonist: {{node: {node}}}}}",
        "roles": "cylinder: {encoder_agonist: nobody, encoder_antagonist: noone}",
    }
    broken = chance.sample(sorted(profile), chance.randint(1, 2))
    rig = tmp_path / "mine.yaml"
    rig.write_text("extends: cylinder\n" + "\n".join(profile[name] for name in broken))
    experiment = tmp_path / "task.yaml"
    experiment.write_text(
        f"extends: cylinder-step\nrig: {rig}\nfigures: [qwqw, tracking, zxzx]\n"
        f"metrics: {{overshoot: {{max: {pressure} N}}, wxwx: {{}}}}\n"
    )
    said = said_by(capsys, rig)
    assert ("both have number" in said) == ("nodes" in broken)
    assert said.count("no device is called") == 2 * ("roles" in broken)
    alone = said.splitlines()
    said = said_by(capsys, experiment)
    for words in ("called 'qwqw'", "called 'zxzx'", "no measure is called 'wxwx'", "bound is in N"):
        assert words in said, said
    assert [line for line in alone if "errors" not in line and line not in said] == []
    assert f"{experiment}:3:" in said and f"{rig}:2:" in said
