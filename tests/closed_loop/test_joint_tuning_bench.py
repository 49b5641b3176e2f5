"""The compiled loop that a joint's gains are tried on is the loop that experiments run."""

import math

import numpy as np
import pytest

import rig
from controllers.spherical_joint.falling import falling_pull, falling_stiffness
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import JointReference, JointState
from controllers.spherical_joint.wires import InverseKinematics
from drivers.sim.plants.spherical_joint import SphericalJointPlant
from rig.assembly import REGISTRY, Backend
from rig.assembly.simulated import build_sim, lend_plant
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal.plant import LentPlant
from rig.mechanisms.joint.bench import JointBench
from rig.mechanisms.joint.mechanism import SphericalJoint

LAW = REGISTRY.load("controller", "joint/cascade")
PAIR = "controllers.cascade.pair"
STEADY = (
    "plant.model=spherical-joint", "joint.base_pressure=80 kPa",
    "joint.limits.following=30 mm", "controllers.cascade.dither.amplitude=0 kPa",
    "joint.regulator_response.dead_time=16 ms", "joint.regulator_response.monitor_time=5 ms",
    "plant.regulator.monitor_noise=0", "plant.encoder_noise=0 m",
    *(f"{PAIR}.{gain}" for gain in (
        "trim_rate=3", "position_rate=118", "velocity_rate=90", "tuned_viscous=null",
        "integral=5e3", "hold_integral=500", "observer_bandwidth=700", "force_trust=0.1",
        "lead_bandwidth=200", "disturbance_gain=0.03", "anticipation=0.36",
    )),
    *(f"joint.alarms.pressure.{alarm}" for alarm in (
        "deviation=499 kPa", "slow=50", "offset=499 kPa",
    )),
)  # fmt: skip
"""Gains that bear the regulators, and alarms that let drawn ones be."""


def drawn(count=2):
    rng = np.random.default_rng(20262)
    for number in range(count):
        yield (
            f"simulation.seed={rng.integers(1000)}",
            f"plant.friction_scale={rng.uniform(0.7, 1.2)}",
            f"plant.regulator.dead_time={rng.uniform(0, 6e-3)} s",
            f"plant.regulator.pilot={('linear', 'switched')[number % 2]}",
            f"plant.tube.length={rng.uniform(0.5, 2.0)} m",
            f"reference.poses=[{{tilt: 0 deg}}, {{tilt: {rng.uniform(8, 15)} deg}}, "
            f"{{tilt: 5 deg, azimuth: {rng.uniform(60, 300)} deg}}]",
            "reference.dwell=0.5 s",
        )


def planned(options):
    return load_plan("joint-poses", (*STEADY, *options))


def bench_of(plan):
    profile = plan.profile
    return JointBench(
        profile.mechanism_settings, LAW, profile.loop.period,
        lambda told, seed: lend_plant(profile, told, seed), (plan.motion,),
    )  # fmt: skip


@pytest.mark.parametrize("options", list(drawn()))
def test_a_lent_joint_and_its_devices_do_to_the_bit_what_those_of_a_run_do(options, tmp_path):
    plan = planned(options)
    data = rig.load(run_experiment(plan, Backend.SIM, tmp_path, report=False).path).data
    devices = build_sim(plan.profile).devices
    settings, seed = plan.profile.plant.settings, plan.profile.simulation.seed
    plant = SphericalJointPlant(settings, seed, plan.profile.nominal_settings.geometry)
    plant.advance(data["clock"][0])  # it settles on its wires before it has any air
    steps = devices["encoder-1"].resolution, devices["regulators"].resolution
    lent = LentPlant(*plant.lend(1e-3, *steps, 0), 4)
    seen, truth = np.zeros(8), np.zeros(3)
    applied = np.stack([data[f"applied.ch{k}"] for k in range(1, 5)], 1)
    rods = np.stack([data[f"reading.rod_ch{k}"] for k in range(1, 5)], 1)
    pressures = np.stack([data[f"reading.pressure_ch{k}"] for k in range(1, 5)], 1)
    markers = np.stack([data[f"truth.marker_{k}"] for k in "xyz"], 1)
    assert len(data) > 3000
    assert np.ptp(markers) > 5e-3
    home = plan.profile.mechanism_settings.home
    for cycle, setpoints in enumerate(applied):
        if cycle > 0:
            assert (home - seen[:4]).tolist() == rods[cycle].tolist(), cycle
            assert seen[4:].tolist() == pressures[cycle].tolist(), cycle
            assert truth.tolist() == markers[cycle].tolist(), cycle
        lent.exchange(lent.memory, setpoints, seen, truth)


