"""The spherical joint as a mechanism: energy, equilibrium, poses, symmetry, determinism."""

import math
from dataclasses import replace

import numpy as np
import pytest
from joint_bench import (
    AREA,
    BASE,
    CH1,
    CH2,
    CH3,
    CH4,
    EQUAL,
    SEALED,
    Geometry,
    at_base,
    command,
    energy,
    exact_lengths,
    joint,
    points,
    rotation,
    truth,
    wire_lengths,
)

from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.settings import ActuatorSettings, WireSettings
from drivers.sim.plants.spherical_joint import SphericalJointPlant
from drivers.sim.plants.spherical_joint_settings import RingSettings, SphericalJointPlantSettings
from drivers.sim.plants.spherical_joint_truth import STICKING_SPEED

UNEVEN = (3.5e5, 2.5e5, 1.5e5, 2.0e5)


def spin(plant, x, y, z):
    plant.joint["rate_x"], plant.joint["rate_y"], plant.joint["rate_z"] = x, y, z


def rates(plant):
    return np.array([plant.joint[name][0] for name in ("rate_x", "rate_y", "rate_z")])


def energies(plant, duration, every=1):
    """Return the energy after each step and the greatest rod speed on the way."""
    plant.channels["pressure"] = UNEVEN
    found, fastest, step = [energy(plant)], 0.0, plant.settings.substep
    for k in range(1, round(duration / step / every) + 1):
        plant.advance(k * every * step)
        found.append(energy(plant))
        fastest = max(fastest, float(np.abs(plant.channels["speed"]).max()))
    return np.array(found), fastest


@pytest.mark.parametrize("seals", ["standard", "low-speed"])
def test_friction_and_sealed_air_never_give_energy(seals):
    plant = joint(seals=seals, regulator=SEALED)
    spin(plant, 2.0, -3.0, 20.0)
    found, speed = energies(plant, 0.15)
    assert speed > 0.2
    assert np.diff(found).max() < 1e-9
    assert found[0] - found[-1] > 0.1


def test_without_friction_and_damping_energy_is_kept():
    """Gas, wires, gravity and gyration exchange it; a wrong arm or sign would make some."""
    plant = joint(
        friction_scale=0.0,
        regulator=SEALED,
        wire=WireSettings(damping=0.0),
        substep=12.5e-6,
        cylinder=ActuatorSettings(stop_damping=0.0),
        ring=RingSettings(mass=0.5, stop_damping=0.0),
    )
    spin(plant, 5.0, -8.0, 30.0)
    found, speed = energies(plant, 0.06, every=4)
    kinetic = 2 * 0.045 * speed**2
    assert kinetic > 0.5
    assert np.abs(found - found[0]).max() < 0.01 * kinetic


def cut_all(plant):
    for channel in range(4):
        plant.inject("wire_cut", channel)


def test_parts_of_the_friction_have_factors_of_their_own():
    usual = joint()
    more = joint(
        friction_scale=1.2, seal_load_scale=1.5, ring_friction_scale=1.3, wire_friction_scale=0.5
    )
    for parts, name, factor in (
        ("parameters", "coulomb", 1.2), ("parameters", "breakaway", 1.2),
        ("parameters", "viscous", 1.2), ("parameters", "pressure_friction", 1.8),
        ("joint_parameters", "seat_arm", 1.56), ("wire_parameters", "friction", 0.6),
    ):  # fmt: skip
        was, now = (getattr(plant, parts)[name] for plant in (usual, more))
        assert now == pytest.approx(factor * was)


