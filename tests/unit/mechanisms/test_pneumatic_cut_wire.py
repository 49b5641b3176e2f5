"""A wire that is cut: speed and energy as the profile foretells them, against the plant's truth."""

import dataclasses
import math

import numpy as np
import pytest
from joint_fakes import joint_limits, joint_settings
from pneumatic_fakes import pair_limits, pair_settings
from scipy.integrate import solve_ivp

from controllers.spherical_joint.geometry import SphericalJointGeometry
from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.settings import PlantSettings
from drivers.sim.plants.spherical_joint import SphericalJointPlant
from drivers.sim.plants.spherical_joint_settings import SphericalJointPlantSettings
from rig.mechanisms.cylinder.settings import FrictionModel
from rig.mechanisms.joint.settings import JointFriction
from rig.mechanisms.pneumatic import cut_wire
from rig.mechanisms.pneumatic.cut_wire import (
    compute_calm_pressure,
    compute_damper,
    compute_whip,
    expect_cut_wire,
    refuse_weak_stop,
)
from rig.mechanisms.pneumatic.settings import RegulatorModel

# As the shipped profiles have them.
PAIR = pair_settings(
    moving_mass=0.138, bore=16e-3, rod=5e-3, friction=FrictionModel(10.4, 13.4, 8e-3, 50.0)
)
JOINT = joint_settings(moving_mass=0.138, friction=JointFriction(7.0, 10.0, 8e-3, 50.0))
SEEN = 6e-3
PISTON = 0.045


def whip(plant, pressure, cut, stop_at):
    """Return the fastest rod but the cut one, m/s, and the energy of all that moves, J."""
    count = len(plant.channel_names)
    plant.set_supply(True)
    for channel in range(count):
        plant.set_pressure_setpoint(channel, pressure)
    plant.advance(1.5)
    plant.inject("wire_cut", cut)
    began, fastest, energy = plant.time, 0.0, 0.0
    others = [k for k in range(count) if k != cut]
    while plant.time < began + 0.15 and min(plant.position(k) for k in others) > stop_at:
        plant.advance(plant.time + 2e-4)
        if plant.time - began >= SEEN:
            for channel in range(count):
                plant.set_pressure_setpoint(channel, 0.0)
        speeds = [abs(plant.speed(k)) for k in others]
        fastest = max(fastest, *speeds)
        pistons = sum(0.5 * PISTON * speed**2 for speed in speeds)
        energy = max(energy, pistons + carried(plant))
    return fastest, energy


def carried(plant):
    """Return the energy of carriage or ring, J."""
    truth = dict(zip([name for name, _ in plant.truth_columns], plant.truth(), strict=True))
    if "velocity" in truth:
        return 0.5 * plant.settings.carriage.mass * truth["velocity"] ** 2
    rates = [plant.joint[0][name] for name in ("rate_x", "rate_y")]
    return 0.5 * plant.joint_parameters[0]["inertia_tilt"] * (rates[0] ** 2 + rates[1] ** 2)


def pair_plant(seed):
    return AntagonisticPairPlant(PlantSettings(friction_spread=0.0), seed)


def joint_plant(seed):
    settings = SphericalJointPlantSettings(friction_spread=0.0)
    return SphericalJointPlant(settings, seed, SphericalJointGeometry())


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("make", "settings", "wires", "low", "high"),
    [(pair_plant, PAIR, 2, 80e3, 260e3), (joint_plant, JOINT, 4, 80e3, 300e3)],
    ids=["pair", "joint"],
)
def test_the_plant_gets_as_fast_as_the_profile_says(make, settings, wires, low, high, seed):
    """And has no more energy; the joint's rods have different forces, and its ring a stop."""
    rng = np.random.default_rng(seed)
    pressure, cut = rng.uniform(low, high), int(rng.integers(wires))
    fastest, energy = whip(make(seed), pressure, cut, stop_at=1e-3)
    said = compute_whip(settings, wires, pressure)
    assert said.speed == pytest.approx(fastest, rel=0.15)
    assert energy <= said.energy <= 2.0 * energy


