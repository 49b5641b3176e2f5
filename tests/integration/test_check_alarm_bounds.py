"""`rig check` shows the bounds that the run's watch is built with."""

import json
import random

import pytest

from rig.assembly import REGISTRY
from rig.assembly.build import make_unconnected
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.mechanisms.pneumatic.alarms.bounds import derive_bounds, expect_bounds


@pytest.mark.parametrize("rig", ["cylinder", "joint"])
@pytest.mark.parametrize("seed", range(4))
def test_check_shows_the_bounds_of_the_run(rig, seed, capsys):
    chance = random.Random(f"bounds {seed}")
    full = chance.uniform(510e3, 1000e3)
    profile = load_profile(rig, REGISTRY, (), find_configs(None))
    said = [
        f"devices.regulators.channels.{channel}.{line}.pressure=[0 Pa, {full} Pa]"
        for channel in profile.devices["regulators"].settings.channels
        for line in ("setpoint", "monitor")
    ]
    said.append(f"{rig}.limits.pressure=[0 Pa, {chance.uniform(300e3, 500e3)} Pa]")
    mechanism, _ = make_unconnected(load_profile(rig, REGISTRY, said, find_configs(None)))
    settings = mechanism.settings
    bounds = derive_bounds(settings.alarms.pressure, settings)
    options = [word for override in said for word in ("--set", override)]
    assert invoke(["check", rig, "--json", *options]) == 0
    shown = json.loads(capsys.readouterr().out)["profile"]["expected"]
    wanted = [bound._asdict() for bound in expect_bounds(bounds)]
    found = [entry for entry in shown if entry["name"].startswith("alarm: ")]
    assert [(e["name"], e["value"]) for e in found[: len(wanted)]] == [
        (e["name"], e["value"]) for e in wanted
    ]
    assert bounds.offset == pytest.approx(0.022 * full)