@pytest.mark.parametrize("options", list(drawn()))
def test_the_compiled_loop_does_to_the_bit_what_law_and_limits_do_one_by_one(options):
    plan = planned(options)
    profile = plan.profile
    settings, period = profile.mechanism_settings, profile.loop.period
    bench = bench_of(plan)
    told = bench.told()
    trace, lasted = bench.run(profile.controllers["cascade"], told, 5)
    assert lasted == len(trace)

    controller = LAW(profile.controllers["cascade"], SphericalJoint.model_of(settings), period)
    view = build_sim(profile).mechanism
    lent, seen, truth = lend_plant(profile, told, 5), np.zeros(8), np.zeros(3)
    for _ in range(1000):
        lent.exchange(lent.memory, np.full(4, settings.base_pressure), seen, truth)

    def state():
        rods = tuple((settings.home - seen[:4]).tolist())
        return JointState(0.0, rods, tuple(seen[4:].tolist()))

    controller.reset(state())
    view.start_limiting(state())
    rest = (0.0, 0.0, 0.0)
    upright, first = JointReference((0.0, 0.0, 1.0), rest, rest), plan.motion.at(0.0)
    for cycle in range(2500):
        wanted = plan.motion.at((cycle - 1000) * period) if cycle >= 1000 else (
            SphericalJoint.approach(upright, first, 1.0, cycle * period)
        )  # fmt: skip
        applied = view.limit(controller.update(state(), wanted))
        read = (*state().rods, *state().pressures)
        off = np.array(controller.estimate.rods) - state().rods
        assert (*truth, *off, *applied, *read) == tuple(trace[cycle]), cycle
        lent.exchange(lent.memory, np.array(applied), seen, truth)


@pytest.mark.parametrize("seals", ["standard", "low-speed"])
def test_a_joint_that_is_told_the_friction_of_its_plant_gets_that_plant(seals):
    """Told more, seals and ball hold more by as much; told more of the ball, the ball alone."""
    rng = np.random.default_rng(8)
    plan = planned((f"plant.seals={seals}",))
    settings = plan.profile.plant.settings
    pressure, ring, wire = rng.uniform(60e3, 250e3), *rng.uniform(0.02, 0.2, 2)
    seal = {"standard": (3.0, 8e-3), "low-speed": (1.9, 3e-3)}[seals]
    told = {
        **bench_of(plan).told(), "base_pressure": pressure, "ring_friction": ring,
        "wire_friction": wire, "coulomb": 2.0 * (seal[0] + 4e-6 * pressure),
        "stribeck_velocity": seal[1],
    }  # fmt: skip
    contacts = {"standard": (0.08, 0.10), "low-speed": (0.04, 0.06)}[seals]
    for factor in (1.0, rng.uniform(0.5, 2.0)):
        more = {name: factor * told[name] for name in ("coulomb", "ring_friction", "wire_friction")}
        like = settings.believed({**told, **more})
        assert like.friction_scale == pytest.approx(factor)
        assert like.ring_friction_scale == pytest.approx(ring / contacts[0])
        assert like.wire_friction_scale == pytest.approx(wire / contacts[1])


