"""`esc` told to begin at rest: its own motion, with a ramp at either end."""

import dataclasses

import numpy as np
import pytest
from drawn_cases import draw_geometry, draw_offset_geometry, draw_path, faults_of

from controllers.arm import esc, law
from controllers.arm.esc import Esc, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.types import AT_REST
from controllers.motion import InfeasibleMotion

KINDS = (TurnBack, DwellLine, Circle, Line)
EVERY = range(6)
LONGEST = 12.0
"""s, of the motions that are drawn."""


def both(geometry, path, period):
    """Return the motions at speed and from rest; None where the first is refused."""
    at_speed, from_rest = (
        Esc(EscSettings(from_rest=ramps), geometry, period) for ramps in (False, True)
    )
    at_speed.longest = LONGEST
    try:
        return at_speed.prepare(path), from_rest.prepare(path)
    except InfeasibleMotion:
        return None


def drawn(kind, count, seed=0):
    """Yield arms, paths and periods, as many as `count` of which `esc` can do one kind."""
    for k in range(seed, seed + 400):
        rng = np.random.default_rng((211, k))
        draw = draw_offset_geometry if rng.random() < 0.3 else draw_geometry
        geometry = draw(rng)
        path = draw_path(rng, geometry)
        if not isinstance(path, kind):
            continue
        period = float(rng.choice((2e-3, 5e-3)))
        plans = both(geometry, path, period)
        if plans is not None:
            yield geometry, path, *plans
            count -= 1
        if count == 0:
            return


def end_shares(geometry, plan, over):
    """Return what the rows within `over` (s) of either end need of their accelerations."""
    rates = np.vstack((np.zeros(6), plan.velocities))
    shares = np.abs(np.diff(rates, axis=0)) / plan.period / np.array(geometry.acceleration_limits)
    near = (plan.t <= over) | (plan.t[-1] - plan.t <= over)
    return shares[near].max()


@pytest.mark.parametrize("kind", KINDS)
def test_drawn_motions_begin_and_end_at_rest(kind):
    for geometry, path, at_speed, made in drawn(kind, 6):
        assert faults_of(geometry, path, made, EVERY, ()) == []
        assert not made.velocities[0].any()
        own = np.abs(np.diff(at_speed.velocities[:-1], axis=0)).max(axis=0, initial=0.0)
        own = (own / at_speed.period / np.array(geometry.acceleration_limits)).max()
        if own < 0.4:  # else the law itself needs more beside a singularity
            assert end_shares(geometry, made, made.duration) <= 1.0
        # What is reached with the limits' accelerations takes this much longer, at most.
        hardest = np.abs(at_speed.velocities) / np.array(geometry.acceleration_limits)
        assert at_speed.duration < made.duration
        assert made.duration <= at_speed.duration + 2.2 * hardest.max() + 4.0 * made.period


@pytest.mark.parametrize("kind", KINDS)
def test_between_the_ramps_it_is_the_laws_own_motion(kind):
    compared = 0
    for _, _, at_speed, made in drawn(kind, 4, seed=1000):
        middle = len(made.t) // 2
        apart = np.linalg.norm(at_speed.positions - made.positions[middle], axis=1)
        k = int(np.argmin(apart))
        if apart[k] < 1e-7:  # or the path is too short to get to its speed
            np.testing.assert_allclose(made.velocities[middle], at_speed.velocities[k], atol=1e-5)
            compared += 1
    assert compared


def test_a_dwell_lasts_as_long_as_is_asked():
    path = DwellLine(speed=0.06, depth=0.03, dwell=4.0)
    at_speed, made = both(ArmGeometry(), path, 5e-3)
    enter, leave = made.marks["region"]
    assert leave - enter == pytest.approx(4.0, abs=1e-9)
    later = enter - at_speed.marks["region"][0]
    assert 0.0 < later < 0.1
    assert made.crossings[0] - at_speed.crossings[0] == pytest.approx(later, abs=1e-5)


def test_a_path_that_is_too_short_for_its_speed():
    path = Line(middle=(0.0, 0.4, 1.5, 0.3, 0.8, 0.1), direction=(0, 0, 1), before=5e-4, after=5e-4)
    at_speed, made = both(ArmGeometry(), path, 1e-3)
    assert end_shares(ArmGeometry(), made, 1.0) <= 1.0
    assert np.abs(made.velocities).max() < 0.8 * np.abs(at_speed.velocities).max()
    np.testing.assert_allclose(made.positions[-1], at_speed.positions[-1], atol=1e-9)


def test_a_plan_says_what_its_ends_ask():
    geometry = ArmGeometry()
    at_speed, made = both(geometry, Circle(), 5e-3)
    wanted = np.abs(at_speed.velocities[[0, -2]]).max(axis=0) / 5e-3
    np.testing.assert_allclose(at_speed.end_accelerations, wanted)
    assert (made.end_accelerations <= geometry.acceleration_limits).all()
    alone = dataclasses.replace(made, velocities=np.array([AT_REST]))
    assert not alone.end_accelerations.any()


@pytest.mark.parametrize(("speed", "samples"), [(0.01, 1), (0.6, 8)])
def test_a_motion_is_sampled_before_its_ramps_as_finely_as_it_is_quick(monkeypatch, speed, samples):
    """A slow dwell was sampled eight times in a period, which took twenty seconds."""
    spans, dwell = [], 3.0 if speed > 0.1 else 12.0

    def collected(motion, fine, longest):
        spans.append(fine)
        return law.collected(motion, fine, longest)

    monkeypatch.setattr(esc, "collected", collected)
    path = DwellLine(speed=speed, depth=0.1 if speed > 0.1 else 0.03, dwell=dwell)
    limits = {"rate_limits": (20.0,) * 6, "acceleration_limits": (400.0,) * 6}
    made = Esc(EscSettings(from_rest=True), ArmGeometry(**limits), 1e-3).prepare(path)
    assert spans[-1] == pytest.approx(1e-3 / samples)
    entered, left = made.marks["region"]
    assert left - entered == pytest.approx(dwell, abs=1e-9)
    assert np.linalg.norm(made.hand - made.path, axis=1).max() < 1e-9
