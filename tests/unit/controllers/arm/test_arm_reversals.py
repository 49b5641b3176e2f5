"""Paths that go out and back over the same ground: the arm rests where they turn round."""

import dataclasses
import math

import numpy as np
import pytest
from drawn_cases import WIDE, draw_geometry, draw_offset_geometry, faults_of, hand_of
from scipy.interpolate import CubicSpline

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.pose_path import PosePath
from controllers.arm.reversals import with_reversals
from controllers.motion import InfeasibleMotion

GEOMETRY = ArmGeometry(**WIDE)
ARM = dimensions_of(GEOMETRY)
NEAR = (0.3, 0.35, 1.5, 0.4, 0.6, -0.2)
EVERY = range(6)
SPIKES = range(4)


def plan(points, speed, period):
    path = PosePath(points=tuple(map(tuple, points)), near=NEAR, frame="start", speed=speed)
    return path, LookAhead(LookAheadSettings(), GEOMETRY, period).prepare(path)


def drawn(seed, aside=0.0, legs=2):
    """Return places in a zigzag, each `aside` beside the one before it, a speed and a period."""
    rng = np.random.default_rng((83, seed))
    ahead = rng.normal(size=3)
    ahead /= np.linalg.norm(ahead)
    across = np.cross(ahead, rng.normal(size=3))
    across /= np.linalg.norm(across)
    length = float(rng.uniform(0.005, 0.06))
    places = [length * (k % 2) * ahead + aside * k * across for k in range(legs + 1)]
    return places, float(rng.uniform(0.03, 0.3)), float(rng.choice((1e-3, 2e-3, 5e-3)))


@pytest.mark.parametrize("seed", range(12))
def test_out_and_back_takes_both_ways_from_rest_to_rest(seed):
    places, speed, period = drawn(seed)
    path, both = plan(places, speed, period)
    _, there = plan(places[:2], speed, period)
    assert faults_of(GEOMETRY, path, both, EVERY, EVERY) == []
    # Legs that are one period long when planned alone are so here, too, but for their last cycle.
    assert 1.99 * there.duration <= both.duration <= 2.01 * there.duration + 2.0 * period
    np.testing.assert_allclose(both.positions[0], both.positions[-1], atol=1e-8)