def test_a_joint_that_falls_over_has_strayed_and_its_loop_is_not_stable():
    """Of whatever keeps the ring up nothing is left at a hundredth of the gains."""
    options = (*next(drawn()), f"{PAIR}.position_rate=1", f"{PAIR}.integral=0")
    plan = planned(options)
    profile, bench = plan.profile, bench_of(plan)
    told = bench.told()
    loose = {**told, **{name: 0.2 * told[name] for name in ("coulomb", "breakaway")}}
    trial = bench.trial(profile.controllers["cascade"], loose, 1)
    assert trial.lasted < 1.0 or min(trial.errors.values()) > 5e-3
    (margin,) = bench.margins(profile.controllers["cascade"], [told])
    assert not margin.stable


@pytest.mark.parametrize("seed", range(3))
def test_a_ring_is_pulled_on_by_as_much_as_the_work_of_its_wires_says(seed):
    """Of constant tensions the wires' work is the potential: no Jacobian of ours is in it."""
    rng = np.random.default_rng(seed)
    turn = rng.uniform(0.0, math.tau)
    geometry = SphericalJointGeometry(
        ball_radius=rng.uniform(20e-3, 30e-3),
        anchor_angles=tuple(turn + k * math.pi / 2 for k in range(4)),
    )
    tension = rng.uniform(10.0, 40.0)
    inverse, rest = InverseKinematics(geometry), (0.0, 0.0, 0.0)

    def rods(tilt):
        axis = axis_from_tilt(abs(tilt), turn + (0.0 if tilt >= 0.0 else math.pi))
        return np.array(inverse.motion(axis, rest, rest)[0])

    tilt = 0.02
    ahead, behind = rods(tilt), rods(-tilt)
    work = tension * (ahead.sum() + behind.sum())  # by tensions that pull the rods in
    way = 0.25 * (ahead[0] - ahead[2] - behind[0] + behind[2])
    assert falling_stiffness(geometry, tension) == pytest.approx(-work / way**2, rel=2e-3)


@pytest.mark.parametrize("seed", range(6))
def test_a_ring_that_leans_far_is_pulled_on_as_the_work_of_its_wires_says(seed):
    """Work over ways of 0.1 mm, at drawn poses within the tilt that it is exact at."""
    rng = np.random.default_rng(seed)
    turn, tilt = rng.uniform(0.0, math.tau), math.radians(rng.uniform(30.0, 45.0))
    geometry = SphericalJointGeometry(
        ball_radius=rng.uniform(20e-3, 30e-3),
        anchor_angles=tuple(turn + k * math.pi / 2 for k in range(4)),
    )
    inverse, rest, falling = (
        InverseKinematics(geometry),
        (0.0, 0.0, 0.0),
        falling_pull(geometry, tilt),
    )

    def pose(lean):
        """Return how far the pairs are off, and the sum of the rods, m."""
        size = math.hypot(*lean)
        axis = axis_from_tilt(size, turn + math.atan2(lean[1], lean[0]))
        rods = inverse.motion(axis, rest, rest)[0]
        return 0.5 * np.array([rods[0] - rods[2], rods[1] - rods[3]]), sum(rods)

    for _ in range(20):
        size, azimuth = rng.uniform(0.2, 1.0) * tilt, rng.uniform(0.0, math.tau)
        lean = size * np.array([math.cos(azimuth), math.sin(azimuth)])
        steps = 1e-4 * np.eye(2)
        ways = np.array([pose(lean + step)[0] - pose(lean - step)[0] for step in steps])
        work = np.array([pose(lean + step)[1] - pose(lean - step)[1] for step in steps])
        pulls, offs = np.linalg.solve(ways, work), pose(lean)[0]
        told = np.array([falling.pull(*offs), falling.pull(*offs[::-1])])
        assert told == pytest.approx(pulls, abs=0.15 * np.abs(pulls).max())