def slides(pressure, settings, wires):
    """Return the fastest speed of half a pair, m/s, as `solve_ivp` has it."""
    mass, friction = settings.moving_mass * 2.0 / 3.0, settings.friction
    bandwidth, damping = settings.regulator_response.bandwidth, settings.regulator_response.damping

    def flow(t, state):
        _, speed, chamber, rate = state
        force = settings.area * chamber - 0.5 * friction.coulomb - 0.5 * friction.viscous * speed
        turn = -(bandwidth**2) * chamber - 2.0 * damping * bandwidth * rate if t >= SEEN else 0.0
        return [speed, force / mass if speed > 0.0 or force > 0.0 else 0.0, rate, turn]

    def at_end(t, state):
        return state[0] - settings.stroke

    at_end.terminal = True
    state, fastest = [0.0, 0.0, pressure, 0.0], 0.0
    for span in ((0.0, SEEN), (SEEN, 0.5)):
        found = solve_ivp(flow, span, state, events=at_end, max_step=2e-4, rtol=1e-8)
        fastest, state = max(fastest, *found.y[1]), found.y[:, -1]
        if found.status == 1:
            break
    return fastest


@pytest.mark.parametrize("seed", range(8))
def test_the_model_is_solved_right(seed):
    """Heavy and light ones, that end in their stop, by venting or by friction."""
    rng = np.random.default_rng(seed)
    settings = pair_settings(
        moving_mass=float(rng.uniform(0.3, 3.0)),
        bore=float(rng.uniform(10e-3, 40e-3)),
        rod=5e-3,
        home=20e-3,
        stroke=float(rng.choice([0.04, 3.0])),
        friction=FrictionModel(float(rng.uniform(1.0, 6.0)), 13.4, 8e-3, rng.uniform(5.0, 60.0)),
        regulator_response=RegulatorModel(rng.uniform(80.0, 200.0), rng.uniform(0.7, 2.0)),
    )
    pressure = float(rng.uniform(100e3, 400e3))
    said = compute_whip(settings, 2, pressure)
    assert said.speed == pytest.approx(slides(pressure, settings, 2), rel=0.012)


def test_a_regulator_that_vents_at_once_pulls_until_the_cut_is_seen():
    response = RegulatorModel(61.6e3, 3.0)
    smooth = FrictionModel(1e-9, 1e-9, 8e-3, 0.0)
    settings = pair_settings(
        moving_mass=0.3, stroke=3.0, friction=smooth, regulator_response=response
    )
    pulled = settings.area * 50e3 * SEEN / (0.3 * 2.0 / 3.0)
    assert compute_whip(settings, 2, 50e3).speed == pytest.approx(pulled, rel=0.008)


def test_a_slow_regulator_counts_for_half_a_second():
    """Its pressure is of some pascal, at which nothing that starts elsewhere than at rest hides."""
    settings = pair_settings(
        bore=1.2, rod=5e-3, stroke=100.0, moving_mass=15.0,
        friction=FrictionModel(1e-9, 1e-9, 8e-3, 1e-9),
        regulator_response=RegulatorModel(0.3, 1.0),
    )  # fmt: skip
    said = compute_whip(settings, 2, 3.0)
    assert said.speed == pytest.approx(slides(3.0, settings, 2), rel=1e-3)


def test_a_chamber_that_friction_holds_throws_nothing():
    held = 0.5 * PAIR.friction.coulomb / PAIR.area
    assert compute_whip(PAIR, 2, 0.99 * held) == (0.0, 0.0)
    assert compute_whip(PAIR, 2, 1.05 * held).speed > 0.0


def test_the_energy_is_of_what_still_moves():
    speed, energy = compute_whip(PAIR, 2, 120e3)
    assert energy == pytest.approx(1.5 * 0.5 * (2 / 3) * PAIR.moving_mass * speed**2)
    speed, energy = compute_whip(JOINT, 4, 200e3)
    assert energy == pytest.approx(1.5 * 0.5 * (4 / 3) * JOINT.moving_mass * speed**2)