def test_a_free_ring_spins_like_a_top():
    """No torque: the angular momentum stays, and the axis goes round it at L / I_tilt."""
    plant = joint(friction_scale=0.0, ring=RingSettings(mass=1e-9), substep=1e-5)
    cut_all(plant)
    spin(plant, 6.0, 0.0, 40.0)
    momentum = np.array([3.0e-5 * 6.0, 0.0, 1.3e-5 * 40.0])
    period = math.tau * 3.0e-5 / np.linalg.norm(momentum)
    plant.advance(round(period / 1e-5) * 1e-5)
    matrix = np.array(plant.ring_rotation())
    inertia = matrix @ np.diag([3.0e-5, 3.0e-5, 1.3e-5]) @ matrix.T
    np.testing.assert_allclose(inertia @ rates(plant), momentum, atol=1e-3 * momentum[2])
    np.testing.assert_allclose(matrix[:, 2], (0, 0, 1), atol=5e-3)
    plant.advance(1.5 * period)
    assert np.linalg.norm(plant.ring_rotation()[0][2:]) > 0.1


def test_a_hanging_ring_swings_as_a_pendulum():
    ring = RingSettings(mass=0.1, centre_height=-0.02)
    plant = joint(friction_scale=0.0, ring=ring)
    cut_all(plant)
    spin(plant, 0.3, 0.0, 0.0)
    half = math.pi / math.sqrt(0.1 * 9.80665 * 0.02 / 3.0e-5)
    plant.advance(half / 2)
    assert truth(plant)["axis_y"] == pytest.approx(-0.3 * half / math.pi, rel=2e-3)
    plant.advance(half)
    assert truth(plant)["axis_y"] == pytest.approx(0.0, abs=1e-4)


def test_an_upright_ring_without_wires_falls_to_its_stop():
    plant = joint(friction_scale=0.0)
    cut_all(plant)
    spin(plant, 0.1, 0.0, 0.0)
    most = 0.0
    while plant.time < 2.0:
        plant.advance(plant.time + 5e-3)
        x, y, z = (row[2] for row in plant.ring_rotation())
        most = max(most, math.atan2(math.hypot(x, y), z))
    assert math.radians(95.0) < most < math.radians(97.0)


def lengths(matrix):
    anchors, adjusts = points()
    return exact_lengths(anchors @ matrix.T, adjusts, 0.025)


@pytest.mark.parametrize(("tilt", "holds"), [(5.0, True), (7.0, False)])
def test_the_ring_weighs_on_its_seat(tilt, holds):
    """Friction holds what leans by less than mu tan(alpha_0) 0.75 r / h: 5.7 degrees."""
    plant = joint(ring=RingSettings(mass=0.5, centre_height=0.020))
    cut_all(plant)
    half = math.radians(tilt) / 2
    plant.joint["qw"], plant.joint["qx"] = math.cos(half), math.sin(half)
    plant.advance(1.0)
    assert (truth(plant)["axis_z"] > math.cos(math.radians(tilt + 0.3))) == holds


def test_sliding_wires_lose_tension_as_they_wrap_the_ball():
    plant = at_base(joint(), 0.5)
    command(plant, [BASE + 80e3, BASE, BASE - 80e3, BASE], 0.6)
    values, (anchors, adjusts) = truth(plant), points()
    ends = anchors @ np.array(plant.ring_rotation()).T
    for k, way in ((CH1, -1.0), (CH3, 1.0)):
        assert abs(plant.speed(k)) > 0.02
        cosine = ends[k] @ adjusts[k] / (0.025 * np.linalg.norm(adjusts[k]))
        wrap = math.acos(cosine) - math.pi / 4
        ratio = values[f"ring_tension_ch{k + 1}"] / values[f"tension_ch{k + 1}"]
        assert ratio == pytest.approx(math.exp(way * 0.10 * wrap), rel=1e-3)


