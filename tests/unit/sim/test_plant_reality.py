"""What a catalogue says of regulators, tubes and encoders, on drawn plants."""

import math
from dataclasses import replace

import numpy as np
import pytest
from joint_bench import EQUAL, joint
from scipy.linalg import expm

from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.regulator_settings import (
    RealRegulatorSettings,
    RealTubeSettings,
    RegulatorSettings,
    TubeSettings,
)
from drivers.sim.plants.settings import PlantSettings, RealPairSettings
from drivers.sim.plants.tube import segment_numbers, step_flow

DT = 50e-6
FULL_SCALE = 0.5e6
AIR = 287.05 * 293.15


def at_rest(settings, pressure, seed=0, until=2.0):
    """Return a plant with both chambers at rest at `pressure`, Pa gauge."""
    plant = AntagonisticPairPlant(settings, seed)
    plant.set_supply(True)
    command(plant, pressure)
    plant.advance(until)
    return plant


def command(plant, pressure):
    for channel in range(len(plant.channel_names)):
        plant.set_pressure_setpoint(channel, pressure)


def watch(plant, cell, duration, step=DT):
    """Return times from now (s) and a cell of every channel, shape (n, channels)."""
    began = plant.time
    times, values = [], []
    for k in range(round(duration / step)):
        plant.advance(began + (k + 1) * step)
        times.append(plant.time - began)
        values.append(plant.channels[cell].copy())
    return np.array(times), np.array(values)


@pytest.mark.parametrize("seed", range(4))
def test_nothing_moves_before_the_dead_time_of_the_unit(seed):
    drawn = np.random.default_rng(seed)
    dead = float(drawn.uniform(1e-3, 20e-3))
    spread = float(drawn.uniform(0.0, 0.3))
    regulator = RegulatorSettings(dead_time=dead, dead_time_spread=spread)
    plant = at_rest(PlantSettings(regulator=regulator), 120e3, seed)
    command(plant, 180e3)
    times, play = watch(plant, "play", 2.0 * dead)
    begun = times[np.argmax(np.abs(play - play[0]) > 1e3, axis=0)]
    assert np.all(np.abs(begun - dead) <= spread * dead + 2 * DT)
    if spread * dead > 1e-3:
        assert begun[0] != begun[1], "each unit has its own"


def test_a_setpoint_that_is_gone_before_it_is_sampled_is_never_seen():
    plant = at_rest(PlantSettings(regulator=RegulatorSettings(sampling=20e-3)), 120e3)
    _, sampled = watch(plant, "sampled", 60e-3)
    taken = [1 + np.flatnonzero(np.diff(plant_k)) for plant_k in sampled.T]
    assert all(len(t) == 0 for t in taken), "nothing new was asked for"
    seen = 0
    for k in range(40):  # a pulse of 5 ms every 25 ms: a quarter of the samples meets one
        command(plant, 300e3)
        plant.advance(2.06 + 0.025 * k + 0.005)
        command(plant, 120e3)
        plant.advance(2.06 + 0.025 * (k + 1))
        seen += bool(plant.channels[0]["pilot"] > 125e3)
    assert 0 < seen < 40


@pytest.mark.parametrize("seed", range(3))
def test_each_reversal_is_met_with_an_error_of_its_own_within_the_repeatability(seed):
    regulator = RegulatorSettings(linearity=0.0, bandwidth_spread=0.0, repeatability=0.01)
    exact = RegulatorSettings(linearity=0.0, bandwidth_spread=0.0)
    ends = []
    for settings in (regulator, exact):
        plant = at_rest(PlantSettings(regulator=settings, friction_spread=0.0), 100e3, seed)
        found = []
        for _ in range(12):
            for level in (200e3, 100e3):
                command(plant, level)
                plant.advance(plant.time + 0.4)
            found.append(float(plant.channels[0]["pressure"]))
        ends.append(np.array(found))
    off = ends[0] - ends[1]
    assert np.all(np.abs(off) <= 0.01 * FULL_SCALE + 600.0)  # and the overlap on either side
    assert np.ptp(off) > 0.005 * FULL_SCALE


