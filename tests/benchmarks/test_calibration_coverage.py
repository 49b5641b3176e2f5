"""How often the stated 95 % intervals of a calibration hold what is true of the simulated rig.

`pytest -m benchmark -s -n 0 tests/benchmarks/test_calibration_coverage.py`; CALIBRATIONS in the
environment sets how many of each procedure (200).
"""

import os

import pytest
from calibration_truth import DRAWN, calibrate, covered, normalised

CALIBRATIONS = int(os.environ.get("CALIBRATIONS", "200"))
MORE = {"cylinder-locked leak": 1.5, "friction": 1.25}
"""So many times as many where few quantities are counted, or err together: chance is larger."""


@pytest.mark.benchmark
@pytest.mark.parametrize("procedure", DRAWN)
def test_coverage(procedure, tmp_path, table):
    seeds = range(3000, 3000 + int(CALIBRATIONS * MORE.get(procedure, 1.0)))
    rows = [row for seed in seeds for row in calibrate(procedure, seed, tmp_path)]
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
     ("joint geometry", 4), ("friction", 4), ("joint friction", 2), ("cylinder-locked leak", 4)],
)  # fmt: skip
def test_coverage_of_a_few(procedure, calibrations, tmp_path):
    rows = [row for seed in range(calibrations) for row in calibrate(procedure, seed, tmp_path)]
    inside, count = (sum(values) for values in zip(*covered(rows).values(), strict=True))
    # Quantities of one calibration err together: the binomial bound would be too narrow.
    assert inside / count >= 0.85
