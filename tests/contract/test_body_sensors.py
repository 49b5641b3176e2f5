"""Load cells and inertial sensors: what each capability promises, on a bus and without one."""

import math
from pathlib import Path

import pytest

from drivers.sim.plants.legs import LegsPlant
from rig.hal import DeviceFault, InertialSensor, LoadCells, Reading
from rig.testing.bench import ProfileBench
from rig.testing.devices import DeviceSuite

CONFIGS = Path(__file__).parents[2] / "configs"
WEIGHT = 6.0 * 9.81


class BodySensors(DeviceSuite):
    configs, rig = CONFIGS, "legs-balance"

    def plant(self, bench):
        world = bench.clock.world
        return world if isinstance(world, LegsPlant) else world.plant

    def test_a_frozen_reading_is_a_fault_of_its_device(self, bench):
        self.plant(bench).inject(f"{self.device}_frozen")
        with pytest.raises(DeviceFault, match=f"{self.device}: its readings are frozen"):
            bench.run(60)


class TestLoadCells(BodySensors):
    device, capability = "feet", LoadCells

    def read_at(self, device):
        return device.forces().t

    def test_both_feet_bear_the_weight_in_shares_of_one_cell_each(self, bench):
        bench.run(100)
        forces = bench.device.forces()
        assert isinstance(forces, Reading)
        assert [type(force) for force in forces.value] == [float] * 8
        # Each cell is off by half a newton at most, and noisy.
        assert sum(forces.value) == pytest.approx(WEIGHT, abs=0.05 * WEIGHT + 6.0)
        assert sum(forces.value[:4]) == pytest.approx(0.5 * WEIGHT, abs=8.0)

    def test_a_single_frozen_cell_is_named(self, bench):
        self.plant(bench).inject("left_back_left.cell_frozen")
        with pytest.raises(DeviceFault, match="feet: frozen: no count has changed of left_back_l"):
            bench.run(60)

    def test_scale_of_one_cell_shows(self, bench):
        bench.run(60)
        before = bench.device.forces().value
        self.plant(bench).inject("right_back_left.cell_scale", 0.5)
        bench.run(10)
        after = bench.device.forces().value
        assert before[2] > 4.0
        assert after[2] == pytest.approx(0.5 * before[2], abs=2.0)
        assert after[3] == pytest.approx(before[3], abs=2.0)

    def test_offset_and_dead_cell_show(self, bench):
        bench.run(60)
        before = bench.device.forces().value
        self.plant(bench).inject("feet_offset", 20.0)
        bench.run(10)
        after = bench.device.forces().value
        assert [b - a for a, b in zip(before, after, strict=True)] == pytest.approx(
            [20.0] * 8, abs=3.0
        )
        self.plant(bench).inject("feet_offset", -20.0)
        self.plant(bench).inject("cell_dead", 5.0)
        bench.run(10)
        assert abs(bench.device.forces().value[5]) < 2.0


class TestInertialSensor(BodySensors):
    device, capability = "waist", InertialSensor

    def read_at(self, device):
        return device.lean().t

    def test_an_upright_waist_shows_no_lean_and_no_rate(self, bench):
        bench.run(100)
        device = bench.device
        for reading in (device.lean(), device.turning()):
            assert [type(value) for value in reading.value] == [float] * 2
        assert max(map(abs, device.lean().value)) < math.radians(1.0)
        assert max(map(abs, device.turning().value)) < math.radians(3.0)

    def test_offsets_show(self, bench):
        bench.run(100)
        self.plant(bench).inject("waist_offset", 0.1)
        self.plant(bench).inject("gyro_offset", 0.2)
        bench.run(10)
        assert bench.device.lean().value == pytest.approx((0.1, 0.1), abs=0.02)
        assert bench.device.turning().value == pytest.approx((0.2, 0.2), abs=0.06)


@pytest.mark.parametrize("backend", ["virtual"])
def test_ground_that_falls_ahead_is_a_pitch(backend, tmp_path):
    """The sign by the plant: a robot on it leans ahead, and its toes bear more."""
    (tmp_path / "rigs").mkdir()
    for name in ("legs", "legs-balance", "legs-slope"):
        (tmp_path / "rigs" / f"{name}.yaml").write_text((CONFIGS / f"rigs/{name}.yaml").read_text())
    made = {}
    for device in ("waist", "feet"):
        bench = ProfileBench(tmp_path, "legs-slope", device, backend)
        bench.start()
        bench.run(100)
        made[device] = bench.device
    assert made["waist"].lean().value == pytest.approx((0.0, math.radians(3.0)), abs=0.02)
    forces = made["feet"].forces().value
    toes = forces[0] + forces[1] + forces[4] + forces[5]
    assert toes > 0.55 * sum(forces)  # of level ground 0.47
