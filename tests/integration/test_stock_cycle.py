"""The benchmark of a cycle compares equal work: it is seen here before somebody measures."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).parents[1] / "benchmarks" / "test_cycle_cost.py"


@pytest.mark.slow
def test_the_stock_cycle_still_sets_what_ours_does():
    """Its law, its checks and its frames follow the profile's; the figure itself is not judged."""
    words = ["-m", "benchmark", "-n", "0", "-p", "no:cacheprovider", str(BENCHMARK)]
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", *words], capture_output=True, text=True, check=False
    )
    assert "stock, canopen's receiving thread" in ended.stdout, ended.stdout
    assert ended.returncode == 0 or "assert drained <= WANTED" in ended.stdout, ended.stdout
