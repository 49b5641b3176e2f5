"""Margins of a pair's loop against what the same loop does in time, integrated on its own."""

import math
from collections import deque
from dataclasses import replace

import numpy as np
import pytest

from controllers.cylinder.cascade import Cascade
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.margins import loop_margins, reference_response
from controllers.cylinder.pid import Pid, PidSettings
from controllers.cylinder.pid_friction import PidFriction, PidFrictionSettings
from controllers.cylinder.super_twisting import SuperTwisting, SuperTwistingSettings
from controllers.cylinder.types import PairModel, PairReference, PairState

PERIOD, FINE, SPEED = 1e-3, 2e-5, 20e-3
MODEL = PairModel(
    area=181.4e-6, mass=0.138, base_pressure=200e3, pressure_min=0.0, pressure_max=500e3,
    regulator_bandwidth=40.0, regulator_damping=1.0, coulomb=0.0, breakaway=0.0,
    stribeck_velocity=8e-3, viscous=50.0, regulator_dead_time=2e-3,
)  # fmt: skip


TWISTED = 100
"""Seeds from here on draw a sliding mode."""


def draw(seed):
    """Return a law and what it was told, drawn; some are stable and some are not."""
    drawn = np.random.default_rng(seed)
    model = replace(
        MODEL,
        viscous=float(drawn.uniform(25.0, 90.0)),
        regulator_bandwidth=float(drawn.uniform(25.0, 80.0)),
        regulator_damping=float(drawn.uniform(0.7, 1.2)),
        regulator_dead_time=float(drawn.choice([0.0, drawn.uniform(0.2e-3, 8e-3)])),
    )
    share = np.random.default_rng([seed, 1]).choice([0.0, 0.3, 0.9])
    model = replace(model, regulator_monitor_time=share * model.regulator_dead_time)
    pulled = np.random.default_rng([seed, 2])
    model = replace(model, stiffness=float(pulled.choice([0.0, pulled.uniform(-600.0, 600.0)])))
    kind = drawn.integers(3)
    if seed >= TWISTED:
        settings = SuperTwistingSettings(
            surface_rate=float(drawn.uniform(15.0, 60.0)),
            disturbance_rate=float(10 ** drawn.uniform(2.5, 3.7)),
            boundary=float(10 ** drawn.uniform(-2.0, -1.2)),
            lead_bandwidth=float(drawn.uniform(100.0, 600.0)),
            force_noise=float(drawn.uniform(0.05, 1.0)),
            observed_rate=float(drawn.uniform(1.0, 30.0)),
        )
        return SuperTwisting(settings, model, PERIOD), model
    if kind == 0:
        settings = CascadeSettings(
            position_rate=float(drawn.uniform(20.0, 90.0)),
            velocity_rate=float(drawn.uniform(60.0, 350.0)),
            lead_bandwidth=float(drawn.uniform(150.0, 600.0)),
            observer_bandwidth=float(drawn.uniform(300.0, 1200.0)),
            force_trust=float(drawn.uniform(0.0, 0.5)),
            anticipation=float(drawn.uniform(0.0, 1.0)),
            trim_rate=0.0,
        )
        return Cascade(settings, model, PERIOD), model
    if kind == 1:
        settings = PidSettings(
            proportional=float(10 ** drawn.uniform(6.5, 7.8)),
            integral=float(10 ** drawn.uniform(7.0, 8.0)),
            derivative=float(10 ** drawn.uniform(4.0, 5.8)),
            derivative_time=float(drawn.uniform(0.5e-3, 4e-3)),
        )
        return Pid(settings, model, PERIOD), model
    settings = PidFrictionSettings(
        proportional=float(10 ** drawn.uniform(7.0, 8.0)),
        integral=float(10 ** drawn.uniform(7.0, 8.5)),
        lead_bandwidth=float(drawn.uniform(150.0, 600.0)),
        dither_amplitude=0.0,
    )
    return PidFriction(settings, model, PERIOD), model


