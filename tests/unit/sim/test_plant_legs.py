"""The whole robot on its floor: it stands, walks, slips, sags and falls."""

import math
import random

import mujoco
import numpy as np
import pytest
from gait_laws import LAWS

from controllers.gait.geometry import LegGeometry
from controllers.gait.motions import BobSettings, SquatSettings, WalkSettings
from controllers.gait.types import BalanceSettings, GaitModel
from controllers.minimum_jerk import minimum_jerk
from drivers.sim.plants.legs import LegsPlant
from drivers.sim.plants.legs_settings import LegServoSettings, LegsPlantSettings, TerrainBlock

PERIOD = 5e-3
PULSE = math.radians(1.0 / 209.0)
APPROACH = 2.0
GEOMETRY = LegGeometry()
COLUMNS = [name for name, _ in LegsPlant.truth_columns]
PERMISSIVE = GaitModel(GEOMETRY, BalanceSettings(min_margin=1e-6, response_time=1.0))


def make(seed=0, **changes):
    return LegsPlant(LegsPlantSettings(**changes), seed, GEOMETRY)


def power(plant, torque_on=True):
    """Let all servos hold what they have."""
    for channel in range(12):
        plant.command_joint(channel, plant.joint_position(channel), 0.0, torque_on)


class Walk:
    """One motion, quantised as servos are, on a plant.

    Attributes hold the truth of each period by its column's name; ``support_torque`` is the knee's
    of the leg that stands alone, its magnitude.
    """

    def __init__(self, law, motion, plant=None):
        kind = next(kind for kind in LAWS if kind.name == law)
        plan = kind(kind.Settings(), PERMISSIVE, PERIOD).prepare(motion)
        self.plant = plant = plant if plant is not None else make()
        start = [plant.joint_position(channel) for channel in range(12)]
        for cycle in range(round(APPROACH / PERIOD)):
            for channel, (low, high) in enumerate(zip(start, plan.q[0], strict=True)):
                angle, rate, _ = minimum_jerk(low, high, 0.8 * APPROACH, cycle * PERIOD)
                plant.command_joint(channel, angle, rate, True)
            plant.advance(plant.time + PERIOD)
        before = dict(zip(COLUMNS, plant.truth(), strict=True))
        rows = []
        for angles, rates in zip(
            (np.round(plan.q / PULSE) * PULSE).tolist(), plan.q_dot.tolist(), strict=True
        ):
            for channel in range(12):
                plant.command_joint(channel, angles[channel], rates[channel], True)
            plant.advance(plant.time + PERIOD)
            rows.append(plant.truth())
        self.truth = dict(zip(COLUMNS, np.array(rows).T, strict=True))
        self.fell = bool(self.truth["fell"][-1])
        self.advance = self.truth["advance"][-1] - before["advance"]
        self.slip = max(self.truth[name][-1] - before[name] for name in ("slip_right", "slip_left"))
        knees = np.abs([self.truth["torque_right_knee"], self.truth["torque_left_knee"]])
        self.knee_torque = float(knees.max())
        standing = np.array([planned.phase.standing for planned in plan.phases])[plan.phase_number]
        alone = standing.sum(axis=1) == 1
        of_standing = np.where(standing[:, 0], *knees)
        self.support_torque = float(of_standing[alone].mean()) if alone.any() else math.nan
        self.saturated = float(np.mean(self.truth["saturated"] > 0))


@pytest.fixture(scope="module")
def walk():
    return Walk("sc-trapezoid", WalkSettings())


def test_robot_stands_ready_with_flat_soles():
    plant = make(mass_spread=0.0)
    assert plant.model.body_mass.sum() == pytest.approx(6.0)
    assert plant.data.site_xpos[:, 2] == pytest.approx((0.0, 0.0), abs=1e-12)
    assert plant.data.site_xpos[:, 1] == pytest.approx((-0.039, 0.039))
    assert plant.truth()[2] == pytest.approx(0.190 + 0.0405)
    assert plant.channel_names[3] == "right_knee"
    assert math.degrees(plant.joint_position(3)) == pytest.approx(36.39, abs=0.01)


def test_stand_holds_the_robot_until_all_servos_have_torque():
    plant = make()
    before = plant.truth()
    for channel in range(11):
        plant.command_joint(channel, 0.3, 0.0, True)
    plant.advance(1.0)
    assert plant.time == 1.0
    assert plant.truth() == before
    power(plant)
    plant.advance(1.1)
    assert plant.truth() != before


