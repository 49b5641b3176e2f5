"""A tube that comes off while all chambers are given the same pressures, and nothing controls."""

import json

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from rig.cli.faults import faults

pytestmark = [pytest.mark.slow, pytest.mark.sampled(2)]
CHANNELS = {
    "joint": ("ch1", "ch2", "ch3", "ch4"),
    "cylinder": ("agonist", "antagonist"),
}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("rig", CHANNELS)
def test_a_rig_that_is_meant_to_stand_is_stopped_where_it_still_is(tmp_path, rig, seed):
    """It is judged by the plant's truth; the ring fell to its end at once."""
    rng = np.random.default_rng((0x1EA4, seed))
    scenario = {
        "rig": rig,
        "experiment": str(rng.choice(["regulators", "response"])),
        "fault": "leak",
        "where": f"plant {rng.choice(CHANNELS[rig])}",
        "magnitude": float(np.exp(rng.uniform(*np.log((0.8e-8, 5e-8))))),
        "when": {"phase": "calibration", "after": f"{rng.uniform(1.0, 6.0):.4f} s"},
        "seed": int(rng.integers(10_000)),
    }
    file = tmp_path / "leak.yaml"
    file.write_text(yaml.safe_dump(scenario))
    command = ["run", str(file), "--out", str(tmp_path / "out"), "--json", "--workers", "1"]
    CliRunner().invoke(faults, command, standalone_mode=False)
    (campaign,) = (tmp_path / "out").glob("*/campaign.json")
    (case,) = json.loads(campaign.read_text())["cases"]
    assert not case["wrongs"], scenario