def test_a_regulator_holds_its_least_pressure_while_it_has_supply_and_vents_without():
    plant = at_rest(PlantSettings(regulator=RegulatorSettings(least=5e3)), 120e3)
    command(plant, 0.0)
    plant.advance(4.0)
    gauge = plant.channels["pressure"] - ATMOSPHERE
    assert np.all((gauge > 4e3) & (gauge < 6e3))
    plant.set_supply(False)
    plant.advance(5.0)
    assert np.all(plant.channels["pressure"] - ATMOSPHERE < 600.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_switched_pilot_follows_and_comes_to_rest_within_its_window(seed):
    drawn = np.random.default_rng(seed)
    regulator = RealRegulatorSettings(pilot="switched", repeatability=0.0)
    plant = at_rest(RealPairSettings(regulator=regulator), 120e3, seed)
    for level in drawn.uniform(30e3, 400e3, 6):
        command(plant, float(level))
        plant.advance(plant.time + 0.8)
        _, pressure = watch(plant, "pressure", 0.1, 1e-3)
        # Bow 1 %, half the loop, sensitivity and a pulse of the pilot.
        assert np.all(np.abs(pressure - ATMOSPHERE - level) < 0.02 * FULL_SCALE)
        assert np.all(np.ptp(pressure, axis=0) < 0.01 * FULL_SCALE)


def test_a_switched_pilot_fills_and_exhausts_at_speeds_of_their_own():
    plant = at_rest(RealPairSettings(regulator=RealRegulatorSettings(pilot="switched")), 100e3)
    rates = []
    for level in (450e3, 50e3):
        command(plant, level)
        _, pilot = watch(plant, "pilot", 0.3)
        rates.append(np.max(np.abs(np.diff(pilot[:, 0]))) / DT)
        assert rates[-1] <= plant.settings.regulator.pilot_rate * (1 + 1e-9)
    assert rates[0] > 1.2 * rates[1]


def steady_flow(segment, bore, upstream, downstream):
    flow = 0.0
    for _ in range(20_000):
        flow = step_flow(flow, upstream, downstream, *segment_numbers(segment, bore), DT)
    return flow


@pytest.mark.parametrize("drop", [30.0, 300.0, 3e3, 30e3])
def test_the_steady_flow_of_a_tube_is_that_of_a_smooth_pipe(drop):
    """Solved with the other form of the law: the head that a given flow loses."""
    bore, segment, middle = 2.5e-3, 0.4, 3e5
    flow = steady_flow(segment, bore, middle + drop / 2, middle - drop / 2)
    density, viscosity = middle / AIR, 1.81e-5
    speed = flow / (density * math.pi / 4 * bore**2)
    reynolds = density * speed * bore / viscosity
    laminar = 32.0 * viscosity * segment * speed / bore**2
    blasius = 0.1582 * density**0.75 * viscosity**0.25 * bore**-1.25 * speed**1.75 * segment
    assert max(laminar, blasius) == pytest.approx(drop, rel=2e-3)
    assert (laminar > blasius) == (reynolds < 1189), "they cross there"


def acoustic_line(p, volume, middle, segments):
    """Return the matrix of a line's linear acoustics: pressures and then flows between them."""
    n, length = segments, p["tube_length"] / segments
    bore = RealPairSettings().tube.bore
    area = math.pi / 4 * bore**2
    part = p["tube_volume"] / n
    volumes = np.full(n + 1, part)
    volumes[0] = p["outlet_volume"] + part / 2
    volumes[-1] = volume + part / 2
    resistance = 32.0 * 1.81e-5 * length * AIR / (middle * bore**2 * area)
    system = np.zeros((2 * n + 1, 2 * n + 1))
    for k in range(n):
        flow = n + 1 + k
        system[k, flow] -= 1.2 * AIR / volumes[k]
        system[k + 1, flow] += 1.2 * AIR / volumes[k + 1]
        system[flow, k] += area / length
        system[flow, k + 1] -= area / length
        system[flow, flow] -= area / length * resistance
    return system


@pytest.mark.parametrize("length", [0.5, 1.0, 2.0])
def test_a_tube_swings_as_its_linear_acoustics_and_as_a_fine_line_does(length):
    sealed = RealRegulatorSettings(conductance_in=0.0, conductance_out=0.0)
    tube = TubeSettings(length=length)
    plant = AntagonisticPairPlant(RealPairSettings(regulator=sealed, tube=tube), 0)
    plant.channels["pressure"] = plant.channels["outlet"] = 2.5e5
    plant.channels["tube_first"] = plant.channels["tube_second"] = 2.5e5
    plant.advance(0.6)
    state, p = plant.channels[0], plant.parameters[0]
    middle = float(state["pressure"])
    state["outlet"] += 500.0
    volume = p["dead_volume"] + p["area"] * (p["stroke"] - state["extension"])
    times, pressure = watch(plant, "pressure", 30e-3)
    coarse = acoustic_line(p, volume, middle, 3)
    step = expm(coarse * DT)
    linear = np.zeros(7)
    linear[0] = 500.0
    expected = []
    for _ in times:
        linear = step @ linear
        expected.append(linear[3])
    assert np.max(np.abs(pressure[:, 0] - middle - expected)) < 0.07 * max(expected)
    # And what three segments leave of a real line: the mode that air swings in between the ends.
    few, many = (
        min((m for m in np.linalg.eigvals(line) if m.imag > 1.0), key=lambda m: m.imag)
        for line in (coarse, acoustic_line(p, volume, middle, 80))
    )
    assert few.imag == pytest.approx(many.imag, rel=0.08)
    assert few.real == pytest.approx(many.real, rel=0.08)


def test_air_that_is_shut_in_only_moves_to_and_fro():
    """The main valves closed: outlet, tube and chamber keep the sum of their pressure energies."""
    sealed = RealRegulatorSettings(conductance_in=0.0, conductance_out=0.0)
    plant = AntagonisticPairPlant(RealPairSettings(regulator=sealed), 0)
    plant.channels["pressure"] = plant.channels["outlet"] = 2.5e5
    plant.channels["tube_first"], plant.channels["tube_second"] = 3.5e5, 1.5e5
    p = plant.parameters[0]
    third = p["tube_volume"] / 3

    def content():
        c = plant.channels[0]
        chamber = p["dead_volume"] + p["area"] * (p["stroke"] - c["extension"]) + third / 2
        outlet = p["outlet_volume"] + third / 2
        return (c["outlet"] * outlet + (c["tube_first"] + c["tube_second"]) * third), (
            c["pressure"] * chamber
        )

    before = sum(content())
    plant.advance(0.5)
    assert np.ptp([plant.channels[0][c] for c in ("outlet", "tube_first", "tube_second")]) < 10.0
    assert sum(content()) == pytest.approx(before, rel=0.01)


def test_the_monitor_is_filtered_and_off_by_no_more_than_its_bound():
    bound = 0.01
    worst = []
    for seed in range(8):
        regulator = RealRegulatorSettings(monitor_error=bound, monitor_noise=0.0)
        plant = at_rest(RealPairSettings(regulator=regulator), 400e3, seed)
        worst += [
            plant.pressure(k) - (float(plant.channels[k]["outlet"]) - ATMOSPHERE) for k in (0, 1)
        ]
    assert max(map(abs, worst)) <= bound * (400e3 + FULL_SCALE) + 1e3
    assert max(map(abs, worst)) > 0.3 * bound * FULL_SCALE
    quick = RealRegulatorSettings(monitor_time=0.02, monitor_error=0.0, monitor_noise=0.0)
    plant = at_rest(RealPairSettings(regulator=quick), 120e3)
    command(plant, 300e3)
    lag = []
    for k in range(200):
        plant.advance(2.0 + (k + 1) * 1e-3)
        lag.append((float(plant.channels[0]["outlet"]) - ATMOSPHERE) - plant.pressure(0))
    rate = 180e3 / 0.06  # about what the outlet rises with in the middle of its way
    assert 0.5 * rate * 0.02 < max(lag) < 2.0 * rate * 0.02


@pytest.mark.parametrize("rms", [1e-6, 5e-6])
def test_encoders_see_their_noise_and_the_rods_do_not(rms):
    plant = at_rest(RealPairSettings(encoder_noise=rms), 120e3)
    seen = []
    for k in range(3000):
        plant.advance(2.0 + (k + 1) * 1e-3)
        seen.append([plant.position(n) - plant.channels[n]["extension"] for n in (0, 1)])
    off = np.array(seen)
    assert np.allclose(off.std(axis=0), rms, rtol=0.08)
    assert abs(np.corrcoef(off.T)[0, 1]) < 0.1
    assert np.all(np.abs(off.mean(axis=0)) < 4 * rms / math.sqrt(len(off)))


def test_the_supply_sags_as_the_chambers_draw_and_comes_back():
    stiff, soft = (
        at_rest(RealPairSettings(regulator=RealRegulatorSettings(supply_volume=volume)), 20e3)
        for volume in (0.0, 1e-4)
    )
    lowest = []
    for plant in (stiff, soft):
        command(plant, 450e3)
        least = math.inf
        for k in range(400):
            plant.advance(2.0 + (k + 1) * 1e-3)
            least = min(least, plant.truth()[-1])
        lowest.append(least)
        assert plant.truth()[-1] == pytest.approx(0.7e6, rel=2e-3)
    assert lowest[0] == pytest.approx(0.7e6, rel=1e-3)
    assert lowest[1] < 0.69e6


@pytest.mark.parametrize("seed", range(3))
def test_what_is_real_of_a_rig_does_not_change_what_else_is_drawn_for_it(seed):
    ideal = AntagonisticPairPlant(PlantSettings(), seed)
    real = AntagonisticPairPlant(RealPairSettings(), seed)
    for name in ("bow", "bandwidth", "coulomb", "viscous"):
        assert np.array_equal(ideal.parameters[name], real.parameters[name])


def test_a_payload_is_a_heavier_ring_with_its_weight_higher_up():
    bare = joint()
    loaded = joint(ring=replace(EQUAL.ring, payload=0.1, payload_height=0.06))
    q, before = loaded.joint_parameters[0], bare.joint_parameters[0]
    assert q["weight"] - before["weight"] == pytest.approx(9.80665 * 0.1)
    moment = q["weight"] * q["centre_height"] - before["weight"] * before["centre_height"]
    assert moment == pytest.approx(9.80665 * 0.1 * 0.06)
    assert q["inertia_tilt"] - before["inertia_tilt"] == pytest.approx(0.1 * 0.06**2)


def test_a_tube_that_is_too_short_to_be_one_is_refused():
    with pytest.raises(ValueError, match=r"length \(0.02 m\) is neither 0 nor a tube"):
        RealTubeSettings(length=0.02)