def test_robot_stands_on_its_servos_and_sags_a_little():
    plant = make()
    height = plant.truth()[2]
    power(plant)
    plant.advance(2.0)
    truth = dict(zip(COLUMNS, plant.truth(), strict=True))
    assert truth["fell"] == 0.0
    assert 0.1e-3 < height - truth["waist_z"] < 3e-3
    weight = 9.81 * plant.model.body_mass.sum()
    assert truth["load_right"] + truth["load_left"] == pytest.approx(weight, rel=0.01)
    assert abs(truth["waist_pitch"]) < 0.01


@pytest.mark.parametrize("seed", range(6))
def test_a_capped_servo_turns_a_light_leg_no_faster(seed):
    chance = random.Random(seed)
    plant = make(seed)
    channel, speed = chance.randrange(12), chance.uniform(1.0, 6.0)
    way = chance.choice((-1.0, 1.0)) * chance.uniform(0.3, 1.0)
    for capped in range(12):
        plant.limit_joint(capped, speed, math.inf)
    power(plant)
    plant.data.qpos[2] += 1.0  # in the air: nothing slows a leg down but its own loop
    plant.command_joint(channel, plant.joint_position(channel) + way, 0.0, True)
    fastest = 0.0
    for cycle in range(1, 120):
        plant.advance(cycle * 2.5e-3)
        fastest = max(fastest, abs(plant.joint_velocity(channel)))
    assert 0.5 * min(speed, GEOMETRY.max_rate) < fastest <= 1.02 * speed


@pytest.mark.parametrize("seed", range(4))
def test_a_push_gives_its_impulse_once(seed):
    chance = random.Random(seed)
    plant, still = make(seed), make(seed)
    push = chance.choice([name for name in plant.known_faults if name.endswith(".push")])
    size = chance.choice((-1.0, 1.0)) * chance.uniform(0.1, 2.0)
    for one in (plant, still):
        power(one)
        one.data.qpos[2] += 1.0  # in the air nothing answers it
    plant.inject(push, size)
    for one in (plant, still):
        one.advance(0.2)
        mujoco.mj_forward(one.model, one.data)
        mujoco.mj_subtreeVel(one.model, one.data)
    momentum = (plant.data.subtree_linvel - still.data.subtree_linvel)[0]
    momentum = momentum * plant.model.body_mass.sum()
    assert math.hypot(*momentum) == pytest.approx(abs(size), rel=0.03)
    sideways = momentum[1] * size
    assert (sideways > 0.05 * size**2) == ("left" in push)
    assert not plant.data.xfrc_applied.any()


def test_a_hard_push_topples_the_robot_and_a_light_one_does_not():
    for size, falls in ((0.3, 0.0), (-0.3, 0.0), (5.0, 1.0), (-5.0, 1.0)):
        plant = make()
        power(plant)
        plant.advance(0.3)
        plant.inject("forward.push", size)
        plant.advance(2.5)
        assert plant.truth()[COLUMNS.index("fell")] == falls


def test_a_slippery_floor_holds_no_foot_until_it_grips():
    slips = []
    for friction in (None, 0.003):
        plant = make()
        power(plant)
        plant.advance(0.2)
        plant.inject("floor_slippery", friction or 0.8)
        plant.inject("left.push", 1.0)
        plant.advance(0.6)
        slips.append(dict(zip(COLUMNS, plant.truth(), strict=True))["slip_left"])
    assert slips[1] > 3e-3 > slips[0]
    plant.inject("floor_grips")
    nominal = make().model.geom("floor").friction[0]
    assert plant.model.geom("floor").friction[0] == nominal
    for wrong in ("floor_slippery", "left.push"):
        with pytest.raises(ValueError, match="plant"):
            plant.inject(wrong, math.nan)
    with pytest.raises(ValueError, match="known are"):
        plant.inject("blocked")


def test_robot_without_torque_collapses():
    plant = make()
    power(plant)
    plant.advance(0.5)
    power(plant, torque_on=False)
    plant.advance(2.5)
    truth = dict(zip(COLUMNS, plant.truth(), strict=True))
    assert truth["fell"] == 1.0
    assert truth["waist_z"] < 0.15


