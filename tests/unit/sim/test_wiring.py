"""What a start costs: the simulation of one driver does not import that of another."""

import subprocess
import sys

import pytest

from rig.assembly.offered import DRIVERS
from rig.assembly.registry import REGISTRY

PACKAGES = {"cia401", "cia402", "cia406", "odrive", "dynamixel", "marker_camera"}


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_drivers_wiring_imports_no_other_driver(driver):
    module = REGISTRY.driver(driver).simulation.partition(":")[0]
    program = f"import sys; sys.path[:] = {[*sys.path]!r}; import {module}; print(*sys.modules)"
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.split()
    drivers = {name.split(".")[1] for name in found if name.startswith("drivers.")}
    assert drivers & PACKAGES == {driver.replace("-", "_")}
