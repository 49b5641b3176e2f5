"""Every mutant of the safety core, some minutes on two cores."""

import subprocess
import sys

import pytest
from safety_core import ROOT


@pytest.mark.slow
def test_no_mutant_survives():
    done = subprocess.run(
        [sys.executable, "tests/mutation"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-3000:]