def test_the_calm_pressure_and_the_damper_keep_the_speed():
    for settings, wires in ((PAIR, 2), (JOINT, 4)):
        calm = compute_calm_pressure(settings, wires)
        assert compute_whip(settings, wires, calm).speed == pytest.approx(
            settings.limits.speed, rel=1e-7
        )
        assert compute_whip(settings, wires, calm + 200.0).speed > settings.limits.speed
        damper = compute_damper(settings, 200e3)
        pull = settings.area * 200e3 - 0.5 * settings.friction.coulomb
        held = settings.limits.speed * (damper + 0.5 * settings.friction.viscous)
        assert held == pytest.approx(pull)
        assert compute_damper(settings, 0.5 * calm) == 0.0


@pytest.mark.parametrize(
    ("speed", "most"), [(0.02, 15), (0.05, 11), (0.2, 8), (0.5, 7), (0.9, 8), (1.4, 8)]
)
@pytest.mark.parametrize(("wires", "base"), [(2, PAIR), (4, JOINT)], ids=["pair", "joint"])
def test_the_calm_pressure_is_found_in_a_few_looks(wires, base, speed, most, monkeypatch):
    """Halving from half a megapascal to a hundredth of a pascal takes 26."""
    looks = []

    def look(*asked):
        looks.append(asked)
        return compute_whip(*asked)

    monkeypatch.setattr(cut_wire, "compute_whip", look)
    limits = dataclasses.replace(base.limits, speed=speed)
    settings = dataclasses.replace(base, limits=limits)
    calm = compute_calm_pressure(settings, wires)
    assert len(looks) <= most
    assert compute_whip(settings, wires, calm).speed <= speed
    assert compute_whip(settings, wires, calm + 0.02).speed > speed


def test_the_calm_pressure_may_be_of_less_than_a_pascal():
    friction = FrictionModel(1e-9, 1e-9, 8e-3, 1e-9)
    smooth = dataclasses.replace(PAIR, friction=friction)
    limits = dataclasses.replace(PAIR.limits, speed=compute_whip(smooth, 2, 0.5).speed)
    settings = dataclasses.replace(smooth, limits=limits)
    assert compute_calm_pressure(settings, 2) == pytest.approx(0.5, abs=0.02)


def test_a_highest_pressure_that_just_keeps_the_speed_is_calm():
    highest = PAIR.limits.pressure[1]
    limits = dataclasses.replace(PAIR.limits, speed=compute_whip(PAIR, 2, highest).speed)
    assert compute_calm_pressure(dataclasses.replace(PAIR, limits=limits), 2) == highest


def test_what_no_pressure_throws_too_fast_may_have_the_highest():
    slow = pair_settings(pair_limits(speed=6.0), moving_mass=0.138, bore=16e-3)
    highest = slow.limits.pressure[1]
    assert compute_calm_pressure(slow, 2) == pytest.approx(highest)
    fastest = compute_whip(slow, 2, highest).speed
    slower = pair_settings(pair_limits(speed=0.9 * fastest), moving_mass=0.138, bore=16e-3)
    assert compute_calm_pressure(slower, 2) < 0.95 * highest


def test_a_stop_must_be_declared_and_bear_what_comes():
    energy = compute_whip(PAIR, 2, PAIR.greatest_pressure).energy
    assert f"up to {energy:.3g} J" in refuse_weak_stop(PAIR, 2, PAIR.greatest_pressure)
    assert "is not declared" in refuse_weak_stop(PAIR, 2, PAIR.greatest_pressure)
    for declared, refused in ((math.nextafter(energy, 0.0), True), (energy, False)):
        settings = pair_settings(
            pair_limits(stop_energy=declared),
            moving_mass=0.138,
            bore=16e-3,
            rod=5e-3,
            friction=FrictionModel(10.4, 13.4, 8e-3, 50.0),
        )
        said = refuse_weak_stop(settings, 2, settings.greatest_pressure)
        assert (said is not None) is refused
        if refused:
            assert f"limits.stop_energy is {declared:g} J: " in said
            assert f"is too weak: it takes one that bears {energy:.3g} J at least" in said
            assert "a lower base_pressure or limits.pair_force, or with a damper" in said
            assert "Give the energy" not in said
            assert f"({PAIR.greatest_pressure / 1000:.0f} kPa opposite it)" in said


