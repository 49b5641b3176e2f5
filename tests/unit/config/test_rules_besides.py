"""Beside a value that cannot be read only those rules are told that are broken whatever it was."""

import random

import pytest

from rig.assembly import REGISTRY
from rig.config import ProfileError, load_profile
from rig.config.names import find_configs
from rig.config.yaml_loader import read_plain


def messages(tmp_path, channel):
    """Return what is told of a cylinder one of whose setpoints is as it is given."""
    path = tmp_path / "mine.yaml"
    path.write_text(
        "extends: cylinder\n"
        f"devices: {{regulators: {{channels: {{agonist: {{setpoint: {channel}}}}}}}}}\n"
    )
    with pytest.raises(ProfileError) as caught:
        load_profile(path, REGISTRY, (), find_configs())
    return [d.message for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("channel", "told"),
    [
        ("{voltage: [0 mA, 20 mA]}", ["voltage.0: '0 mA' is not in V", "voltage.1: '20 mA'"]),
        ("{voltage: null, current: [0 V, 9 V]}", ["current.0: '0 V'", "current.1: '9 V'"]),
        ("{voltage: null, curent: [4 mA, 20 mA]}", ["unknown key 'curent'"]),
        ("{voltage: null, voltge: [0 V, 10 V]}", ["unknown key 'voltge'"]),
    ],
)
def test_a_signal_that_cannot_be_read_is_no_missing_one(tmp_path, channel, told):
    said = messages(tmp_path, channel)
    assert len(said) == len(told), said
    assert all(any(words in one for one in said) for words in told), said


@pytest.mark.parametrize(
    ("channel", "told"),
    [
        ("{voltage: null, signal: [0 V, 10 V]}", "unknown key 'signal'"),
        ("{current: [4 mA, 20 mA], sub: x}", "sub is 'x'"),
        ("{current: [4 mA, 20 mA], shoe: 43}", "unknown key 'shoe'"),
    ],
)
def test_a_signal_that_is_missing_or_there_twice_is_told_beside(tmp_path, channel, told):
    said = messages(tmp_path, channel)
    assert len(said) == 2, said
    assert any("give either voltage or current" in one for one in said)
    assert any(told in one for one in said), said


def test_no_rule_is_told_of_a_mapping_that_was_made_up(tmp_path):
    """Both ends are refused and mended; the rule that the mended ones break is nobody's error."""
    said = messages(tmp_path, "{raw: [x, y], pressure: [a, b]}")
    assert len(said) == 4, said
    assert all(" is '" in one or " not " in one or "expected" in one for one in said), said


def keys_of(rig):
    """Return the dotted keys of a shipped profile's values."""

    def walk(section, above):
        for key, value in section.items():
            path = (*above, str(key))
            if isinstance(value, dict):
                yield from walk(value, path)
            else:
                yield ".".join(path)

    sections = read_plain(find_configs()[-1] / "rigs" / f"{rig}.yaml")
    return [key for key in walk(sections, ()) if "." in key]


@pytest.mark.parametrize("rig", ["cylinder", "cylinder-valves", "joint", "arm", "legs"])
def test_one_value_that_cannot_be_read_is_one_error(rig):
    """Whatever stands in its place meanwhile must not be blamed on the rest of the file."""
    chance = random.Random(rig)
    keys = keys_of(rig)
    drawn = chance.sample(keys, min(len(keys), 25))
    for key in {*drawn, "cylinder.bore"} if rig == "cylinder" else drawn:
        with pytest.raises(ProfileError) as caught:
            load_profile(rig, REGISTRY, (f"{key}={{wide: 1}}",), find_configs())
        said = [d.message for d in caught.value.diagnostics]
        assert len(said) == 1, (key, said)
