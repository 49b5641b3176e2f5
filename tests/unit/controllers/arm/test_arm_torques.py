"""Drives of an arm with a payload: torques against MuJoCo, timing against a linear programme."""

import dataclasses
import re

import mujoco
import numpy as np
import pytest
import torque_oracle
from drawn_cases import WIDE, faults_of, hand_of
from test_arm_path import drawn, spline_of

from controllers.arm.dynamics.chain import ArmTorques
from controllers.arm.dynamics.settings import ArmDynamics, Payload
from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.plain import DampedLeastSquares, Inverse
from controllers.arm.promises import TooFast
from controllers.motion import InfeasibleMotion
from drivers.sim.plants.arm_model import ArmDeviations, build_model
from drivers.sim.plants.arm_settings import ArmLinkSettings, ArmPlantSettings

PERIOD = 5e-3
EVERY = range(6)


def drawn_arm(rng):
    return ArmGeometry(
        **WIDE,
        a2=float(rng.uniform(0.3, 0.5)), a3=float(rng.uniform(0.3, 0.5)),
        elbow_offset=float(rng.uniform(-0.1, 0.1)), shoulder_offset=float(rng.uniform(-0.1, 0.1)),
        a1=float(rng.uniform(-0.1, 0.1)), base_height=0.3, wrist_sign=int(rng.choice((-1, 1))),
    )  # fmt: skip


def rows(rng):
    return rng.normal(size=(3, 20, 6))


@pytest.mark.parametrize("seed", range(6))
def test_torques_of_rods_are_those_of_the_simulated_arm(seed):
    rng = np.random.default_rng((91, seed))
    geometry, dynamics = drawn_arm(rng), ArmDynamics()
    mass = float(rng.uniform(0.0, 5.0))
    settings = ArmPlantSettings(links=ArmLinkSettings(payload=mass))
    needs = torque_oracle.Needs(build_model(geometry, settings, ArmDeviations()), dynamics)
    ball = (0.4 * mass * 0.03**2,) * 3
    ours = ArmTorques(geometry, dynamics, Payload(mass, moments=ball))
    motion = rows(rng)
    np.testing.assert_allclose(ours.of(*motion), needs.of(*motion), atol=1e-10)


def drawn_links(rng):
    moments = rng.uniform(0.01, 0.015, (6, 3))  # of which two are together above the third
    return ArmDynamics(
        masses=tuple(rng.uniform(0.5, 8.0, 6).tolist()),
        centres=tuple(map(tuple, rng.uniform(-0.2, 0.2, (6, 3)).tolist())),
        moments=tuple(map(tuple, moments.tolist())),
        rotors=tuple(rng.uniform(0.0, 1.0, 6).tolist()),
        friction=tuple(rng.uniform(0.0, 5.0, 6).tolist()),
        viscous=tuple(rng.uniform(0.0, 5.0, 6).tolist()),
    )


@pytest.mark.parametrize("seed", range(8))
def test_torques_of_drawn_links_and_payloads_are_mujocos(seed):
    rng = np.random.default_rng((92, seed))
    geometry, dynamics = drawn_arm(rng), drawn_links(rng)
    centre, moments = rng.uniform(-0.1, 0.1, 3), rng.uniform(0.01, 0.015, 3)
    payload = Payload(float(rng.uniform(0.1, 5.0)), tuple(centre), tuple(moments))
    model = mujoco.MjModel.from_xml_string(torque_oracle.document(geometry, dynamics, payload))
    needs = torque_oracle.Needs(model, dynamics)
    motion = rows(rng)
    ours = ArmTorques(geometry, dynamics, payload)
    np.testing.assert_allclose(ours.of(*motion), needs.of(*motion), atol=1e-9)
    still = np.zeros_like(motion[0])
    np.testing.assert_allclose(
        ours.weight(motion[0]), needs.moved(motion[0], still, still), atol=1e-9
    )


def case(seed):
    """Return an arm whose drives are too weak for a path at full speed, and that path."""
    rng = np.random.default_rng((93, seed))
    dynamics = ArmDynamics(
        viscous=tuple((np.array(ArmDynamics().viscous) * rng.uniform(0.0, 1.5)).tolist()),
    )
    geometry = ArmGeometry(**WIDE, dynamics=dynamics)
    payload = Payload(float(rng.uniform(0.0, 1.5)), tuple(rng.uniform(-0.05, 0.05, 3).tolist()))
    path = dataclasses.replace(drawn(seed), speed=1.0, payload=payload)
    made = plan(geometry, path)
    unit = np.array(dynamics.torque_limits)
    held, needed = (
        of(geometry, path, made).max(axis=0) * unit for of in (shares_at_rest, shares_of)
    )
    limits = np.maximum(1.05 * held, held + rng.uniform(0.3, 0.8, 6) * (needed - held))
    dynamics = dataclasses.replace(dynamics, torque_limits=tuple(limits.tolist()))
    return dataclasses.replace(geometry, dynamics=dynamics), dataclasses.replace(path, torques=True)


