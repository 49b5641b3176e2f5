"""The compiled loop that gains are tried on is the loop that experiments run."""

import numpy as np
import pytest

import rig
from controllers.cylinder.types import PairReference, PairState
from controllers.minimum_jerk import minimum_jerk
from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from rig.assembly import REGISTRY, Backend
from rig.assembly.simulated import build_sim, lend_plant
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal.plant import LentPlant
from rig.mechanisms.cylinder.bench import PairBench
from rig.mechanisms.cylinder.mechanism import AntagonisticPair

REAL = "plant.model=antagonistic-pair"
FAR = "cylinder.limits.following=15 mm"
GENTLE = {
    "cascade": tuple(f"controllers.cascade.{gain}" for gain in (
        "position_rate=100", "velocity_rate=140", "integral=6e3", "hold_integral=200",
        "observer_bandwidth=1000", "force_trust=0.7", "lead_bandwidth=220",
        "disturbance_gain=0.02", "disturbance_bandwidth=160", "anticipation=0.3",
        "feedforward.gain=1", "feedforward.learning_rate=7",
    )),
    "pid": tuple(f"controllers.pid.{gain}" for gain in (
        "proportional=8e6", "integral=6e7", "derivative=1e5", "derivative_time=3 ms",
    )),
    "pid-friction": tuple(f"controllers.pid-friction.{gain}" for gain in (
        "proportional=8e6", "integral=6e7", "derivative=1e5", "lead_bandwidth=200",
    )),
    "super-twisting": tuple(f"controllers.super-twisting.{gain}" for gain in (
        "surface_rate=12", "disturbance_rate=200", "boundary=50 mm/s", "lead_bandwidth=200",
    )),
}  # fmt: skip
DEVICES = ("regulators", "encoder-agonist")
READ = ("position_agonist", "position_antagonist", "pressure_agonist", "pressure_antagonist")
BLIND = tuple(
    f"cylinder.alarms.pressure.{alarm}"
    for alarm in ("deviation=499 kPa", "slow=50", "offset=499 kPa")
)
"""Regulators are drawn here that the profile's alarms would rightly call slow."""


def cases(laws, count=4):
    rng = np.random.default_rng(20261)
    for number in range(count):
        law = laws[number % len(laws)]
        yield law, (
            f"simulation.seed={rng.integers(1000)}",
            f"plant.friction_scale={rng.uniform(0.6, 1.3)}",
            f"plant.regulator.dead_time={rng.uniform(0, 8e-3)} s",
            f"plant.regulator.bandwidth={rng.uniform(35, 50)} rad/s",
            f"plant.regulator.pilot={rng.choice(['linear', 'switched'])}",
            f"plant.tube.length={rng.uniform(0.5, 2.0)} m",
            "plant.regulator.monitor_noise=0", "plant.encoder_noise=0 m",
            f"reference.amplitude={rng.uniform(2e-3, 6e-3)} m",
        )  # fmt: skip


def planned(law, options):
    options = (REAL, FAR, *BLIND, *GENTLE[law], *options, f"controller={law}")
    return load_plan("cylinder-ideal-step" if law == "pid" else "cylinder-ideal-sine", options)


@pytest.mark.parametrize(("law", "options"), list(cases(("cascade", "pid"))))
def test_a_lent_plant_and_its_devices_do_to_the_bit_what_those_of_a_run_do(law, options, tmp_path):
    options = [o for o in options if "amplitude" not in o or law == "cascade"]
    plan = planned(law, options)
    data = rig.load(run_experiment(plan, Backend.SIM, tmp_path, report=False).path).data
    regulators, rod = (build_sim(plan.profile).devices[name] for name in DEVICES)
    plant = AntagonisticPairPlant(plan.profile.plant.settings, plan.profile.simulation.seed)
    lent = LentPlant(*plant.lend(1e-3, rod.resolution, regulators.resolution, 0), 2)
    seen, truth = np.zeros(4), np.zeros(1)
    applied = np.stack([data["applied.agonist"], data["applied.antagonist"]], 1)
    shown = np.stack([data[f"reading.{name}"] for name in READ], 1)
    assert len(data) > 5000
    assert np.ptp(data["truth.position"]) > 2e-3
    for cycle, setpoints in enumerate(applied):
        if cycle > 0:
            assert seen.tolist() == shown[cycle].tolist(), cycle
        assert truth[0] == data["truth.position"][cycle], cycle
        lent.exchange(lent.memory, setpoints, seen, truth)


