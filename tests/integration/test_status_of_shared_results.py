"""`rig status` of procedures that find the same: what one found anew is not to be found again."""

import json
import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from rig.assembly import REGISTRY
from rig.calibration import store
from rig.calibration.catalogue import procedures
from rig.cli import invoke
from rig.config import find_configs, load_profile

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture
def configs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(CONFIGS, tmp_path / "configs", ignore=shutil.ignore_patterns("calibration"))
    return tmp_path / "configs"


def states(configs, capsys, rig, name):
    """Return what the screen says of each procedure once one has written all of its files."""
    now = datetime.now(UTC)
    facts = {
        "procedure": name, "backend": "hardware", "date": now.isoformat(timespec="seconds"),
        "valid_until": (now + timedelta(days=9)).date().isoformat(),
    }  # fmt: skip
    entry = {"name": "offset", "value": 1.0, "unit": "1", "std": 0.1, "interval": [0.8, 1.2]}
    profile = load_profile(rig, REGISTRY, (), find_configs(configs))
    for target in procedures(profile)[name].targets(profile):
        provenance = facts | {"operator": "nobody"}
        content = {"values": {}, "measured": [entry | facts], "provenance": provenance}
        store.write(configs, rig, target, content)
    assert invoke(["status", rig, "--configs", str(configs), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["stages"]
    return {stage["what"].removeprefix("calibrated: "): stage["state"] for stage in shown}


@pytest.mark.parametrize(
    ("rig", "last", "before"),
    [("joint", "geometry", "camera"), ("arm", "links", "zeros"), ("legs", "scale", "zeros")],
)
def test_what_a_later_procedure_found_anew_is_calibrated(configs, capsys, rig, last, before):
    found = states(configs, capsys, rig, last)
    assert ", on hardware, until " in found[last]
    assert found[before] == found[last]


@pytest.mark.parametrize(
    ("rig", "before", "last"),
    [("joint", "camera", "geometry"), ("arm", "zeros", "links"), ("legs", "zeros", "scale")],
)
def test_what_the_earlier_one_cannot_find_is_still_missing(configs, capsys, rig, before, last):
    found = states(configs, capsys, rig, before)
    assert ", on hardware, until " in found[before]
    assert found[last].startswith("no (")