def test_units_differ_by_seed_only():
    def stand(seed, **changes):
        plant = make(seed, **changes)
        power(plant)
        plant.advance(0.5)
        return plant.truth()

    assert stand(1) == stand(1)
    assert stand(1) != stand(2)
    equal = {"mass_spread": 0.0, "friction_spread": 0.0}
    assert stand(1, **equal) == stand(2, **equal)


def test_pieces_of_time_do_not_matter():
    whole, pieces = make(), make()
    for plant in (whole, pieces):
        power(plant)
        plant.command_joint(3, plant.joint_position(3) + 0.05, 0.0, True)
    whole.advance(0.3)
    for k in range(1, 501):
        pieces.advance(0.3 * k / 500)
    assert whole.data.qpos.tolist() == pieces.data.qpos.tolist()


def test_servo_turns_no_faster_and_pulls_no_harder_than_it_can():
    plant = make()
    power(plant)
    plant.advance(0.5)
    # A knee that is told to leap, as the plain law tells it near the straight position.
    plant.command_joint(3, plant.joint_position(3) + 0.8, 0.0, True)
    most_rate = most_torque = 0.0
    saturated = False
    for k in range(60):
        plant.advance(0.5 + 2.5e-3 * (k + 1))
        most_rate = max(most_rate, plant.joint_velocity(3))
        most_torque = max(most_torque, abs(plant.joint_torque(3)))
        saturated |= plant.truth()[COLUMNS.index("saturated")] > 0.0
    assert most_rate < 1.3 * GEOMETRY.max_rate
    assert most_torque <= GEOMETRY.torque_peak[3] + 1e-12
    assert saturated


def test_joint_without_torque_turns_freely():
    plant = make()
    power(plant)
    plant.advance(0.2)
    plant.command_joint(9, 0.0, 0.0, False)
    plant.advance(0.6)
    assert plant.joint_torque(9) == 0.0
    assert plant.joint_position(9) > math.radians(36.39) + 0.015  # it gives way under the weight


def test_initial_height_beyond_the_leg_is_refused():
    with pytest.raises(
        ValueError, match=r"initial_hip_height \(0\.21 m\): the leg reaches 0 … 0\.2"
    ):
        make(initial_hip_height=0.21)


def test_walk_of_48_seconds(walk):
    assert not walk.fell
    assert walk.advance >= 0.110
    assert walk.knee_torque < 1.2
    assert 0.5 < walk.support_torque < 0.7
    assert walk.slip < 0.012
    assert walk.saturated == 0.0


def test_feet_swing_and_stand_in_their_order(walk):
    loads = np.array([walk.truth["load_right"], walk.truth["load_left"]])
    in_swing = [loads[0, round(t / PERIOD)] for t in (7.5, 37.5)]
    in_swing.append(loads[1, round(22.5 / PERIOD)])
    assert max(in_swing) == 0.0
    in_shift = loads[:, round(15.0 / PERIOD)]
    assert min(in_shift) > 10.0


def test_plain_law_saturates_at_five_times_the_speed_and_the_trapezoid_does_not():
    fast = WalkSettings(speed=5.0)
    plain, trapezoid = (Walk(law, fast) for law in ("inverse", "sc-trapezoid"))
    assert plain.saturated > 0.01
    assert plain.knee_torque == pytest.approx(GEOMETRY.torque_peak[3])
    assert trapezoid.saturated == 0.0
    assert trapezoid.knee_torque < 1.2
    assert not trapezoid.fell


def test_robot_stands_the_fastest_walk_in_balance_and_falls_in_the_rival_s_time():
    """As the plans' margins say: the trapezoid keeps 5 mm in 5.25 s, minimum jerk does not."""
    fast = WalkSettings(speed=48.0 / 5.25)
    assert not Walk("sc-trapezoid", fast).fell
    assert Walk("min-jerk", fast).fell


@pytest.mark.slow
def test_straighter_standing_knee_saves_torque(walk):
    bob = Walk("sc-trapezoid", WalkSettings(bob=BobSettings()))
    bent = Walk("sc-trapezoid", WalkSettings(knee_min=math.radians(30.0)))
    assert not bob.fell
    assert not bent.fell
    assert bob.support_torque < 0.65 * walk.support_torque
    assert bent.support_torque > 1.7 * walk.support_torque


