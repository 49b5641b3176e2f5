"""The arm's plant against kinematics, statics and energy worked out here."""

import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest

from drivers.sim.plants.arm import ArmPlant
from drivers.sim.plants.arm_model import ArmDeviations, build_model
from drivers.sim.plants.arm_settings import ArmDriveSettings, ArmLinkSettings, ArmPlantSettings

PERIOD = 5e-3
GRAVITY = 9.80665
START = (0.2, 0.5, 1.2, -0.3, -0.6, 0.4)


@dataclass(frozen=True)
class Dimensions:
    """A geometry as a profile may give it; not the controllers' class."""

    a2: float = 0.4
    a3: float = 0.39
    d6: float = 0.118
    base_height: float = 0.25
    wrist_sign: int = 1
    elbow_offset: float = 0.0
    shoulder_offset: float = 0.0
    a1: float = 0.0
    position_min: tuple = (-3.1, -3.1, -2.8, -6.2, -2.5, -6.2)
    position_max: tuple = (3.1, 3.1, 2.8, 6.2, 2.5, 6.2)
    marker: tuple = (0.04, 0.0, 0.03)


FRICTIONLESS = ArmDriveSettings(friction=(0.0,) * 6, viscous=(0.0,) * 6)
EXACT = ArmPlantSettings(mass_spread=0.0, friction_spread=0.0, start=START)


def make(settings=EXACT, seed=0, geometry=Dimensions()):
    return ArmPlant(settings, seed, geometry)


def hold(plant, angles, velocities=(0.0,) * 6):
    for k, (angle, velocity) in enumerate(zip(angles, velocities, strict=True)):
        plant.command_joint(k, angle, velocity, True)


def angles_of(plant):
    return [plant.joint_position(k) for k in range(6)]


def rotation_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def forward_kinematics(q, g):
    """Return hand position and rotation: Rz Ry, upper arm, Ry, forearm, Rz Ry Rz, tool."""
    base = rotation_z(q[0])
    upper = base @ rotation_y(q[1])
    fore = upper @ rotation_y(q[2])
    hand = fore @ rotation_z(q[3]) @ rotation_y(g.wrist_sign * q[4]) @ rotation_z(q[5])
    position = (
        np.array([0.0, 0.0, g.base_height])
        + base @ [g.a1, g.shoulder_offset, 0.0]
        + upper @ [0.0, 0.0, g.a2]
        + fore @ [g.elbow_offset, 0.0, g.a3]
        + hand @ [0.0, 0.0, g.d6]
    )
    return position, hand


# Geometry -----------------------------------------------------------------------------


@pytest.mark.parametrize("wrist_sign", [1, -1])
@pytest.mark.parametrize("offsets", [(0.0, 0.0), (0.05, 0.0), (0.0, -0.12), (-0.03, 0.1)])
def test_the_hand_is_where_the_closed_form_has_it(wrist_sign, offsets):
    geometry = Dimensions(
        wrist_sign=wrist_sign, elbow_offset=offsets[0], shoulder_offset=offsets[1]
    )
    generator = np.random.default_rng(1)
    low, high = np.array(geometry.position_min), np.array(geometry.position_max)
    for _ in range(10):
        q = low + (high - low) * generator.uniform(size=6)
        plant = make(replace(EXACT, start=tuple(q)), geometry=geometry)
        position, rotation = forward_kinematics(q, geometry)
        assert plant.hand_position() == pytest.approx(tuple(position), abs=1e-12)
        found = plant._data.site_xmat[plant._hand].reshape(3, 3)
        assert found == pytest.approx(rotation, abs=1e-12)


