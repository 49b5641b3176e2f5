"""Where the gains of shipped profiles come from is said of each: it is wanted of `rig tune`."""

import re
from pathlib import Path

import pytest

from rig.assembly import REGISTRY
from rig.config import find_configs, load_profile

PAGE = Path(__file__).parents[3] / ".readme" / "figures.md"
REALISTIC = ("cylinder", "cylinder-low-speed", "cylinder-valves", "joint", "joint-low-speed",
             "joint-valves")  # fmt: skip


def told():
    """Return what the page says of each profile's law; `all` stands for every profile."""
    table = PAGE.read_text(encoding="utf-8").partition("### Where the gains come from")[2]
    rows = re.findall(
        r"^\| (all|`[a-z-]+`) \| (.+?) \| (.+) \|$", table.partition("\n## ")[0], re.M
    )
    return {
        (rig.strip("`"), law): said
        for rig, laws, said in rows
        for law in re.findall(r"`(.+?)`", laws)
    }


@pytest.mark.parametrize("rig", REALISTIC)
def test_of_every_law_of_a_shipped_profile_it_is_said_where_its_gains_come_from(rig):
    profile = load_profile(rig, REGISTRY, ("calibration=false",), find_configs())
    known = told()
    assert all((rig, law) in known or ("all", law) in known for law in profile.controllers)


@pytest.mark.parametrize(("rig", "law"), [key for key in told() if key[0] != "all"])
def test_what_was_tried_is_a_command_of_that_profile(rig, law):
    said = told()[rig, law]
    assert law in load_profile(rig, REGISTRY, ("calibration=false",), find_configs()).controllers
    commands = re.findall(r"`rig tune ([a-z-]+)(?: --controller [a-z-]+)? --generations \d+`", said)
    assert rig in commands
    file = (find_configs()[-1] / "rigs" / f"{rig}.yaml").read_text(encoding="utf-8")
    assert "rig tune" in file