def test_squat_from_straight_knees_leaves_the_robot_where_it_was():
    squat = Walk("sc-trapezoid", SquatSettings())
    assert not squat.fell
    assert abs(squat.advance) < 1e-3
    assert np.ptp(squat.truth["waist_z"]) == pytest.approx(0.040, abs=0.002)


@pytest.mark.slow
def test_stiffer_servos_lose_less_of_the_way(walk):
    stiff = make(servo=LegServoSettings(stiffness=400.0))
    assert Walk("sc-trapezoid", WalkSettings(), stiff).advance > walk.advance + 1e-3


def test_robot_slips_on_ice():
    fast = WalkSettings(speed=5.0)
    floor, ice = (Walk("sc-trapezoid", fast, make(floor_friction=mu)) for mu in (0.8, 0.03))
    assert ice.slip > 3.0 * floor.slip


@pytest.mark.parametrize("slope", [0.0, 0.2, -0.15])
def test_terrain_has_its_upper_side_where_the_settings_say(slope):
    """A ray from above meets it: MuJoCo's own geometry is the oracle."""
    block = TerrainBlock(start=0.3, length=0.5, height=0.1, slope=slope)
    plant = make(terrain=(block,))
    found = np.zeros(1, np.int32)
    for ahead in (0.02, 0.25, 0.48):
        top = np.array((0.3 + ahead, 0.4, 1.0))
        down = mujoco.mj_ray(
            plant.model, plant.data, top, np.array((0.0, 0.0, -1.0)), None, 1, -1, found
        )
        assert plant.model.geom(int(found[0])).name == "terrain_0"
        assert 1.0 - down == pytest.approx(0.1 + ahead * math.tan(slope), abs=1e-9)
    before = np.array((0.2, 0.4, 1.0))
    down = mujoco.mj_ray(
        plant.model, plant.data, before, np.array((0.0, 0.0, -1.0)), None, 1, -1, found
    )
    assert 1.0 - down <= max(0.0, 0.1 - 0.1 * math.tan(slope)) + 1e-9


def test_a_slippery_floor_is_slippery_on_its_treads_too():
    plant = make(terrain=(TerrainBlock(start=0.1, length=0.1, height=0.01),))
    grounds = [plant.model.geom(name).id for name in ("floor", "terrain_0")]
    own = plant.model.geom_friction[grounds, 0].copy()
    plant.inject("floor_slippery", 0.1)
    assert (plant.model.geom_friction[grounds, 0] == 0.1).all()
    plant.inject("floor_grips")
    np.testing.assert_array_equal(plant.model.geom_friction[grounds, 0], own)


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (0.1, 0.0), (0.0, -0.06), (-0.07, 0.05)])
def test_a_robot_stands_ready_upright_on_a_floor_that_slopes(pitch, roll):
    """Both soles flat on it, by MuJoCo's own kinematics; and it stays there on its servos."""
    plant = make(floor_pitch=pitch, floor_roll=roll, servo=LegServoSettings(stiffness=1000.0))
    turned = plant.data.geom("right_sole").xmat.reshape(3, 3)
    normal = turned[:, 2].copy()
    np.testing.assert_allclose(turned, plant.data.geom("left_sole").xmat.reshape(3, 3), atol=1e-12)
    np.testing.assert_allclose(
        plant.data.geom("floor").xmat.reshape(3, 3)[:, 2], normal, atol=1e-12
    )
    assert math.atan2(normal[0], normal[2]) == pytest.approx(pitch)
    assert -math.asin(normal[1]) == pytest.approx(roll)
    for leg, side in (("right", -1.0), ("left", 1.0)):
        sole = plant.data.site(f"{leg}_sole").xpos
        np.testing.assert_allclose(sole[:2], (0.0, side * GEOMETRY.hip_half_spacing), atol=1e-12)
        assert abs(normal @ sole) < 1e-12
    truth = dict(zip((name for name, _ in plant.truth_columns), plant.truth(), strict=True))
    assert (truth["waist_roll"], truth["waist_pitch"]) == (0.0, 0.0)
    for channel in range(12):
        plant.command_joint(channel, plant.joint_position(channel), 0.0, True)
    plant.advance(2.0)
    truth = dict(zip((name for name, _ in plant.truth_columns), plant.truth(), strict=True))
    assert truth["fell"] == 0.0
    assert max(truth["slip_right"], truth["slip_left"]) < 2e-3
    assert abs(truth["waist_pitch"]) < 0.03
