"""How long setpoints may stay as they are: found on the plant beforehand, and true of it."""

from functools import cache

import numpy as np
import pytest
from stop_bench import CONFIGS

from rig.assembly import Backend
from rig.assembly.simulated import make_plant
from rig.experiment.frozen import (
    NoBound,
    longest_freeze,
    refuse_slow_devices,
)
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.experiment.slowest import Slowest, slowest_device
from rig.hal import DeviceError

BRISK = (
    "reference.amplitude=10 mm",
    "reference.tones=[{frequency: 1 Hz, periods: 3}]",
    "metrics={}",
    "figures=[]",
)


def plan_of(experiment, *options, rig=None):
    return load_plan(experiment, list(options), configs=CONFIGS, rig=rig)


@cache
def bound_of(experiment, *options):
    return longest_freeze(plan_of(experiment, *options))


def test_brisk_sine_bears_some_thirty_milliseconds_and_a_slow_one_more():
    brisk = bound_of("cylinder-ideal-sine", *BRISK)
    assert brisk.what == "position"
    assert 0.02 < brisk.longest < 0.06
    slow = (BRISK[0], "reference.tones=[{frequency: 0.1 Hz, periods: 2}]", *BRISK[2:])
    assert bound_of("cylinder-ideal-sine", *slow).longest > brisk.longest


def test_bound_holds_on_the_plant_and_more_does_not():
    from rig.experiment import frozen

    plan = plan_of("cylinder-ideal-sine", *BRISK)
    bound = bound_of("cylinder-ideal-sine", *BRISK)
    hazards = frozen.REGISTRY.hazards(plan.profile.plant.model)(plan.profile.mechanism_settings)
    trial = frozen._Trial(plan, hazards)
    (worst,) = [one for one in trial._instants if abs(one.t - bound.at) < 1e-6]
    positions = {}
    for freeze in (bound.longest, bound.longest + 2e-3):
        trial._passes(worst, freeze)
        positions[freeze] = abs(trial._plant.truth()[0])
    short, long = positions.values()
    assert short < 24e-3 < long
    every = [one for one in trial._instants if trial._passes(one, 0.9 * bound.longest)]
    assert not every


def test_instants_of_a_long_motion_are_told_in_its_own_time():
    """Only its fastest stretches are gone through, with ways between them that are none of it."""
    from rig.experiment import frozen
    from rig.experiment.excerpts import fastest

    plan = plan_of("cylinder-sine")
    hazards = frozen.REGISTRY.hazards(plan.profile.plant.model)(plan.profile.mechanism_settings)
    trial, motion = frozen._Trial(plan, hazards), plan.motion
    near = plan.profile.mechanism_settings.limits.following
    stretches = fastest(type(trial._rig.mechanism), motion)
    assert len(trial._instants) > 300
    for one in trial._instants:
        assert any(start <= one.t <= end for start, end in stretches)
        trial._plant.restore(one.plant)
        assert trial._plant.truth()[0] == pytest.approx(motion.at(one.t).position, abs=near)


@pytest.mark.parametrize("experiment", ["cylinder-ideal-sine", "joint-ideal-circle"])
def test_plant_goes_the_same_way_again_from_a_snapshot(experiment):
    plant = make_plant(plan_of(experiment).profile)
    plant.set_supply(True)
    for channel in range(len(plant.channel_names)):
        plant.set_pressure_setpoint(channel, 100e3 + 5e3 * channel)
    plant.advance(0.3)
    here, ways = plant.snapshot(), []
    for _ in range(2):
        plant.restore(here)
        assert plant.time == pytest.approx(0.3)
        plant.set_supply(False)
        plant.set_pressure_setpoint(1, 0.0)
        plant.advance(0.4)
        ways.append(plant.truth())
    assert ways[0] == ways[1]
    plant.restore(here)
    plant.advance(0.4)
    assert plant.truth() != ways[0]  # its supply is open again


def test_servos_bear_the_time_that_their_range_leaves_them():
    plan = plan_of("legs-walk-fast")
    bound = longest_freeze(plan)
    settings = plan.profile.mechanism_settings
    ranges, slack = settings.geometry.limits, settings.limits.following

    def room(t, freeze):
        """Return how far every joint is within its limits if it goes on for so long, rad."""
        moved = plan.motion.at(float(t))
        for angle, speed, (low, high) in zip(
            moved.positions, moved.velocities, ranges, strict=True
        ):
            ahead = angle + freeze * speed
            yield min(ahead - low, high - ahead) + slack

    assert min(room(bound.at, bound.longest)) == pytest.approx(0.0, abs=1e-9)
    assert bound.what.startswith("range of ")
    for t in np.linspace(0.0, plan.motion.duration, 997):
        assert min(room(t, 0.95 * bound.longest)) > 0.0


@pytest.mark.parametrize(
    ("rig", "experiment", "device", "after"),
    [
        ("cylinder", "cylinder-ideal-sine", "regulators", 0.03),
        ("joint", "joint-ideal-circle", "regulators", 0.005),
        ("arm", "arm-wrist-hit", "drives", 0.15),
        ("arm-odrive", "arm-wrist-hit", "drives", 0.05),
        ("legs", "legs-squat", "servos", 0.06),
    ],
)
def test_profile_says_when_its_slowest_device_acts(rig, experiment, device, after):
    assert slowest_device(plan_of(experiment, rig=rig).profile) == Slowest(device, after)


def test_slow_profile_is_refused_on_hardware_and_a_quick_one_is_not(tmp_path):
    slow = plan_of(
        "cylinder-ideal-sine",
        *BRISK,
        "buses.can0.heartbeat=50 ms",
        "buses.can0.heartbeat_timeout=150 ms",
    )
    with pytest.raises(DeviceError, match=r"regulators.*keeps its setpoints for 150 ms") as caught:
        run_experiment(slow, Backend.HARDWARE, tmp_path, report=False)
    assert "position would pass its limit" in str(caught.value)
    assert not list(tmp_path.iterdir())
    said = []
    quick = plan_of(
        "cylinder-ideal-sine",
        *BRISK,
        "buses.can0.heartbeat=5 ms",
        "buses.can0.heartbeat_timeout=15 ms",
    )
    refuse_slow_devices(quick, said.append)
    assert said == ["trying on the plant what setpoints do that stay as they are …"]


def test_profile_without_a_plant_says_so():
    plan = plan_of("cylinder-ideal-sine", *BRISK, "plant=null")
    bound, said = longest_freeze(plan), []
    assert isinstance(bound, NoBound)
    assert bound.why == "cylinder-ideal has no plant to try it on"
    refuse_slow_devices(plan, said.append)
    assert said == [f"what frozen setpoints do is not known: {bound.why}"]
