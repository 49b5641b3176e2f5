"""Twists that are heard are measured as a plan of the same twists says beforehand."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import rig
from rig.mechanisms.arm.references import ArmTwists

CONFIGS = Path(__file__).parents[2] / "configs"
START = (0.0, -0.35, 1.75, 0.0, 0.52, 0.0)
ROWS = (
    (0.0, -0.1, 0.0, 0.0, 0.0, 0.0, 0.1),
    (1.5, 0.15, 0.03, 0.02, 0.0, 0.0, 0.0),  # out, to the boundary
    (7.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
)


class Rows(ArmTwists):
    """Says what the file of the other run says, and may go as fast."""

    def twist(self, t):
        return next(row[1:] for row in reversed(ROWS) if row[0] <= t + 1e-9)


@pytest.fixture(scope="module", params=["esc", "dls"])
def runs(request, tmp_path_factory):
    """Return the run whose twists were known, and the one that heard them."""
    folder = tmp_path_factory.mktemp("twists")
    common = {"controller": request.param, "on": "sim", "out": folder, "configs": CONFIGS}
    known = rig.run(
        "arm-twist",
        set={"reference.rows": [list(row) for row in ROWS], "reference.start": list(START)},
        **common,
    )
    return known, rig.run(
        "arm-twist", reference=Rows(start=START, duration=8.0, rest=1.0), **common
    )


def test_measures_of_what_was_heard_are_those_of_the_plan(runs):
    known, heard = runs
    for name in ("lag", "standing_share", "distance_share", "closest_wrist", "closest_elbow"):
        planned, measured = known.metrics[name].value, heard.metrics[name].value
        assert measured == pytest.approx(planned, rel=0.02, abs=0.011), name


def test_they_are_compared_and_drawn(runs):
    compared = rig.compare({"known": runs[0], "heard": runs[1]})
    rows = {row["name"]: row["values"] for row in compared.rows}
    assert rows["standing_share"][1] is not None
    assert all(any(value is not None for value in values) for values in rows.values())
    assert len(compared.figure().axes) > 2


def test_no_line_of_the_hand_begins_where_the_arm_stands_fixed(runs):
    _, heard = runs
    run = heard.data["phase"] == 1.0
    hand = np.column_stack([heard.data[f"reference.hand_{axis}"][run] for axis in "xyz"])
    assert np.linalg.norm(hand, axis=1).min() > 0.1


def test_check_says_from_when_on_a_hand_stands_and_why(runs):
    known, _ = runs
    remarks = json.loads((known.path / "evaluation.json").read_text())["remarks"]
    said = [note["message"] for note in remarks if note["kind"] == "stands"]
    share = known.metrics["standing_share"].value
    if not share:  # dls creeps on, beside its direction
        assert not said
        return
    (said,) = said
    told = re.match(r"from (\S+) s to (\S+) s, though .*: the hand is at the boundary", said)
    assert float(told[2]) - float(told[1]) == pytest.approx(share * ROWS[-1][0], rel=0.02)