def test_the_hand_of_the_truth_belongs_to_its_angles():
    plant = make()
    hold(plant, START, (0.3, 0.2, -0.4, 0.5, -0.2, 0.1))
    plant.advance(0.05)
    truth = dict(zip([name for name, _ in plant.truth_columns], plant.truth(), strict=True))
    q = [truth[name] for name in plant.channel_names]
    assert q == angles_of(plant)
    position, _ = forward_kinematics(q, Dimensions())
    assert [truth[f"hand_{axis}"] for axis in "xyz"] == pytest.approx(list(position), abs=1e-12)
    assert truth["torque_q2"] == plant.joint_torque(1)
    assert truth["q3_velocity"] == plant.joint_velocity(2) < -0.3


# Physics ------------------------------------------------------------------------------


def test_energy_is_kept_without_friction_and_falls_with_it():
    def energies(drives):
        model = build_model(Dimensions(), replace(EXACT, drives=drives), ArmDeviations())
        model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        data = mujoco.MjData(model)
        data.qpos[:] = START
        found = []
        for _ in range(400):
            mujoco.mj_step(model, data)
            found.append(sum(data.energy))
        return np.array(found), data.qpos[1]

    free, angle = energies(FRICTIONLESS)
    assert angle > START[1] + 0.2, "it falls the way it leans"
    assert np.ptp(free) < 1e-5 * abs(free[0])
    rubbing, _ = energies(replace(FRICTIONLESS, viscous=(5.0,) * 6))
    assert rubbing[-1] < rubbing[0] - 1.0
    assert np.all(np.diff(rubbing) < 1e-9)


def gravity_torque(q, g, links):
    """Return what gravity exerts about the shoulder's and the elbow's axis, N m, worked out here.

    Rods have their mass half-way; what is at the wrist centre turns with the forearm.
    """
    lean, bend = math.sin(q[1]), math.sin(q[1] + q[2])
    _, rotation = forward_kinematics(q, g)
    tool = float((rotation_z(q[0]).T @ rotation[:, 2])[0])  # the tool's share along the plane
    _, upper, fore, wrist, bend_mass, tip = links.masses
    elbow = GRAVITY * (
        fore * 0.5 * g.a3 * bend
        + (wrist + bend_mass) * g.a3 * bend
        + tip * (g.a3 * bend + 0.5 * g.d6 * tool)
        + links.payload * (g.a3 * bend + g.d6 * tool)
    )
    beyond = fore + wrist + bend_mass + tip + links.payload
    return elbow + GRAVITY * (upper * 0.5 + beyond) * g.a2 * lean, elbow


def test_drives_carry_the_arm_against_gravity():
    settings = replace(EXACT, drives=FRICTIONLESS)
    plant = make(settings)
    hold(plant, START)
    plant.advance(2.0)
    assert angles_of(plant) == pytest.approx(list(START), abs=1e-6)
    shoulder, elbow = gravity_torque(START, Dimensions(), settings.links)
    assert shoulder > 20.0
    assert plant.joint_torque(1) == pytest.approx(-shoulder, rel=1e-3)
    assert plant.joint_torque(2) == pytest.approx(-elbow, rel=1e-3)


def test_brakes_hold_and_a_released_one_lets_go():
    plant = make()
    plant.advance(2.0)
    assert angles_of(plant) == pytest.approx(list(START), abs=1e-4)
    plant.inject("brake_released", 1)
    plant.advance(3.0)
    assert plant.joint_position(1) > START[1] + 0.1
    assert plant.joint_position(2) == pytest.approx(START[2], abs=0.01)


def test_a_joint_ends_at_its_stop():
    # The tool points down, and gravity turns it farther: without brakes it falls to its stop.
    settings = replace(EXACT, drives=replace(FRICTIONLESS, brakes=(0.0,) * 6))
    plant = make(settings)
    plant.advance(4.0)
    limits = zip(Dimensions().position_min, Dimensions().position_max, strict=True)
    for angle, (low, high) in zip(angles_of(plant), limits, strict=True):
        assert low - 0.15 <= angle <= high + 0.15


# Drives -------------------------------------------------------------------------------