@pytest.mark.parametrize("aside", [0.0, 1e-10, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("seed", range(3))
def test_a_zigzag_is_followed_to_its_ends(seed, aside):
    places, speed, period = drawn(seed + 40, aside, legs=9)
    path, made = plan(places, speed, period)
    assert faults_of(GEOMETRY, path, made, EVERY, EVERY) == []
    at, tool = hand_of(GEOMETRY, path.near)
    u = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    spline = CubicSpline(u, np.array(places) @ tool.T + at)
    hands = np.array([hand_of(GEOMETRY, q)[0] for q in made.positions.tolist()])
    # At a reversal the hand rests; a bend of 0.1 mm it may pass at its speed.
    for place in spline(u[1:-1]):
        assert (
            np.linalg.norm(hands - place, axis=1).min()
            < (0.1 if aside < 5e-5 else 0.6) * speed * period + 1e-5
        )


def spiked(rng):
    """Return an arm, and a path on it that goes out and back somewhere, the tool turning or not."""
    geometry = draw_geometry(rng) if rng.random() < 0.6 else draw_offset_geometry(rng)
    near = rng.uniform((-2, 0.1, 0.8, -1, 0.2, -2), (2, 0.9, 1.8, 1, 1.2, 2))
    near[4] *= rng.choice((-1, 1))
    legs, length = int(rng.integers(2, 7)), 10 ** rng.uniform(-4, -1.1)
    way = rng.normal(size=3)
    way *= length / np.linalg.norm(way)
    places = np.cumsum(length * rng.normal(size=(legs + 1, 3)), axis=0).tolist()
    place = places[turn := int(rng.integers(1, legs))]
    places[turn + 1 : turn + 1] = [(np.array(place) + way).tolist(), place]
    header, tools = "x (mm),y (mm),z (mm)", [()] * len(places)
    if rng.random() < 0.4:
        header += ",tool_x,tool_y,tool_z"
        tools = (np.array((0.0, 0.0, 1.0)) + 0.2 * rng.normal(size=(len(places), 3))).tolist()
    rows = [
        ",".join(f"{number:.9f}" for number in (*(1e3 * np.array(at)), *tool))
        for at, tool in zip(places, tools, strict=True)
    ]
    speed, period = float(10 ** rng.uniform(-2, -0.4)), float(rng.choice((1e-3, 2e-3, 5e-3, 1e-2)))
    settings = {"near": tuple(near.tolist()), "frame": "start", "speed": speed}
    return dataclasses.replace(geometry, **WIDE), "\n".join([header, *rows]), settings, period


def judge(seed, folder):
    rng = np.random.default_rng((977, seed))
    geometry, text, settings, period = spiked(rng)
    file = folder / f"{seed}.csv"
    file.write_text(text + "\n")
    law = LookAhead(LookAheadSettings(), geometry, period)
    path = PosePath(file=file, **settings)
    try:
        made = law.prepare(path)
    except InfeasibleMotion as error:
        return [] if "workspace" in str(error) else [str(error)]
    faults = faults_of(geometry, path, made, EVERY, EVERY)
    return faults + [f"{made.path_deviation} m off"] * (made.path_deviation > 1e-6)


@pytest.mark.parametrize("seed", SPIKES)
def test_a_spike_in_a_path_is_followed(seed, tmp_path):
    assert judge(seed, tmp_path) == []


def test_a_bend_of_some_micrometres_beside_a_spike_is_followed():
    """Its samples are halved more often than those of any bend of a path without spikes."""
    places = 1e-3 * np.array((
        (0.331559812, -0.812437496, -0.059192329), (-4.671825911, 0.893691943, 3.077145286),
        (-0.149613904, -1.216454584, 2.783346097), (1.155369623, -1.934100766, 2.713709585),
        (-0.501906383, 4.899044309, 4.316169525), (0.239614244, 5.479805058, 5.982555788),
        (-0.501906383, 4.899044309, 4.316169525), (-2.103562436, 5.583647478, 3.671875335),
    ))  # fmt: skip
    near = (-1.5979345684, 0.7108842411, 1.0618537306, -0.1052429163, -1.0870778785, -0.6479974631)
    geometry = ArmGeometry(
        a1=0.068222696, a2=0.584142112, a3=0.516101167, d6=0.049174679, base_height=0.40115083,
        elbow_offset=0.003211049, **WIDE,
    )  # fmt: skip
    path = PosePath(points=tuple(map(tuple, places)), near=near, frame="start", speed=0.2369840791)
    made = LookAhead(LookAheadSettings(), geometry, 1e-3).prepare(path)
    assert made.path_deviation < 1e-7


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("block", range(4))
def test_a_hundred_spikes_in_paths_are_followed(block, tmp_path):
    wrong = {seed: judge(seed, tmp_path) for seed in range(100 + 25 * block, 125 + 25 * block)}
    assert {seed: faults for seed, faults in wrong.items() if faults} == {}


@pytest.mark.parametrize("seed", range(40))
def test_a_reversal_is_found_where_it_is(seed):
    """A joint that goes out and back at its speed, sampled anywhere, its tip within a step."""
    rng = np.random.default_rng((89, seed))
    tip, rate, sideways = rng.uniform(0.2, 0.8), rng.uniform(0.1, 3.0), rng.choice((0.0, 1e-6))

    def solve(t, guess):
        del guess
        return (rate * (tip - abs(t - tip)), 0.2, sideways * t, 0.0, 0.0, 0.0)

    t = np.sort(np.concatenate(([0.0, 1.0], rng.uniform(0.0, 1.0, 50))))
    if seed % 4 == 0:
        t[np.argmin(np.abs(t - tip))] = tip  # on a sample
    if seed % 4 == 1:  # in the very middle of a step
        k = int(np.searchsorted(t, tip))
        t[k - 1], t[k] = tip - 0.005, tip + 0.005
        t.sort()
    (nominal, joints), found = with_reversals(t.tolist(), [solve(x, None) for x in t], solve)
    assert found == [pytest.approx(tip, abs=1e-9)]
    assert found[0] in nominal
    assert nominal == sorted(nominal)
    assert max(q[0] for q in joints) == pytest.approx(rate * tip, abs=1e-9)


def test_a_bend_is_none():
    def solve(t, guess):
        del guess
        return (math.cos(3.0 * t), math.sin(3.0 * t), 0.0, 0.0, 0.0, 0.0)

    t = np.linspace(0.0, 2.0, 40).tolist()
    _, found = with_reversals(t, [solve(x, None) for x in t], solve)
    assert found == []