@pytest.mark.parametrize("pressures", [(2.6e5, 2.5e5, 2.4e5, 2.4e5), (2.3e5, 2.6e5, 2.5e5, 2.5e5)])
def test_at_rest_the_pressures_balance_the_virtual_work(pressures):
    """A rod's force times its wire's slope, less gravity, for three rotations of the ring.

    Sealed air is the spring that makes a pose of the pressures; the motion is stopped every
    5 ms until nothing moves. Lengths and slopes are not the plant's.
    """
    plant = joint(friction_scale=0.0, regulator=SEALED, ring=RingSettings(mass=0.1))
    plant.channels["pressure"] = pressures
    for k in range(1, 1001):
        plant.advance(5e-3 * k)
        plant.channels["speed"] = 0.0
        spin(plant, 0.0, 0.0, 0.0)
    matrix = np.array(plant.ring_rotation())
    assert matrix[2, 2] < math.cos(math.radians(8.0))
    pull = AREA * (plant.channels["pressure"] - ATMOSPHERE)
    assert pull.min() > 5.0
    for axis in np.eye(3):
        ahead, behind = (rotation(axis, turn) @ matrix for turn in (1e-6, -1e-6))
        slopes = (lengths(ahead) - lengths(behind)) / 2e-6
        gravity = 0.1 * 9.80665 * 0.020 * (ahead[2, 2] - behind[2, 2]) / 2e-6
        assert -(pull @ slopes) - gravity == pytest.approx(0.0, abs=2e-4)
        assert np.abs(pull * slopes).max() > 10 * 2e-4


def hold_rods(matrix, pull=0.25e-3):
    """Take the rods to where an ideal joint has them in a pose, and let the ring follow.

    Pistons too heavy to move make the rods' lengths the input.
    """
    plant = joint(cylinder=ActuatorSettings(mass=1e6))
    home = np.full(4, 0.030 - pull)
    goal = home + wire_lengths(matrix) - wire_lengths(np.eye(3))
    for k in range(1, 301):
        plant.channels["extension"] = home + (goal - home) * min(k / 200, 1.0)
        plant.advance(2e-3 * k)
    return plant


def pose(azimuth, tilt, twist=0.0):
    return rotation((-math.sin(azimuth), math.cos(azimuth), 0.0), tilt) @ rotation(
        (0.0, 0.0, 1.0), twist
    )


def paper_pose(azimuth, tilt):
    """Return R_Y(theta) R_X(phi) with the same axis (Kobayashi and Saito, eq. (4))."""
    x, y, z = pose(azimuth, tilt)[:, 2]
    return rotation((0, 1, 0), math.atan2(x, z)) @ rotation((1, 0, 0), -math.asin(y))


@pytest.mark.parametrize("azimuth", [0.3, 2.0, 4.0])
def test_the_ring_goes_where_its_wires_say(azimuth):
    plant = hold_rods(pose(azimuth, math.radians(20.0)))
    wanted = 0.052628 * pose(azimuth, math.radians(20.0))[:, 2]
    assert np.linalg.norm(np.array(plant.marker_position()) - wanted) < 0.1e-3
    assert abs(plant.twist()) < math.radians(0.02)
    assert min(truth(plant)[f"tension_ch{k}"] for k in (1, 2, 3, 4)) > 5.0


def test_the_ring_does_not_take_the_twist_of_two_successive_rotations():
    """R_Y R_X is twisted by 1.8 degrees at 20 degrees; four wires cannot hold that."""
    azimuth, tilt = math.radians(45.0), math.radians(20.0)
    matrix = paper_pose(azimuth, tilt)
    relative = pose(azimuth, tilt).T @ matrix
    assert math.atan2(relative[1, 0], relative[0, 0]) == pytest.approx(math.radians(1.78), rel=0.01)
    plant = hold_rods(matrix)
    assert abs(plant.twist()) < math.radians(0.05)
    error = np.linalg.norm(np.array(plant.marker_position()) - 0.052628 * matrix[:, 2])
    assert error == pytest.approx(0.32e-3, abs=0.03e-3)


def test_twist_is_what_remains_beside_the_shortest_tilt():
    plant = joint()
    for twist in (0.1, -0.3):
        matrix = pose(1.0, 0.5, twist)
        w = 0.5 * math.sqrt(1.0 + np.trace(matrix))
        x, y, z = (
            (matrix[2, 1] - matrix[1, 2]) / (4 * w),
            (matrix[0, 2] - matrix[2, 0]) / (4 * w),
            (matrix[1, 0] - matrix[0, 1]) / (4 * w),
        )
        plant.joint["qw"], plant.joint["qx"], plant.joint["qy"], plant.joint["qz"] = w, x, y, z
        np.testing.assert_allclose(plant.ring_rotation(), matrix, atol=1e-12)
        np.testing.assert_allclose(plant.marker_position(), 0.052628 * matrix[:, 2], atol=1e-12)
        assert plant.twist() == pytest.approx(twist, abs=1e-12)


