"""What a report takes of memory, with the processes that draw, over the length of a run."""

import sys
from pathlib import Path

import pytest
import scale

import rig

pytestmark = pytest.mark.benchmark
SHORT, LONG = 5, 60
"""Minutes at 1 kHz, 100 MB and 1.2 GB of log: both are too long for the memory."""


def test_an_hour_takes_little_more_memory_than_five_minutes(tmp_path):
    run = rig.run("cylinder-sine", on="sim", report=False, out=tmp_path / "runs")
    most = {}
    for minutes in (SHORT, LONG):
        folder = scale.lengthen(Path(run.path), tmp_path / f"of-{minutes}", minutes)
        code = scale.ONE.format(work=scale.WORKS["report"])
        said, complaint, most[minutes] = scale.most_memory([sys.executable, "-c", code, folder])
        assert said, complaint
    assert most[LONG] < 1.2 * most[SHORT], f"{most} MB"
