"""Campaigns that take minutes to hours: every fault in turn, and ten thousand drawn ones."""

import json
import os

import pytest
from click.testing import CliRunner

from rig.cli.faults import FULL, RIGS, faults
from rig.faults.campaign import draw_each
from rig.faults.survey import experiments_of, survey

pytestmark = pytest.mark.slow
CASES = int(os.environ.get("FAULT_CASES", "10000"))
"""Of all rigs together; some 0.4 s of a processor each."""
SEED = 1_000


def test_a_full_campaign_is_large_enough():
    cases = [
        case
        for rig in RIGS
        for case in draw_each(survey(rig, experiments_of(rig, None), None), 0, FULL)
    ]
    assert len(cases) >= 1350
    assert {case.rig for case in cases} == set(RIGS)


@pytest.mark.lengthy
def test_nobody_is_hurt_by_ten_thousand_faults(tmp_path):
    each = -(-CASES // len(RIGS))
    command = ["run", "--random", str(each), "--seed", str(SEED), "--out", str(tmp_path)]
    result = CliRunner().invoke(faults, command, standalone_mode=False)
    content = json.loads((tmp_path / f"seed-{SEED}" / "campaign.json").read_text())
    cases = content["cases"]
    assert len(cases) >= CASES
    bad = [case["again"] for case in cases if case["hazard"] or case["crashed"]]
    assert not bad, "\n".join(bad)
    assert sum(case["misnamed"] for case in cases) <= 0.01 * len(cases)
    assert result.return_value == 0