def test_a_slow_ramp_is_followed():
    plant = make()
    hold(plant, START)
    plant.advance(0.5)
    rates = (0.1, 0.1, -0.1, 0.2, 0.2, -0.2)
    worst = 0.0
    for cycle in range(200):
        t = PERIOD * cycle
        hold(plant, [q + rate * t for q, rate in zip(START, rates, strict=True)], rates)
        plant.advance(0.5 + t + PERIOD)
        now = t + PERIOD
        if now > 0.3:
            wanted = [q + rate * now for q, rate in zip(START, rates, strict=True)]
            worst = max(worst, *np.abs(np.subtract(angles_of(plant), wanted)))
    assert worst < 0.2e-3


def test_a_velocity_alone_is_followed():
    plant = make()
    hold(plant, START)
    plant.advance(0.5)
    for _ in range(200):
        plant.command_joint(3, None, 0.4, True)
        plant.advance(plant.time + PERIOD)
    assert plant.joint_velocity(3) == pytest.approx(0.4, abs=1e-3)
    assert plant.joint_position(3) == pytest.approx(START[3] + 0.4, abs=0.01)


def amplitude(plant, k, frequency):
    """Return how much of a small sine without feedforward arrives at joint `k`."""
    hold(plant, START)
    plant.advance(1.0)
    arrived = []
    swing = 5e-3
    for step in range(1000):
        t = step * 1e-3
        plant.command_joint(k, START[k] + swing * math.sin(math.tau * frequency * t), 0.0, True)
        plant.advance(1.0 + t + 1e-3)
        if t >= 0.5:
            phase = math.tau * frequency * (t + 1e-3)
            arrived.append((plant.joint_position(k) - START[k]) * np.exp(-1j * phase))
    return 2.0 * abs(np.mean(arrived)) / swing


@pytest.mark.parametrize("k", [0, 2, 5])
def test_drives_have_a_finite_bandwidth(k):
    settings = replace(EXACT, drives=FRICTIONLESS)
    assert amplitude(make(settings), k, 1.0) == pytest.approx(1.0, abs=0.05)
    assert amplitude(make(settings), k, 8.0) == pytest.approx(0.75, abs=0.25)
    assert amplitude(make(settings), k, 40.0) < 0.3


def test_torque_is_limited_and_what_is_too_heavy_sinks():
    limit = EXACT.drives.torque_limits[1]
    plant = make()
    hold(plant, START)
    plant.advance(0.5)
    plant.inject("payload", 40.0)
    peak = 0.0
    for _ in range(100):
        plant.advance(plant.time + PERIOD)
        peak = max(peak, *(abs(plant.joint_torque(k)) for k in range(6)))
        for k in range(6):
            assert abs(plant.joint_torque(k)) <= EXACT.drives.torque_limits[k]
    assert peak == pytest.approx(limit, rel=1e-3)
    assert plant.joint_position(1) > START[1] + 0.05
    plant.inject("repair")
    plant.advance(plant.time + 3.0)
    assert angles_of(plant) == pytest.approx(list(START), abs=1e-3), "no wind-up is left"


def test_a_moving_reference_that_is_not_renewed_comes_to_rest():
    plant = make()
    hold(plant, START)
    plant.advance(0.5)
    plant.command_joint(0, START[0], 0.5, True)
    plant.advance(2.0)
    moved = EXACT.drives.hold_after * 0.5
    assert plant.joint_position(0) == pytest.approx(START[0] + moved, abs=1e-3)
    assert plant.joint_velocity(0) == pytest.approx(0.0, abs=1e-4)


def test_a_drive_that_loses_its_torque_stops_on_its_brake():
    plant = make()
    for cycle in range(100):
        t = PERIOD * cycle
        hold(plant, [START[0] + 0.5 * t, *START[1:]], (0.5, 0.0, 0.0, 0.0, 0.0, 0.0))
        plant.advance(t + PERIOD)
    assert plant.joint_velocity(0) == pytest.approx(0.5, abs=0.02)
    at = plant.joint_position(0)
    plant.command_joint(0, at, 0.0, False)
    plant.advance(1.0)
    assert plant.joint_torque(0) == 0.0
    assert at < plant.joint_position(0) < at + 0.01
    assert plant.joint_velocity(0) == pytest.approx(0.0, abs=1e-4)


