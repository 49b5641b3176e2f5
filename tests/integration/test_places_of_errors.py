"""An error that holds one part of a file against another says where both stand."""

import re

import pytest

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
              "null takes back what a base gives"]),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_both_ends_are_named(case, tmp_path, capsys):
    more, expected = CASES[case]
    path, err = said_of(tmp_path, f"extends: cylinder\n{more}", capsys)
    for pattern in expected:
        assert re.search(pattern.replace("{}", re.escape(str(path))), err), err


def test_null_takes_back_what_a_base_gives(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(f"extends: cylinder\n{CASES['wire'][0]}          voltage: null\n")
    profile = load_profile(path, REGISTRY, (), find_configs())
    check_profile(profile)
    monitor = profile.devices["regulators"].settings.channels["agonist"].monitor
    assert monitor.voltage is None and monitor.current == (4e-3, 20e-3)


def test_no_more_places_are_told_than_help(tmp_path, capsys):
    _, err = said_of(tmp_path, "extends: cylinder\ncylinder:\n  regulators: nobody\n", capsys)
    assert err.count("\n    ") <= 6
