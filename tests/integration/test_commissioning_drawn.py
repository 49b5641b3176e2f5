"""The first motion of healthy rigs that differ from the shipped one, and of slow regulators."""

import random

import pytest
from drawn_rigs import drawn_pair
from planted import (
    PLANTED,
    encoders_swapped,
    leaking_fitting,
    monitor_scale,
    monitors_swapped,
    no_dump_valve,
    setpoints_swapped,
    supply_stays_open,
    tubes_swapped,
    watchdog_off,
    with_port,
)
from test_commissioning import ENOUGH, find, perform, unit

from rig.assembly import REGISTRY
from rig.commissioning.session import steps_of
from rig.config import find_configs, load_profile


def first_motion(tmp_path, profile):
    skip = [step.name for step in steps_of(profile) if step.name != "first-motion"]
    return perform(tmp_path, profile, skip=skip)[0]


LONG = (
    "cylinder.stroke=80 mm", "cylinder.home=40 mm", "plant.cylinder.stroke=80 mm",
    "plant.home=40 mm", "devices.encoder-agonist.stroke=80 mm",
    "devices.encoder-antagonist.stroke=80 mm",
)  # fmt: skip


@pytest.mark.parametrize("said", [("loop.rate=500",), LONG], ids=["500 Hz", "80 mm"])
def test_another_rate_or_stroke_is_no_slow_regulator(tmp_path, said):
    profile = load_profile("cylinder", REGISTRY, said, find_configs(None))
    assert first_motion(tmp_path, profile) is None


def test_a_rig_whose_calibrated_regulators_have_no_0_pa_passes_again(tmp_path):
    said = [
        f"devices.regulators.channels.{channel}.setpoint.pressure=[{low} kPa, {low + 500} kPa]"
        for channel, low in (("agonist", 4.8), ("antagonist", -3.1))
    ]
    profile = load_profile("cylinder", REGISTRY, said, find_configs(None))
    skip = [step.name for step in steps_of(profile) if step.name != "actuators"]
    assert perform(tmp_path, profile, skip=skip)[0] is None


def test_a_drawn_rig_passes_every_step(tmp_path):
    profile = drawn_pair(2)
    stopped, record, _ = perform(tmp_path, profile)
    assert stopped is None
    assert set(record["steps"]) == {step.name for step in steps_of(profile)}


@pytest.mark.parametrize("seed", [1002, 1008])
def test_a_regulator_of_less_than_half_the_bandwidth_is_refused(tmp_path, seed):
    stopped = first_motion(tmp_path, drawn_pair(seed, slower=2.2))
    assert stopped is not None
    assert "regulator" in stopped


@pytest.mark.slow
@pytest.mark.sampled(8)
@pytest.mark.parametrize("seed", range(40))
def test_drawn_healthy_rigs_move_for_the_first_time(tmp_path, seed):
    assert first_motion(tmp_path, drawn_pair(seed)) is None


@pytest.mark.slow
@pytest.mark.lengthy
def test_no_healthy_cylinder_of_a_thousand_is_refused_its_first_motion(tmp_path):
    for seed in range(1000):
        stopped = first_motion(tmp_path, unit("cylinder", seed))
        assert stopped is None, f"seed {seed}: {stopped}"


SOLD = ("cylinder", "cylinder-valves", "joint", "joint-valves")
"""On regulators as they are sold and mounted, and on valves."""


def pass_every_step(tmp_path, rig, seed):
    stopped, record, _ = perform(tmp_path, unit(rig, seed), seed=seed)
    assert stopped is None
    assert len(record["digest"]) == 8


@pytest.mark.parametrize("rig", [rig for rig in SOLD if rig.startswith("cylinder")])
def test_a_drawn_rig_on_regulators_as_sold_passes_every_step(tmp_path, rig):
    pass_every_step(tmp_path, rig, 4)