def plan(geometry, path, **settings):
    return LookAhead(LookAheadSettings(**settings), geometry, PERIOD).prepare(path)


def shares_of(geometry, path, made):
    needs = needs_of(geometry, path)
    return np.abs(needs.of(*torque_oracle.halfway(made))) / geometry.dynamics.torque_limits


def needs_of(geometry, path):
    settings = ArmPlantSettings(links=ArmLinkSettings(payload=0.0))
    model = build_model(geometry, settings, ArmDeviations())
    document = with_payload(geometry, settings, path.payload)
    return torque_oracle.Needs(document or model, geometry.dynamics)


def with_payload(geometry, settings, payload):
    """Return the simulated arm with a payload of the tests' own."""
    if payload.mass == 0.0:
        return None
    from drivers.sim.plants.arm_model import HAND, describe_model

    text = describe_model(geometry, settings, ArmDeviations())
    hand = np.array((0.0, 0.0, geometry.d6)) + payload.centre
    site = text.index(f'<site name="{HAND}"')
    load = torque_oracle.inertial(payload.mass, (0, 0, 0), np.maximum(payload.moments, 1e-9))
    body = f'<body pos="{torque_oracle.numbers(hand)}">{load}</body>'
    return mujoco.MjModel.from_xml_string(text[:site] + body + text[site:])


@pytest.mark.sampled(3)
# Number 6 all but turns back between two samples, which are all that the oracle knows of the curve.
@pytest.mark.parametrize(
    "seed",
    [0, 2, *(pytest.param(k, marks=pytest.mark.slow) for k in range(16) if k not in (0, 2, 6))],
)
def test_no_drive_gives_more_than_it_can_and_nobody_is_much_faster(seed):
    geometry, path = case(seed)
    made = plan(geometry, path)
    assert faults_of(geometry, path, made, EVERY, EVERY) == []
    assert shares_of(geometry, path, made).max() <= 1.0015
    free = plan(geometry, dataclasses.replace(path, torques=False))
    assert shares_of(geometry, path, free).max() > 1.1  # else there was nothing to keep
    best = torque_oracle.least_time(
        geometry, geometry.dynamics, needs_of(geometry, path), made,
        lambda q: hand_of(geometry, q)[0], path.speed,
    )  # fmt: skip
    assert made.duration <= 1.02 * best
    assert made.duration >= 0.99 * best  # faster than the optimum is wrong, too


@pytest.mark.parametrize("seed", [6, *(pytest.param(k, marks=pytest.mark.slow) for k in (13, 17))])
def test_a_path_that_all_but_turns_back_within_a_tenth_of_a_millimetre_is_kept(seed):
    path, strong = drawn(seed), ArmDynamics(torque_limits=(1e5,) * 6)
    geometry = ArmGeometry(**WIDE)
    made = plan(geometry, path)
    at, tool = hand_of(geometry, path.near)
    spline, end = spline_of(np.array(path.points) @ tool.T + at)
    fine = spline(np.linspace(0.0, end, 400_000))
    hands = np.array([hand_of(geometry, q)[0] for q in made.positions[::3].tolist()])
    assert max(np.linalg.norm(fine - hand, axis=1).min() for hand in hands) < 2e-6
    assert faults_of(geometry, path, made, EVERY, EVERY) == []
    best = torque_oracle.least_time(
        geometry, strong, needs_of(dataclasses.replace(geometry, dynamics=strong), path), made,
        lambda q: hand_of(geometry, q)[0], path.speed,
    )  # fmt: skip
    assert made.duration <= 1.02 * best


def test_strong_drives_change_nothing():
    geometry, path = case(0)
    strong = dataclasses.replace(geometry.dynamics, torque_limits=(1e5,) * 6)
    geometry = dataclasses.replace(geometry, dynamics=strong)
    made, free = plan(geometry, path), plan(geometry, dataclasses.replace(path, torques=False))
    np.testing.assert_allclose(made.positions, free.positions, atol=1e-12)


def test_a_share_of_the_torques_is_kept():
    geometry, path = case(2)
    limits = tuple(limit / 0.8 for limit in geometry.dynamics.torque_limits)
    stronger = dataclasses.replace(geometry.dynamics, torque_limits=limits)
    stronger = dataclasses.replace(geometry, dynamics=stronger)
    made = plan(stronger, path, torque_share=0.8)
    assert shares_of(stronger, path, made).max() <= 0.8 * 1.0015
    assert made.duration == pytest.approx(plan(geometry, path).duration, rel=1e-6)
    with pytest.raises(InfeasibleMotion, match=r"beyond 98 % of the \S+ N m that it may have"):
        plan(geometry, path, torque_share=0.3)


