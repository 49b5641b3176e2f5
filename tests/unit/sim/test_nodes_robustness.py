"""Emulated nodes under random frames, and modules that are wired differently."""

import random

import pytest
from emulated_rig import AGONIST, REGULATORS, SETPOINT, Bench, FakePlant

from drivers.sim.nodes.analogue import AnalogueScale
from drivers.sim.nodes.cia401 import AnalogueArray, EmulatedCia401, ModuleBuild, RegulatorWiring
from drivers.sim.nodes.cia406 import EmulatedCia406
from drivers.sim.nodes.object_dictionary import UNSIGNED16


def random_run(seed, count=4000):
    """Send frames of all kinds, mostly of services that the nodes offer."""
    generator = random.Random(seed)
    bench = Bench()
    bench.run()
    indices = [variable.index for variable in bench.regulators.dictionary]
    frames = []
    for _ in range(count):
        kind = generator.random()
        data = generator.randbytes(generator.randrange(9))
        if kind < 0.1:
            can_id, data = 0, bytes((generator.choice((1, 2, 0x80, 0x81, 0x82, 7)), 0x10))
        elif kind < 0.8:
            can_id = 0x600 + generator.choice((REGULATORS, AGONIST))
            index = generator.choice(indices)
            command = generator.choice((0x40, 0x2F, 0x2B, 0x23, 0x21, 0x60, 0x00, 0x13, 0x80))
            data = bytes((command, index & 255, index >> 8, generator.randrange(6)))
            data += generator.randbytes(4)
        else:
            can_id = generator.choice((0x080, 0x210, 0x310, 0x77F, generator.randrange(0x800)))
        frames += bench.ask(f"{can_id:03X}#{data.hex()}")
    return frames


@pytest.mark.parametrize("seed", [1, 2])
def test_no_frame_breaks_a_node_and_the_same_frames_give_the_same_answers(seed):
    frames = random_run(seed)
    assert len(frames) > 1000
    assert frames == random_run(seed)


def test_objects_of_a_maker_and_a_current_loop():
    plant = FakePlant()
    loop = AnalogueScale(raw=(0, 0xFFFF), electrical=(0.004, 0.020), pressure=(0.0, 500e3))
    module = EmulatedCia401(
        "coupler",
        5,
        plant,
        [RegulatorWiring(3, 1, loop, loop)],
        ModuleBuild(
            AnalogueArray(0x2401, data_type=UNSIGNED16),
            AnalogueArray(0x2301, data_type=UNSIGNED16),
            supply_bit=None,
            stop_bit=5,
            stop_active_low=False,
        ),
    )
    assert plant.supply is True  # no valve is wired, so the supply is always on
    module.tick(0.0)
    module.dictionary.write(0x2401, 3, b"\x00\x80")
    assert plant.setpoints[0] == pytest.approx(0x8000 / 0xFFFF * 500e3)
    assert module.dictionary.read(0x2301, 1) == b"\x00\x80"
    assert module.dictionary.read(0x6000, 1) == b"\x00"
    module.inject("emergency_stop")
    assert module.dictionary.read(0x6000, 1) == b"\x20"
    module.inject("wire_break")
    assert module.dictionary.read(0x2301, 1) == b"\x00\x00"  # saturated: no counts below 4 mA


def test_a_regulator_ends_at_the_ends_of_its_range():
    assert SETPOINT.pressure_from_electrical(SETPOINT.electrical_from_raw(-5000)) == 0.0
    assert SETPOINT.pressure_from_electrical(12.0) == 900e3
    assert SETPOINT.raw_from_electrical(100.0, -0x8000, 0x7FFF) == 0x7FFF


def test_node_numbers_and_names_are_unique_on_a_bus():
    from drivers.sim.emulated_bus import EmulatedBus

    plant = FakePlant()
    nodes = [EmulatedCia406("encoder", 5, plant, 0), EmulatedCia406("other", 5, plant, 1)]
    with pytest.raises(ValueError, match="bus can0: two nodes have the same node_id"):
        EmulatedBus("can0", None, nodes)
    with pytest.raises(ValueError, match=r"node 128 is outside 1 … 127"):
        EmulatedCia406("encoder", 128, plant, 0)
