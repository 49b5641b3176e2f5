"""Whether each drive has torque: what a campaign of faults keeps beside a plant's truth."""

import random

import pytest

from rig.assembly import REGISTRY
from rig.assembly.simulated import make_plant
from rig.config import load_profile
from rig.config.names import find_configs
from rig.faults.kept_case import describe_truth
from rig.hal import Column

CONFIGS = find_configs(None)


def plant_of(rig):
    return make_plant(load_profile(rig, REGISTRY, (), CONFIGS))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("rig", ["arm", "legs"])
def test_a_drive_has_torque_when_it_was_told_so(rig, seed):
    plant = plant_of(rig)
    axes = plant.channel_names[: {"arm": 6, "legs": 12}[rig]]  # behind them are sensors
    assert plant.powered() == dict.fromkeys(axes, False)
    chance = random.Random(f"{rig} {seed}")
    for _ in range(3):
        on = {axis: chance.random() < 0.5 for axis in axes}
        for channel, axis in enumerate(axes):
            plant.command_joint(channel, plant.joint_position(channel), 0.0, on[axis])
        plant.advance(0.01)
        assert plant.powered() == on


@pytest.mark.parametrize("rig", ["cylinder", "joint"])
def test_what_no_drive_moves_has_none(rig):
    assert plant_of(rig).powered() == {}


def test_each_column_beside_the_truth_is_described():
    logged = [Column("truth.q1", "rad", "true value"), Column("truth.q1_velocity", "rad/s", "x")]
    columns = describe_truth(logged, {"q1": True})
    assert [column.name for column in columns] == ["q1", "q1_velocity", "powered_q1"]
    assert [column.unit for column in columns] == ["rad", "rad/s", "1"]
    assert columns[-1].description == "1 while the drive has torque"