def several(step, push, count):
    """Return what so many steps with one setpoint come to."""
    steps, pushes = np.eye(len(push)), np.zeros(len(push))
    for _ in range(count):
        steps, pushes = step @ steps, step @ pushes + push
    return steps, pushes


def growth(law, model, extra):
    """Return by what share the error of a steady motion has grown, with that much more dead time.

    Small enough a push leaves every limit alone.
    """
    errors, _ = integrated(law, model, extra, kick=10.0)
    if abs(errors[-1]) > FAR:
        return math.inf
    # Swings alone: what an integral still has to settle is no oscillation.
    swings = np.diff(np.array(errors[1000:]), 2)
    early, late = (np.ptp(part) for part in (swings[100:600], swings[-500:]))
    return late / early


FAR = 0.05
"""m; a loop that is so far off is lost."""


def integrated(law, model, extra, kick=0.0, asked=lambda t: (0.0, 0.0, 0.0), cycles=3000):
    """Return how far a pair is off its steady motion after each cycle, and as it was read, m.

    The pair is integrated in steps of 20 µs, by the midpoint rule; a reading is a cycle old. What
    is `asked` beside the steady motion is m, m/s and m/s² at a time.
    """
    law = type(law)(law.settings, model, PERIOD)
    w, z = model.regulator_bandwidth, model.regulator_damping
    still = model.viscous * SPEED / model.area
    monitor = model.regulator_monitor_time
    flow = np.zeros((5, 5))
    flow[0, 1] = flow[2, 3] = 1.0
    if monitor:
        flow[4, [0, 4]] = 1.0 / monitor, -1.0 / monitor
    flow[1, :2] = -w * w, -2.0 * z * w
    flow[3, [0, 2, 3]] = model.area, -model.stiffness, -model.viscous
    flow[3] /= model.mass
    step = np.linalg.solve(np.eye(5) - 0.5 * FINE * flow, np.eye(5) + 0.5 * FINE * flow)
    force = np.array([0.0, w * w, 0.0, 0.0, 0.0])
    push = np.linalg.solve(np.eye(5) - 0.5 * FINE * flow, FINE * force)
    state = np.zeros(5)  # off the steady motion, whose pressures and place are added for the law
    each = round(PERIOD / FINE)
    whole, part = divmod(round((model.regulator_dead_time - monitor + extra) / FINE), each)
    # A cycle begins with the setpoint before for `part` steps.
    pieces = [several(step, push, count) for count in (part, each - part)]
    queue = deque([0.0] * (whole + 2), maxlen=whole + 2)
    law.reset(PairState(0.0, 0.0, model.base_pressure + still / 2, model.base_pressure - still / 2))
    errors, readings, seen = [], [], state.copy()
    for k in range(cycles):
        half = 0.5 * (still + seen[4 if monitor else 0])
        place = float(seen[2]) + SPEED * max(k - 1, 0) * PERIOD
        read = PairState(k * PERIOD, place, model.base_pressure + half, model.base_pressure - half)
        off, speed, turn = asked(k * PERIOD)
        readings.append(float(seen[2]))
        seen = state.copy()
        wanted = PairReference(SPEED * k * PERIOD + off, SPEED + speed, turn)
        first, second = law.update(read, wanted)
        setpoint = first - second - still + (kick if k == 1000 else 0.0)
        queue.append(setpoint)
        for (steps, pushes), acts in zip(pieces, (queue[0], queue[1]), strict=True):
            state = steps @ state + pushes * acts
        errors.append(state[2])
        if abs(errors[-1]) > FAR:
            break
    return errors, readings


KEPT = 0.96
"""A swing that dies away in two seconds has less than this of itself left; one that stays, or has
grown to where the setpoints end, has more."""