SEEDS = {
    "cylinder": range(5, 12), "cylinder-valves": range(5, 12),
    "joint": (0, *range(4, 12), 31),  # 10 and 31 do not move from a base of 200 kPa
    "joint-valves": range(4, 12),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.sampled(1, each="rig")
@pytest.mark.parametrize(("rig", "seed"), [(rig, seed) for rig in SOLD for seed in SEEDS[rig]])
def test_no_drawn_rig_on_regulators_as_sold_is_refused(tmp_path, rig, seed):
    pass_every_step(tmp_path, rig, seed)


@pytest.mark.slow
@pytest.mark.sampled(5)
@pytest.mark.parametrize("plant", PLANTED, ids=lambda plant: plant.__name__)
def test_a_defect_is_found_on_regulators_as_sold(tmp_path, plant):
    find(tmp_path, "cylinder", plant, 1)


ON_VALVES = {
    setpoints_swapped: ("supply", "setpoint wires swapped"),
    monitors_swapped: ("supply", "monitor wires swapped"),
    monitor_scale: ("", "wrong scale of its monitor"),
    tubes_swapped: ("actuators", "tubes swapped"),
    supply_stays_open: ("supply", "does not shut"),
    no_dump_valve: ("supply", "dump valve"),
    watchdog_off: ("master", "watchdog is off"),
    encoders_swapped: ("sensors", "encoders swapped"),
    leaking_fitting: ("leak", "soap water bubbles"),
}
"""A loop that turns the wrong valve would open it to the end: it is stopped before."""


def find_on_valves(tmp_path, plant, seed):
    step, words = ON_VALVES[plant]
    stopped, _, seen = perform(tmp_path, unit("cylinder-valves", seed), plant, seed)
    assert stopped is not None, "nothing was found"
    assert stopped.startswith(step)
    assert words in stopped
    assert seen["pressure"] <= ENOUGH["pressure"], seen
    assert seen["way"] <= ENOUGH["way"], seen


@pytest.mark.parametrize("plant", [setpoints_swapped, watchdog_off], ids=lambda its: its.__name__)
def test_a_valve_that_another_loop_turns_is_shut_in_time(tmp_path, plant):
    find_on_valves(tmp_path, plant, 2)


@pytest.mark.slow
@pytest.mark.sampled(5)
@pytest.mark.parametrize("seed", [3, 4])
@pytest.mark.parametrize("plant", ON_VALVES, ids=lambda its: its.__name__)
def test_a_defect_is_found_on_valves(tmp_path, plant, seed):
    find_on_valves(tmp_path, plant, seed)


def spool_goes(factor, channel):
    """Return a defect: the signal of a spool moves it so much further."""

    def plant(rig, chance):
        def scaled(port):
            put = port.set_pressure_setpoint
            return {
                "set_pressure_setpoint": lambda k, opening: put(
                    k, opening * (factor if k == channel else 1.0)
                )
            }

        with_port(rig, scaled)

    return plant


@pytest.mark.slow
@pytest.mark.sampled(3)
@pytest.mark.parametrize("seed", range(12))
def test_a_spool_whose_signal_is_scaled_lets_in_less_than_20_kpa(tmp_path, seed):
    chance = random.Random(f"spool {seed}")
    plant = spool_goes(chance.uniform(0.4, 2.5), chance.randrange(2))
    stopped, _, seen = perform(
        tmp_path, unit("cylinder-valves", seed), plant, seed, skip=("first-motion",)
    )
    assert seen["pressure"] <= ENOUGH["pressure"], f"{seen}: {stopped}"
    assert stopped is None or "wrong scale of its setpoint" in stopped


@pytest.mark.slow
@pytest.mark.parametrize("factor", [2.5, 3.0])
def test_a_spool_whose_signal_is_far_too_large_is_found(tmp_path, factor):
    stopped, _, seen = perform(tmp_path, unit("cylinder-valves", 1), spool_goes(factor, 0), 1)
    assert stopped is not None
    assert "wrong scale of its setpoint" in stopped
    assert seen["pressure"] <= ENOUGH["pressure"]
