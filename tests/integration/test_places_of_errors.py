"""An error that holds one part of a file against another says where both stand."""

import random
import re
from pathlib import Path

import pytest
import yaml

from rig.assembly import REGISTRY, check_profile
from rig.cli import invoke
from rig.config import load_profile
from rig.config.names import find_configs


def said_of(tmp_path, text, capsys):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    assert invoke(["check", str(path)]) == 2
    return path, capsys.readouterr().err


CASES = {
    "nodes": ("devices:\n  encoder-agonist:\n    node: 5\n  encoder-antagonist:\n    node: 5\n",
              ["devices.encoder-agonist: {}:3:3", "devices.encoder-antagonist: {}:5:3"]),
    "pressure": ("cylinder:\n  limits:\n    pressure: [0, 9 bar]\n",
                 ["cylinder.limits.pressure: {}:4:5", r"devices.regulators: \S+:\d+:3"]),
    "role": ("cylinder:\n  encoder_agonist: nobody\n",
             ["cylinder.encoder_agonist: {}:3:3"]),
    "rod": ("cylinder:\n  rod: 40 mm\n", ["{}:2:1: rod", r"rod in {}:3:3", "bore in \\S+:\\d+:3"]),
    "wire": ("devices:\n  regulators:\n    channels:\n      agonist:\n        monitor:\n"
             "          current: [4 mA, 20 mA]\n",
             ["voltage in \\S+cylinder.yaml:", "current in {}:7:11",
              "to take back what the base gives, add `voltage: null` beside current in {}:7:11"]),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_both_ends_are_named(case, tmp_path, capsys):
    more, expected = CASES[case]
    path, err = said_of(tmp_path, f"extends: cylinder\n{more}", capsys)
    for pattern in expected:
        assert re.search(pattern.replace("{}", re.escape(str(path))), err), err


def test_a_rule_between_keys_that_must_have_a_value_offers_no_null(tmp_path, capsys):
    _, err = said_of(tmp_path, "extends: cylinder\ncylinder:\n  rod: 40 mm\n", capsys)
    assert "null" not in err and "take back" not in err


def test_an_option_is_told_the_option_that_takes_the_file_back(tmp_path, capsys):
    path = tmp_path / "mine.yaml"
    path.write_text("extends: cylinder\n")
    line = "devices.regulators.channels.agonist.monitor"
    words = ["check", str(path), "--set", f"{line}.current=[4 mA, 20 mA]"]
    assert invoke(words) == 2
    assert f"to take back what the file gives, add --set {line}.voltage=null\n" in (
        capsys.readouterr().err
    )


def test_null_takes_back_what_a_base_gives(tmp_path):
    path = tmp_path / "mine.yaml"
    more = "          voltage: null\n          raw: [0, 32767]\n"
    path.write_text(f"extends: cylinder\n{CASES['wire'][0]}{more}")
    profile = load_profile(path, REGISTRY, (), find_configs())
    check_profile(profile)
    monitor = profile.devices["regulators"].settings.channels["agonist"].monitor
    assert monitor.voltage is None and monitor.current == (4e-3, 20e-3)


def drawn_breaches(chance):
    """Return texts that break a rule between two parts, each with what stands at its places."""
    node, pressure = chance.randrange(1, 127), chance.randrange(700, 5000)
    bore, rod = sorted(chance.uniform(5.0, 30.0) for _ in range(2))
    name = "".join(chance.choices("abcdefgh", k=8))
    ends = chance.sample(["agonist", "antagonist"], 2)
    return {
        "nodes": ("devices:\n" + "".join(f"  encoder-{e}: {{node: {node}}}\n" for e in ends),
                  [f"encoder-{e}: {{node" for e in ends]),
        "pressure": (f"cylinder: {{limits: {{pressure: [0, {pressure} kPa]}}}}\n",
                     ["limits: {pressure", "regulators:"]),
        "rod": (f"cylinder:\n  rod: {rod} mm\n  bore: {bore} mm\n", ["rod: ", "bore: "]),
        "role": (f"cylinder: {{encoder_{ends[0]}: {name}}}\n", [f"encoder_{ends[0]}: {name}"]),
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["nodes", "pressure", "rod", "role"])
def test_a_drawn_breach_names_both_ends(kind, seed, tmp_path, capsys):
    chance = random.Random(seed)
    text, ends = drawn_breaches(chance)[kind]
    blank = "# nothing\n" * chance.randrange(30)
    _, err = said_of(tmp_path, f"{blank}extends: cylinder\n{blank}{text}", capsys)
    places = re.findall(r"(\S+\.yaml):(\d+):(\d+)", err)
    shown = [
        Path(file).read_text().splitlines()[int(line) - 1][int(column) - 1 :]
        for file, line, column in places
    ]
    for end in ends:
        key = end.partition("{")[2] or end
        assert any(key in line or end in line for line in shown), (end, shown, err)


@pytest.mark.parametrize("seed", range(4))
def test_a_drawn_name_that_an_experiment_gets_wrong_has_its_place(seed, tmp_path, capsys):
    chance = random.Random(seed)
    wrong = "".join(chance.choices("qwxz", k=7))
    base = (find_configs()[-1] / "experiments" / "cylinder-sine.yaml").read_text()
    before = {"rig": r"^rig: .*$", "controller": r"^controller: .*$", "figures": r"^figures: .*$"}
    for key, pattern in before.items():
        value = f"[{wrong}]" if key == "figures" else wrong
        text, count = re.subn(pattern, f"{key}: {value}", base, flags=re.MULTILINE)
        assert count == 1
        path = tmp_path / "sine.yaml"
        path.write_text(text)
        assert invoke(["check", str(path)]) == 2
        err = capsys.readouterr().err
        line = 1 + text[: text.index(wrong)].count("\n")
        assert re.search(rf"{re.escape(str(path))}:{line}:\d+", err), err


PAIRS = {
    "cylinder": [("cylinder.limits.position", "mm", 25), ("cylinder.limits.pressure", "kPa", 400)],
    "joint": [("joint.limits.tension", "N", 80), ("joint.limits.pressure", "kPa", 400)],
    "arm": [("devices.drives.joints.q2.limits", "deg", 90)],
}
WRONG = ["loop: {rate: 7 m}", "nonsense: 1"]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("rig", PAIRS)
def test_reversed_limits_are_told_beside_all_the_rest(rig, seed, tmp_path, capsys):
    chance = random.Random(seed)
    lines, expected = [f"extends: {rig}", *WRONG], []
    tree = {}
    for key, unit, most in PAIRS[rig]:
        upper, lower = sorted(chance.uniform(1, most) for _ in range(2))
        below = tree
        *heads, last = key.split(".")
        for head in heads:
            below = below.setdefault(head, {})
        below[last] = [f"{lower} {unit}", f"{upper} {unit}"]
        expected.append(rf"{last}: the lower limit \S+ is not below")
    lines.append(yaml.safe_dump(tree, default_flow_style=False))
    path, err = said_of(tmp_path, "\n".join(lines), capsys)
    assert f"{len(WRONG) + len(expected)} errors" in err
    for pattern in (*expected, "loop.rate: '7 m'", "unknown key 'nonsense'"):
        assert re.search(rf"{re.escape(str(path))}:\d+:\d+: {pattern}", err), err


def test_no_more_places_are_told_than_help(tmp_path, capsys):
    _, err = said_of(tmp_path, "extends: cylinder\ncylinder:\n  regulators: nobody\n", capsys)
    assert err.count("\n    ") <= 6


def refused(capsys, *options):
    words = ["run", "cylinder-sine", "--on", "sim"]
    assert invoke([*words, *(word for option in options for word in ("--set", option))]) == 2
    return capsys.readouterr().err


def test_an_option_that_makes_a_motion_impossible_is_named_before_the_file(capsys):
    err = refused(capsys, "reference.amplitude=200mm")
    place = r"experiment\.reference: --set reference\.amplitude=200mm; over \S+sine\.yaml:\d+:\d+\n"
    assert re.search(place, err), err
    assert re.search(r"cylinder\.limits\.position: \S+cylinder\.yaml:\d+:\d+\n", err), err


def test_an_option_of_the_profile_is_named_for_what_it_forbids(capsys):
    err = refused(capsys, "cylinder.limits.speed=1mm/s", "approach=3 s")
    assert "cylinder.limits.speed: --set cylinder.limits.speed=1mm/s\n" in err
    assert re.search(r"experiment\.reference: \S+sine\.yaml:\d+:\d+\n", err), err


def test_several_options_of_one_key_are_all_named(capsys):
    first, second = "reference.amplitude=9mm", "reference.tones=[{frequency: 40 Hz, periods: 2}]"
    err = refused(capsys, first, second)
    assert f"experiment.reference: --set {first}, --set {second}; over " in err


def test_a_value_of_vary_is_named_as_it_was_written(capsys):
    words = ["compare", "cylinder-sine", "--on", "sim", "--vary", "reference.amplitude=201mm,202mm"]
    assert invoke(words) == 2
    err = capsys.readouterr().err
    assert "experiment.reference: --vary reference.amplitude=202mm; over " in err


def test_a_hint_offers_no_key_that_no_file_has(tmp_path, capsys):
    text = "extends: cylinder-sine\nreference: {offset: 1 mm}\n"
    _, err = said_of(tmp_path, text, capsys)
    assert "unknown key 'offset'" in err and "there are: amplitude, kind, tones" in err
