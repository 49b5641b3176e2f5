"""What every device with proportional valves does: the driver on frames, and the plant alone."""

from pathlib import Path

import pytest

from rig.hal import DeviceFault, LimitExceeded
from rig.testing.devices import EmergencyStopSuite
from rig.testing.plants import PlantSuite
from rig.testing.valves import ProportionalValvesSuite


class TestValves(ProportionalValvesSuite, EmergencyStopSuite):
    configs, rig, device = Path("configs"), "cylinder-valves", "valves"

    @pytest.mark.parametrize("bad", [(1.5, 0.0), (0.0, float("nan"))])
    def test_an_opening_that_no_spool_has_is_refused(self, bench, bad):
        with pytest.raises(LimitExceeded, match="valves: setpoint of"):
            bench.device.set_opening(bad)

    def test_its_log_has_what_was_sent(self, bench):
        self.give(bench, (0.25, -0.5))
        names = [column.name for column in bench.device.log_columns]
        assert names == ["device.valves_opening_agonist", "device.valves_opening_antagonist"]
        assert bench.device.log_values() == (0.25, -0.5)

    def test_a_broken_sensor_names_its_channel(self, bench):
        bench.inject("wire_break", 1)
        with pytest.raises(DeviceFault, match=r"valves.*antagonist.*broken wire"):
            bench.run(10)


class TestPlant(PlantSuite):
    configs, experiment = Path("configs"), "cylinder-valves-sine"
