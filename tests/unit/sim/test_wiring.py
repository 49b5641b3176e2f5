"""What a start costs: the simulation of one driver does not import that of another."""

import subprocess
import sys

import pytest

from rig.assembly.offered import DRIVERS
from rig.assembly.registry import REGISTRY

PACKAGES = {
    "cia401", "cia402", "cia406", "cia410", "dynamixel", "load_cells", "marker_camera", "odrive",
}  # fmt: skip
SHARED = {"cia401-valves": {"cia401"}}
"""A module of CiA 401 carries valves as well."""


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_drivers_wiring_imports_no_other_driver(driver):
    module = REGISTRY.driver(driver).simulation.partition(":")[0]
    program = f"import sys; sys.path[:] = {[*sys.path]!r}; import {module}; print(*sys.modules)"
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.split()
    drivers = {name.split(".")[1] for name in found if name.startswith("drivers.")}
    assert drivers & PACKAGES == SHARED.get(driver, {driver.replace("-", "_")})
