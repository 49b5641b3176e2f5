"""The devices pass what every one of their kind must."""

from pathlib import Path

import crank_rig
from crank_rig.load_cell.device import LoadCell

from rig.testing.devices import DeviceSuite, PressureRegulatorSuite
from rig.testing.laws import LawSuite

CONFIGS = Path(crank_rig.__file__).parent / "configs"


class TestTecno(PressureRegulatorSuite):
    configs, rig, device = CONFIGS, "cylinder-tecno", "regulators"


class TestLoadCell(DeviceSuite[LoadCell]):
    configs, rig, device = CONFIGS, "crank", "rod-force"


class TestPi(LawSuite):
    configs, experiment = CONFIGS, "tecno-sine"