@pytest.mark.parametrize("seed", [*range(24), *range(TWISTED, TWISTED + 8)])
def test_a_drawn_loop_bears_as_much_more_dead_time_as_its_margin_says(seed):
    law, model = draw(seed)
    margins = loop_margins(law, model)
    if not margins.stable:
        assert margins.delay == 0.0
        assert margins.phase <= 0.0
        if margins.phase < -0.1:
            assert growth(law, model, 0.0) > KEPT
        return
    assert margins.sensitivity >= 1.0
    assert growth(law, model, 0.8 * margins.delay - 2 * FINE) < KEPT
    assert growth(law, model, 1.25 * margins.delay + 2 * FINE) > KEPT


def test_the_draws_are_of_both_kinds():
    found = [loop_margins(*draw(seed)).stable for seed in range(24)]
    assert 6 < sum(found) < 22
    found = [loop_margins(*draw(seed)).stable for seed in range(TWISTED, TWISTED + 8)]
    assert 0 < sum(found) < 8


@pytest.mark.parametrize("seed", range(3))
def test_a_dither_is_no_part_of_the_loop(seed):
    chance = np.random.default_rng(seed)
    quiet = PidFrictionSettings(
        proportional=float(chance.uniform(1e7, 3e7)), derivative=float(chance.uniform(1e5, 3e5)),
        integral=1e8, lead_bandwidth=float(chance.uniform(150.0, 400.0)), dither_amplitude=0.0,
    )  # fmt: skip
    shaken = replace(quiet, dither_amplitude=2e3, dither_frequency=float(chance.uniform(10, 30)))
    without, along = (loop_margins(PidFriction(s, MODEL, PERIOD), MODEL) for s in (quiet, shaken))
    assert without.stable
    assert along == pytest.approx(without, rel=1e-4)


@pytest.mark.parametrize("seed", range(6))
def test_the_law_is_left_as_it_was(seed):
    law, model = draw(seed)
    start = PairState(0.0, 1e-3, 210e3, 190e3)
    law.reset(start)
    first = law.update(start, PairReference(2e-3, 0.0, 0.0))
    law.reset(start)
    loop_margins(law, model)
    assert law.update(start, PairReference(2e-3, 0.0, 0.0)) == first


def test_more_told_dead_time_leaves_less_margin():
    laws = [
        replace(MODEL, regulator_dead_time=dead) for dead in (0.0, 0.5e-3, 1e-3, 1.5e-3)
    ]  # fractions of a cycle, too
    settings = PidFrictionSettings(dither_amplitude=0.0)
    delays = [loop_margins(PidFriction(settings, m, PERIOD), m).delay for m in laws]
    assert np.allclose(np.diff(delays), -0.5e-3, atol=0.03e-3)


@pytest.mark.parametrize("seed", [*range(12), *range(TWISTED, TWISTED + 3)])
def test_a_sine_becomes_in_time_what_the_response_says(seed):
    law, model = draw(seed)
    margins = loop_margins(law, model)
    if not (margins.stable and margins.delay > 1e-3):
        return  # what swings by itself answers nobody
    frequency, amplitude = (0.5, 2.0, 5.0)[seed % 3], 2e-6
    w = 2.0 * math.pi * frequency

    def asked(t):
        return (
            amplitude * math.cos(w * t),
            -amplitude * w * math.sin(w * t),
            -amplitude * w * w * math.cos(w * t),
        )

    cycles = 12_000
    _, readings = integrated(law, model, 0.0, asked=asked, cycles=cycles)
    t = np.arange(cycles)[-4000:] * PERIOD
    basis = np.column_stack([np.cos(w * t), np.sin(w * t), np.ones_like(t), t])
    a, b, *_ = np.linalg.lstsq(basis, np.array(readings[-4000:]), rcond=None)[0]
    found = complex(a, -b) / amplitude
    (said,) = reference_response(law, model, np.array([frequency]))
    # The scale of a cascade's friction feedforward, which it learns, is not quite linear in speed.
    allowed = 0.05 if isinstance(law, Cascade) else 0.005
    assert abs(found - said) < allowed * max(1.0, abs(said))