def test_a_blocked_joint_does_not_move():
    plant = make()
    hold(plant, START)
    plant.advance(0.5)
    plant.inject("blocked", 4)
    for _ in range(100):
        hold(plant, [*START[:4], START[4] + 0.3, START[5]])
        plant.advance(plant.time + PERIOD)
    assert plant.joint_position(4) == pytest.approx(START[4], abs=1e-2)
    assert plant.joint_torque(4) == pytest.approx(EXACT.drives.torque_limits[4], rel=1e-3)


# Time and chance ----------------------------------------------------------------------


def run(seed, cycles=60):
    plant = make(ArmPlantSettings(start=START), seed)
    rows = []
    for cycle in range(cycles):
        hold(plant, [q + 0.3 * math.sin(0.05 * cycle) for q in START])
        plant.advance((cycle + 1) * PERIOD)
        rows.append(plant.truth())
    return rows


def test_equal_seeds_give_equal_runs_and_others_do_not():
    assert run(3) == run(3)
    differences = np.abs(np.subtract(run(3), run(4))).max(axis=0)
    assert np.all(differences[:6] > 0.0)
    assert np.all(differences[:6] < 0.02)


def test_time_goes_forward_in_whole_steps():
    plant = make()
    hold(plant, START)
    for t in (0.0123, 0.0124, 0.0123, 0.0, 0.5):
        plant.advance(t)
    assert plant.time == pytest.approx(0.5)
    other = make()
    hold(other, START)
    other.advance(0.5)
    assert other.truth() == plant.truth()


def test_truth_has_a_value_for_every_column():
    plant = make()
    assert len(plant.truth()) == len(plant.truth_columns)
    assert len({name for name, _ in plant.truth_columns}) == len(plant.truth_columns)


# What is refused ----------------------------------------------------------------------


def test_what_cannot_be_is_refused():
    plant = make()
    with pytest.raises(ValueError, match="q3: nan rad"):
        plant.command_joint(2, math.nan, 0.0, True)
    with pytest.raises(ValueError, match="no fault 'melt'; known are blocked"):
        plant.inject("melt")
    with pytest.raises(ValueError, match="no joint number 6"):
        plant.inject("blocked", 6)
    with pytest.raises(ValueError, match="a payload of -1 kg"):
        plant.inject("payload", -1.0)
    with pytest.raises(ValueError, match=r"plant\.start: q3 at 166\.2 deg is outside its range"):
        make(replace(EXACT, start=(0.0, 0.0, 2.9, 0.0, 0.0, 0.0)))


def test_a_tool_without_length_is_a_ball():
    plant = make(replace(EXACT, links=ArmLinkSettings(payload=0.0)), geometry=Dimensions(d6=0.0))
    position, _ = forward_kinematics(START, Dimensions(d6=0.0))
    assert plant.hand_position() == pytest.approx(tuple(position), abs=1e-12)


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("sign", (-1.0, 1.0))
def test_a_pushed_hand_gives_way_and_comes_back(axis, sign):
    plant, still = make(), make()
    for one in (plant, still):
        hold(one, START)
        one.advance(1.0)
    plant.inject(f"{axis}.hand_push", sign * 8.0)
    for one in (plant, still):
        one.advance(1.1)
    way = np.subtract(plant.hand_position(), still.hand_position())
    assert 3e-5 < sign * way["xyz".index(axis)] < 0.1
    for one in (plant, still):
        one.advance(3.0)
    assert plant.hand_position() == pytest.approx(still.hand_position(), abs=1e-3)
    with pytest.raises(ValueError, match="finite impulse"):
        plant.inject(f"{axis}.hand_push", math.inf)