@pytest.mark.parametrize("rig", [PAIR, JOINT], ids=["cylinder", "joint"])
def test_what_is_said_to_lower_the_pressure_does(rig):
    """Each alone, and the top of the range where that is what bounds it."""
    for key in rig.lowers_pressure.split(" or "):
        assert lowered(rig, key).greatest_pressure < rig.greatest_pressure
    limits = dataclasses.replace(rig.limits, pressure=(0.0, rig.greatest_pressure - 1e3))
    tight = dataclasses.replace(rig, limits=limits)
    assert tight.lowers_pressure == "limits.pressure"


def lowered(rig, key):
    name = key.removeprefix("limits.")
    if name == key:
        return dataclasses.replace(rig, **{key: 0.9 * getattr(rig, key)})
    value = getattr(rig.limits, name)
    value = (value[0], 0.9 * value[1]) if isinstance(value, tuple) else 0.9 * value
    return dataclasses.replace(rig, limits=dataclasses.replace(rig.limits, **{name: value}))


def test_the_greatest_pressure_is_what_the_limits_leave():
    clipped = 120e3 + 0.5 * PAIR.limits.pair_force / PAIR.area
    assert PAIR.greatest_pressure == min(clipped, PAIR.limits.pressure[1])
    strong = joint_settings(joint_limits(tension=(5.0, 300.0)))
    assert strong.greatest_pressure == strong.limits.pressure[1]
    assert JOINT.greatest_pressure == min(
        JOINT.limits.tension[1] / JOINT.area, JOINT.limits.pressure[1]
    )


def test_check_shows_both_pressures():
    expected = expect_cut_wire(PAIR, 2, 285e3)
    values = {quantity.name: quantity.value for quantity in expected}
    base = compute_whip(PAIR, 2, PAIR.base_pressure)
    assert values["a cut wire at base_pressure: speed up to"] == base.speed
    assert values["a cut wire at the greatest pressure: energy up to"] > base.energy
    assert {quantity.unit for quantity in expected} == {"m/s", "J", "Pa", "N s/m"}


def test_seals_that_nobody_has_measured_may_have_less_friction():
    smooth = pair_settings(
        moving_mass=0.138, bore=16e-3, rod=5e-3, friction=FrictionModel(6.24, 13.4, 8e-3, 30.0)
    )
    energy = compute_whip(smooth, 2, 285e3).energy
    (told,) = [one for one in expect_cut_wire(PAIR, 2, 285e3) if "of the friction" in one.name]
    assert told.name == "the same with 0.6 of the friction"
    assert told.value == pytest.approx(energy, rel=1e-12)
    assert f"with {energy:.3g} J if its seals have 0.6" in refuse_weak_stop(PAIR, 2, 285e3)


def test_a_speed_above_the_limit_is_warned_of_and_one_at_it_is_not():
    fast = compute_whip(PAIR, 2, PAIR.base_pressure).speed
    warnings = {}
    for share in (0.9, 1.0, 1.1):
        limits = dataclasses.replace(PAIR.limits, speed=share * fast)
        told = expect_cut_wire(dataclasses.replace(PAIR, limits=limits), 2, 285e3)
        warnings[share] = [quantity.warning for quantity in told if quantity.warning]
    assert warnings[1.0] == warnings[1.1] == []
    [sentence] = warnings[0.9]
    assert "above limits.speed" in sentence and "base_pressure of at most" in sentence


def test_a_pressure_at_which_no_seal_lets_go_is_not_recommended():
    slow = compute_whip(PAIR, 2, 30e3).speed  # the pressure that keeps it is below 30 kPa
    tight = dataclasses.replace(PAIR, limits=dataclasses.replace(PAIR.limits, speed=slow))
    told = expect_cut_wire(tight, 2, 285e3)
    [sentence] = [quantity.warning for quantity in told if quantity.warning]
    pull = 2.0 * PAIR.area * (30e3 - 20e3)
    assert pull < 1.6 * PAIR.friction.breakaway
    assert "is too low to move the seals: it leaves a pair" in sentence
    energy = compute_whip(tight, 2, 285e3).energy
    assert f"a stop that bears {energy:.4g} J" in sentence and "a damper of" in sentence