@pytest.mark.parametrize("seals", ["standard", "low-speed"])
def test_wires_are_taut_at_base_pressure(seals):
    for seed in range(3):
        plant = at_base(
            SphericalJointPlant(SphericalJointPlantSettings(seals=seals), seed, Geometry())
        )
        values = truth(plant)
        tensions = [values[f"{side}tension_ch{k}"] for side in ("", "ring_") for k in (1, 2, 3, 4)]
        assert min(tensions) > 12.0
        assert max(tensions) < AREA * BASE + 6.0
        assert values["axis_z"] > math.cos(math.radians(0.5))


def pulse(puller, opponent, **changes):
    """Tip the ring with one pulse of pressure in a pair and return the marker's track, m."""
    plant = at_base(joint(**changes), 0.5)
    track = []
    for k in range(1, 201):
        pressures = [BASE] * 4
        pressures[puller] += 60e3 if k <= 75 else -20e3
        pressures[opponent] -= 60e3 if k <= 75 else -20e3
        command(plant, pressures, 0.5 + 2e-3 * k)
        track.append(plant.marker_position())
    return np.array(track)


def test_a_symmetric_joint_tips_alike_to_all_four_sides():
    track = pulse(CH1, CH3)
    assert track[:, 1].max() > 5e-3  # towards the first anchor, +Y
    assert np.abs(track[:, 0]).max() < 1e-8
    for puller, opponent, turn in ((CH2, CH4, 1), (CH3, CH1, 2), (CH4, CH2, 3)):
        turned = track @ np.round(rotation((0, 0, 1), turn * math.pi / 2)).T
        np.testing.assert_allclose(pulse(puller, opponent), turned, atol=1e-7)


def test_a_rod_retracts_as_its_wire_is_pulled_in():
    plant = at_base(joint(), 0.5)
    before = [plant.position(k) for k in range(4)]
    command(plant, [BASE + 60e3, BASE, BASE - 60e3, BASE], 0.65)
    after = [plant.position(k) for k in range(4)]
    assert after[CH1] < before[CH1] - 1e-3
    assert after[CH3] > before[CH3] + 1e-3
    expected = 0.030 + plant.wires["length"] - wire_lengths(np.eye(3))
    np.testing.assert_allclose(after, expected - plant.channels["tension"] / 80e3, atol=2e-5)


def test_the_step_is_small_enough():
    """Timing errors of a fraction of a millisecond are left, and shrink with the step."""
    fine, usual, coarse = (pulse(CH1, CH3, substep=step) for step in (12.5e-6, 50e-6, 100e-6))
    speed = np.abs(np.diff(fine[:, 1])).max() / 2e-3
    assert speed > 0.1
    error = np.abs(usual - fine).max()
    assert error < 0.25e-3 * speed
    assert 1.5 * error < np.abs(coarse - fine).max() < 4 * error


def test_rods_stick_until_they_slide():
    plant = at_base(joint(), 0.5)
    assert [truth(plant)[f"sticking_ch{k}"] for k in (1, 2, 3, 4)] == [1.0] * 4
    held = 0.0
    for k in range(1, 101):  # the third rod turns round: its seals give way before they slide
        command(plant, [BASE + 80e3, BASE, BASE - 80e3, BASE], 0.5 + 1e-3 * k)
        if truth(plant)["sticking_ch3"]:
            held = max(held, truth(plant)["speed_ch3"])
    assert held > 5 * STICKING_SPEED
    values = truth(plant)
    assert abs(values["speed_ch1"]) > 0.02
    assert (values["sticking_ch1"], values["sticking_ch3"]) == (0.0, 0.0)