@pytest.mark.parametrize(("law", "seed"), [(Inverse, 2), (DampedLeastSquares, 0)])
def test_another_law_is_refused_where_a_drive_needs_more_than_it_has(law, seed):
    """Its time is the path's own: it is told a speed at which that suffices."""
    geometry, path = case(seed)
    follower = law(law.Settings(), geometry, PERIOD)
    slow = dataclasses.replace(path, speed=0.02)
    assert shares_of(geometry, slow, follower.prepare(slow))[1:].max() <= 1.001
    fast = dataclasses.replace(path, speed=1.0)
    needed = shares_of(geometry, fast, follower.prepare(dataclasses.replace(fast, torques=False)))
    assert needed.max() > 1.1
    with pytest.raises(InfeasibleMotion) as refused:
        follower.prepare(fast)
    speed = re.search(r"q\d would need \S+ N m, beyond its.*; at (\S+) m/s it", str(refused.value))
    fits = dataclasses.replace(path, speed=float(speed[1]))
    assert shares_of(geometry, fits, follower.prepare(fits)).max() <= 1.0015


def test_who_says_no_masses_is_timed_under_no_torques():
    path = dataclasses.replace(drawn(0), torques=True)
    with pytest.raises(InfeasibleMotion, match=r"give geometry\.dynamics"):
        plan(ArmGeometry(**WIDE), path)


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2, 3))])
def test_a_payload_that_is_too_heavy_is_refused_with_one_that_is_held(seed):
    geometry, path = case(seed)
    heavy = dataclasses.replace(path, payload=dataclasses.replace(path.payload, mass=30.0))
    with pytest.raises(InfeasibleMotion) as refused:
        plan(geometry, heavy)
    said = str(refused.value)
    joint, torque, limit, most = re.search(
        r"path q(\d) would need (\S+) N m .* of the (\S+) N m that .*: (\S+) kg would be held", said
    ).groups()
    assert float(limit) == pytest.approx(geometry.dynamics.torque_limits[int(joint) - 1], rel=1e-5)
    held = shares_at_rest(
        geometry, heavy, plan(geometry, dataclasses.replace(heavy, torques=False))
    )
    worst = held[:, int(joint) - 1].max() * geometry.dynamics.torque_limits[int(joint) - 1]
    assert float(torque) == pytest.approx(worst, rel=2e-3)
    for mass, fits in ((float(most), True), (1.01 * float(most) + 2e-3, False)):
        other = dataclasses.replace(path, payload=dataclasses.replace(path.payload, mass=mass))
        if fits:
            assert shares_of(geometry, other, plan(geometry, other)).max() <= 1.0015
        else:
            with pytest.raises(InfeasibleMotion, match="would be held"):
                plan(geometry, other)


@pytest.mark.parametrize("law", [Inverse, DampedLeastSquares])
def test_every_law_names_the_payload_that_no_speed_makes_lighter(law):
    geometry, path = case(0)
    heavy = dataclasses.replace(
        path, speed=0.02, payload=dataclasses.replace(path.payload, mass=30.0)
    )
    said = []
    for prepare in (
        law(law.Settings(), geometry, PERIOD).prepare,
        lambda path: plan(geometry, path),
    ):
        with pytest.raises(InfeasibleMotion) as refused:
            prepare(heavy)
        said.append(re.search(r"(\S+) kg would be held", str(refused.value))[1])
    assert float(said[0]) == pytest.approx(float(said[1]), rel=0.01)


class Hesitant(Inverse):
    """A law that says each time that a little slower would do."""

    fits = 0.3

    def _planned(self, path):
        if path.speed > self.fits:
            raise TooFast(f"at {path.speed:g} m/s a joint is too fast", 1.01)
        return super()._planned(path)


def test_a_speed_is_found_though_each_slower_one_needs_another_one():
    geometry, path = case(0)
    fast = dataclasses.replace(path, torques=False, speed=1.0)
    with pytest.raises(InfeasibleMotion) as refused:
        Hesitant(Hesitant.Settings(), geometry, PERIOD).prepare(fast)
    (speed,) = re.findall(r"at (\S+) m/s it would fit", str(refused.value))
    assert 0.15 < float(speed) <= Hesitant.fits


def shares_at_rest(geometry, path, made):
    """Return weight and dry friction, in whichever sense the joint goes, over the limits."""
    q, v, _ = torque_oracle.halfway(made)
    still = np.zeros_like(q)
    needs = needs_of(geometry, path)
    held = needs.moved(q, still, still) + needs.dry * np.sign(v)
    return np.abs(held) / geometry.dynamics.torque_limits


@pytest.mark.parametrize("which", ["centres", "moments"])
def test_centres_and_moments_belong_together(which):
    with pytest.raises(ValueError, match="belong together"):
        ArmDynamics(**{which: ((0.1, 0.1, 0.1),) * 6})
