"""Walks of many samples: what they take of memory, and that pieces of them are no other numbers."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from controllers.gait import pieces
from controllers.gait.correction_settings import SagSettings
from controllers.gait.laws import InverseLaw, NoSettings
from controllers.gait.motions import WalkSettings
from controllers.gait.sag import standing_torques
from controllers.gait.types import GaitModel
from rig.mechanisms.legs.facts import plan_facts

PERIOD = 5e-3


def plan(speed, period=PERIOD):
    law = InverseLaw(NoSettings(), GaitModel(sag=SagSettings()), period)
    law.longest = 1800.0
    return law.prepare(WalkSettings(speed=speed, knee_min=0.3))


MEASURED = """
from pathlib import Path
from test_gait_long import plan, plan_facts

def peak(speed):
    made = plan(speed)
    plan_facts(made, made, 0.0)
    # `getrusage` also knows what the process took that began this one.
    said = Path("/proc/self/status").read_text().partition("VmHWM:")[2]
    return len(made.t), 1024 * int(said.split()[0])

short, before = peak(2.0)
long, after = peak(48.0 / 500.0)
print((after - before) / (long - short))
"""


def test_a_slow_walk_takes_a_kilobyte_of_memory_per_sample():
    """Places of all links at all instants at once were three."""
    found = subprocess.run(
        [sys.executable, "-c", MEASURED], cwd=Path(__file__).parent, capture_output=True, check=True
    )
    assert 100.0 < float(found.stdout) < 1500.0


def test_a_plan_in_pieces_has_the_same_numbers(monkeypatch):
    whole = plan(3.0)
    torques, facts = standing_torques(whole), plan_facts(whole, whole, 0.0)
    off, apart = whole.odometry(), whole.mismatch(1e-4)
    monkeypatch.setattr(pieces, "_AT_ONCE", 97)
    made = plan(3.0)
    for ours, theirs in zip(made.balance, whole.balance, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(made.q, whole.q)
    np.testing.assert_array_equal(made.odometry(), off)
    np.testing.assert_allclose(standing_torques(made), torques, rtol=0.0, atol=1e-12)
    assert made.mismatch(1e-4) == apart
    for name, fact in plan_facts(made, made, 0.0).items():
        assert fact.value == pytest.approx(facts[name].value, rel=1e-12, abs=1e-15), name