def test_low_speed_seals_need_less_pressure_to_tip_the_ring():
    standard, low_speed = (pulse(CH4, CH2, seals=seals) for seals in ("standard", "low-speed"))
    assert low_speed[:, 0].max() > 1.5 * standard[:, 0].max()


def history(seed, period=2e-3, **changes):
    plant = SphericalJointPlant(replace(SphericalJointPlantSettings(), **changes), seed, Geometry())
    plant.set_supply(True)
    rows = []
    for k in range(1, 201):
        t = 2e-3 * k
        for channel in range(4):
            plant.set_pressure_setpoint(channel, BASE + 80e3 * math.sin(9 * t + channel))
        while plant.time < t - 1e-9:
            plant.advance(min(plant.time + period, t))
        rows.append((*plant.truth(), *map(plant.pressure, range(4)), *plant.ring_rotation()))
    return rows


def test_a_seed_gives_one_run_and_another_seed_another():
    assert history(7) == history(7)
    assert history(7) != history(8)


def test_the_physics_does_not_depend_on_how_time_is_sliced():
    whole, sliced = history(7), history(7, 0.35e-3)
    count = len(SphericalJointPlant.truth_columns)
    assert [row[:count] for row in whole] == [row[:count] for row in sliced]


def test_one_setting_does_not_change_what_others_draw():
    one = SphericalJointPlant(EQUAL, 4, Geometry())
    other = SphericalJointPlant(replace(EQUAL, friction_spread=0.15), 4, Geometry())
    tilted = SphericalJointPlant(
        replace(EQUAL, friction_spread=0.15, tolerance=1e-4), 4, Geometry()
    )
    assert (one.parameters["coulomb"] != other.parameters["coulomb"]).all()
    assert (other.parameters == tilted.parameters).all()
    assert (other.wire_parameters["friction"] == tilted.wire_parameters["friction"]).all()
    assert other.joint_parameters["seat_arm"] == tilted.joint_parameters["seat_arm"]
    assert other.joint_parameters["marker_x"] == 0.0 != tilted.joint_parameters["marker_x"]


def test_units_spread_within_their_bounds():
    friction, seat, offsets = [], [], []
    nominal = wire_lengths(np.eye(3)) - 0.030
    settings = SphericalJointPlantSettings(tolerance=0.0, wire_offset=50e-6)
    for seed in range(50):
        plant = SphericalJointPlant(settings, seed, Geometry())
        friction += list(plant.wire_parameters["friction"] / 0.10)
        seat.append(float(plant.joint_parameters["seat_arm"][0]) / (0.08 * 0.75 * 4 / 3 * 0.025))
        offsets += list(plant.wire_parameters["free"] - nominal)
    for factors in (friction, seat):
        assert 0.85 <= min(factors) < 0.88
        assert 1.12 < max(factors) <= 1.15
    assert -50e-6 <= min(offsets) < -40e-6
    assert 40e-6 < max(offsets) <= 50e-6


def test_truth_has_a_value_for_every_column():
    plant = at_base(joint(), 0.1)
    assert len(plant.truth()) == len(plant.truth_columns)
    values = truth(plant)
    assert values["supply"] == pytest.approx(0.7e6, rel=0.01)
    assert values["pressure_ch2"] == pytest.approx(plant.pressure(1), abs=1e-6)
    assert math.hypot(*(values[f"axis_{k}"] for k in "xyz")) == pytest.approx(1.0)


def test_settings_that_do_not_fit_together_are_refused():
    with pytest.raises(ValueError, match="home"):
        SphericalJointPlantSettings(home=0.07)
    with pytest.raises(ValueError, match="inertia_spin"):
        RingSettings(inertia_tilt=1e-5, inertia_spin=3e-5)


def test_points_of_the_bench_are_those_of_the_plant():
    anchors, adjusts = points()
    w = joint().wire_parameters
    np.testing.assert_allclose(np.stack([w[f"anchor_{k}"] for k in "xyz"], 1), anchors, atol=1e-15)
    np.testing.assert_allclose(np.stack([w[f"adjust_{k}"] for k in "xyz"], 1), adjusts, atol=1e-15)