@pytest.mark.parametrize(("law", "options"), list(cases(tuple(GENTLE))))
def test_the_compiled_loop_does_to_the_bit_what_law_and_limits_do_one_by_one(law, options):
    plan = planned(law, [o for o in options if "amplitude" not in o])
    profile, cycles = plan.profile, 4000
    settings, period = profile.mechanism_settings, profile.loop.period
    kind = REGISTRY.load("controller", f"cylinder/{law}")

    def lend(told, seed):
        return lend_plant(profile, told, seed)

    bench = PairBench(settings, kind, period, lend, (plan.motion,))
    told = bench.told()
    trace, _ = bench.run(profile.controllers[law], told, 5)

    controller = kind(profile.controllers[law], AntagonisticPair.model_of(settings), period)
    view = build_sim(profile).mechanism
    lent, seen, truth = lend(told, 5), np.zeros(4), np.zeros(1)
    for _ in range(1000):
        lent.exchange(lent.memory, np.full(2, settings.base_pressure), seen, truth)
    state = PairState(0.0, 0.5 * (seen[1] - seen[0]), seen[2], seen[3])
    controller.reset(state)
    view.start_limiting(state)
    for cycle in range(cycles):
        before = cycle < 1000
        way = minimum_jerk(0.0, plan.motion.at(0.0).position, 1.0, cycle * period)
        wanted = PairReference(*way) if before else plan.motion.at((cycle - 1000) * period)
        applied = view.limit(controller.update(state, wanted))
        position, difference = 0.5 * (seen[1] - seen[0]), seen[2] - seen[3]
        read = (applied[0] - applied[1], position, difference)
        assert (truth[0], *applied, *read) == tuple(trace[cycle]), cycle
        lent.exchange(lent.memory, np.array(applied), seen, truth)
        state = PairState(0.0, 0.5 * (seen[1] - seen[0]), seen[2], seen[3])


def test_the_plant_that_is_as_told_slides_with_the_friction_that_was_told():
    """Judged by the forces of a slow motion, whatever names a plant has for its friction."""
    rng = np.random.default_rng(4)
    plan = load_plan("cylinder-ideal-sine", (REAL,))
    profile = plan.profile
    for _ in range(4):
        factor = rng.uniform(0.5, 2.0)
        bench = PairBench(
            profile.mechanism_settings, REGISTRY.load("controller", "cylinder/cascade"),
            profile.loop.period, lambda told, seed: lend_plant(profile, told, seed),
        )  # fmt: skip
        told = bench.told()
        true = {**told, **{name: factor * told[name] for name in ("coulomb", "viscous")}}
        lent = lend_plant(profile, true, int(rng.integers(100)))
        seen, truth = np.zeros(4), np.zeros(1)
        path, forces = [], []
        base = told["base_pressure"]
        for k in range(8000):
            half = max(0.0, k - 1000) * 12.0  # a slow ramp: it slides from some point on
            lent.exchange(lent.memory, np.array([base + half, base - half]), seen, truth)
            path.append(truth[0])
            forces.append(told["area"] * (seen[2] - seen[3]))
            if truth[0] > 10e-3:
                break
        speed = np.gradient(path, 1e-3)
        sliding = (np.array(path) > 2e-3) & (np.array(path) < 9e-3)
        acceleration = np.gradient(speed, 1e-3)
        friction = np.array(forces) - told["mass"] * acceleration - true["viscous"] * speed
        # Units differ by 15 %, and the seals' friction grows with the pressures.
        assert np.median(friction[sliding]) == pytest.approx(true["coulomb"], rel=0.25)


def test_a_plant_that_swings_out_is_lost_and_says_when():
    plan = load_plan(
        "cylinder-ideal-sine", (REAL, *GENTLE["pid"], "controllers.pid.proportional=4e8")
    )
    profile = plan.profile
    bench = PairBench(
        profile.mechanism_settings, REGISTRY.load("controller", "cylinder/pid"),
        profile.loop.period, lambda told, seed: lend_plant(profile, told, seed),
    )  # fmt: skip
    true = {**bench.told(), "regulator_dead_time": 60e-3, "coulomb": 1.0, "viscous": 5.0}
    trial = bench.trial(profile.controllers["pid"], true, 1)
    assert trial.lasted < 1.0 or trial.hunting > 5e-3
    (margin,) = bench.margins(profile.controllers["pid"], [true])
    assert not margin.stable
