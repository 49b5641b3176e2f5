"""The acceptance test of healthy rigs whose regulators are calibrated: lines begin anywhere."""

import dataclasses
import random

import pytest
from planted import with_port
from test_commissioning import perform

from rig.assembly import REGISTRY
from rig.commissioning.session import steps_of
from rig.config import find_configs, load_profile

STEPS = ("supply", "stop-reaction", "actuators", "response", "leak")
CHANNELS = ("agonist", "antagonist")


def calibrated(seed):
    """Return a drawn profile, and a plant that is told what the signals of its lines stand for."""
    chance = random.Random(f"line {seed}")
    full = chance.choice((500e3, 900e3))
    lines = [
        (chance.uniform(-0.008, 0.008) * full, chance.uniform(0.99, 1.01) * full) for _ in "ab"
    ]
    said = [f"plant.regulator.full_scale={full}"]
    for channel, (low, high) in zip(CHANNELS, lines, strict=True):
        at = f"devices.regulators.channels.{channel}"
        said.append(f"{at}.setpoint.pressure=[{low} Pa, {high} Pa]")
        said.append(f"{at}.monitor.pressure=[0 Pa, {full} Pa]")
    profile = load_profile("cylinder", REGISTRY, said, find_configs(None))
    simulation = dataclasses.replace(profile.simulation, seed=seed)

    def as_sold(rig, _):
        def of(plant):
            def put(channel, pressure):
                low, high = lines[channel]
                plant.set_pressure_setpoint(channel, (pressure - low) / (high - low) * full)

            return {"set_pressure_setpoint": put}

        with_port(rig, of)

    return dataclasses.replace(profile, simulation=simulation), as_sold


def pass_low_steps(tmp_path, seed):
    profile, as_sold = calibrated(seed)
    skip = [step.name for step in steps_of(profile) if step.name not in STEPS]
    stopped, _, _ = perform(tmp_path, profile, as_sold, seed, skip)
    assert stopped is None, stopped


@pytest.mark.parametrize("seed", range(6))
def test_a_rig_whose_regulators_are_calibrated_is_not_refused(tmp_path, seed):
    pass_low_steps(tmp_path, seed)


@pytest.mark.slow
@pytest.mark.sampled(8)
@pytest.mark.parametrize("seed", range(6, 60))
def test_no_drawn_calibrated_rig_is_refused(tmp_path, seed):
    pass_low_steps(tmp_path, seed)
