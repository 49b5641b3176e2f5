"""How often the stated 95 % intervals of a calibration hold what is true of the simulated rig.

`pytest -m benchmark -s -n 0 tests/benchmarks/test_calibration_coverage.py`; CALIBRATIONS in the
environment sets how many of each procedure (200), CALIBRATIONS_IN a folder that keeps what is
finished, so that the same command goes on there. They run as points of a sweep.
"""

import os
from pathlib import Path

import pytest
from calibration_points import calibrate_each
from calibration_truth import DRAWN, calibrate, covered, normalised

CALIBRATIONS = int(os.environ.get("CALIBRATIONS", "200"))
MORE = {"cylinder-locked leak": 1.5, "friction": 1.25}
"""So many times as many where few quantities are counted, or err together: chance is larger."""


@pytest.mark.benchmark
@pytest.mark.parametrize("procedure", DRAWN)
def test_coverage(procedure, tmp_path, table):
    seeds = range(3000, 3000 + int(CALIBRATIONS * MORE.get(procedure, 1.0)))
    folder = Path(os.environ.get("CALIBRATIONS_IN", tmp_path)) / procedure.replace(" ", "-")
    rows = calibrate_each(procedure, seeds, folder, os.cpu_count())
    held, errors = covered(rows), normalised(rows)
    for name, (inside, count) in held.items():
        spread = errors[name]
        table(
            what=name, held=inside / count, of=count,
            bias=float(spread.mean()), spread=float(spread.std()),
        )  # fmt: skip
    inside, count = (sum(values) for values in zip(*held.values(), strict=True))
    table(what=f"{procedure}: all", held=inside / count, of=count)
    assert 0.93 <= inside / count <= 0.97


@pytest.mark.slow
@pytest.mark.parametrize(
    ("procedure", "calibrations"),
    [("regulators", 8), ("encoders", 8), ("joint lens", 8), ("joint camera", 8),
     ("joint geometry", 4), ("friction", 4), ("joint friction", 2), ("cylinder-locked leak", 4),
     ("joint-ideal-low-speed friction", 2), ("joint-low-speed friction", 2)],
)  # fmt: skip
def test_coverage_of_a_few(procedure, calibrations, tmp_path):
    rows = [row for seed in range(calibrations) for row in calibrate(procedure, seed, tmp_path)]
    inside, count = (sum(values) for values in zip(*covered(rows).values(), strict=True))
    # Quantities of one calibration err together: the binomial bound would be too narrow.
    assert inside / count >= 0.85


@pytest.mark.slow
def test_a_calibration_in_another_process_says_the_same(tmp_path):
    here = [row for seed in (1, 2) for row in calibrate("encoders", seed, tmp_path / "here")]
    there = calibrate_each("encoders", (1, 2), tmp_path / "there", 2)
    assert [name for name, _, _ in there] == [name for name, _, _ in here]
    for (_, mine, my_truth), (_, other, other_truth) in zip(here, there, strict=True):
        assert (mine.value, mine.low, mine.high, mine.std) == (
            other.value, other.low, other.high, other.std
        )  # fmt: skip
        assert my_truth == other_truth
