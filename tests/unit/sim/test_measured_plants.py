"""A sensor whose driver brings no simulation measures what the plant has at its channel."""

from types import SimpleNamespace

import pytest

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.mapping import Entry
from drivers.sim.described_wiring import simulate_described
from rig.assembly import REGISTRY
from rig.assembly.simulated import make_plant
from rig.config import load_profile
from rig.config.names import find_configs
from rig.hal import MeasuredPlant

INPUT = Entry(0x6401, 1, "i16")


def sensor_on(plant, channel):
    """Return a sensor of newtons on a plant's channel, simulated by what it says of its frames."""
    node = DescribedNode("cell", 0x30, (), ((INPUT,),), True, {INPUT: Quantity("value", "N", 0.01)})
    settings = SimpleNamespace(describe_nodes=lambda name: (node,))
    channels = (plant.channel_names.index(channel),)
    of = SimpleNamespace(name="cell", plant=plant, channels=channels, settings=settings)
    return simulate_described(of, SimpleNamespace(now=lambda: 0.0))


@pytest.mark.parametrize("rig", ["cylinder", "cylinder-valves", "joint-ideal"])
def test_a_sensor_on_a_wire_shows_its_tension(rig):
    profile = load_profile(rig, REGISTRY, (), find_configs())
    plant = make_plant(profile)
    assert isinstance(plant, MeasuredPlant)
    sensor = sensor_on(plant, plant.channel_names[0])
    plant.advance(0.1)
    sensor.arm()
    (shown,) = sensor.log_values()
    assert shown == pytest.approx(plant.channel_value(0)) and shown != 0.0


def test_a_sensor_in_a_foot_shows_what_the_legs_have_there():
    profile = load_profile("legs-balance", REGISTRY, (), find_configs())
    plant = make_plant(profile)
    channel = next(name for name in plant.channel_names if name.endswith("front_left"))
    sensor = sensor_on(plant, channel)
    plant.advance(0.5)
    sensor.arm()
    (shown,) = sensor.log_values()
    assert shown == pytest.approx(plant.channel_value(plant.channel_names.index(channel)))
    assert shown != 0.0
