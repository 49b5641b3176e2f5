"""Friction of a pair from glides, on made-up recordings whose truth is known; and the glides."""

import itertools
import math
import random
from typing import NamedTuple

import numpy as np
import pytest

from controllers.cylinder.types import PairState
from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.calibration.preview import preview
from rig.calibration.recording import CalibrationRefused, Stretch
from rig.config import find_configs, load_profile
from rig.mechanisms.cylinder.calibration.glides import GlideScript

PERIOD = 1e-3


@pytest.fixture(scope="module")
def profile():
    return load_profile("cylinder-ideal", REGISTRY, (), find_configs())


class Seals(NamedTuple):
    coulomb: float = 9.0
    stribeck: float = 2.5
    speed: float = 9e-3
    viscous: float = 45.0
    growth: float = 0.1


class Made:
    """Pairs that rise, break away, slow down and stick."""

    paths, samples = (), 0

    def __init__(self, profile, seals, *, slowest=14e-3, noise=0.0, stuck=(), caught=()):
        rng = np.random.default_rng(4)
        self.motion = procedures(profile)["friction"].excite(profile, ()).motion
        settings = profile.mechanism_settings
        usual = 2.0 * settings.area * settings.base_pressure
        self.rows = {}
        for glide in self.motion.settings.glides():
            t = np.arange(0.0, glide.end - glide.rise, PERIOD)
            load = 2.0 * settings.area * glide.base
            coulomb = seals.coulomb + seals.growth * (load - usual)
            most = coulomb + seals.stribeck
            lasts = 0.25 if glide.name in caught else 0.9
            broke, stop = most / 20.0, most / 20.0 + lasts
            sliding = (t > broke) & (t < stop)
            v = np.where(sliding, 45e-3 - (45e-3 - slowest) * (t - broke) / lasts, 0.0)
            if glide.name in stuck:
                v = np.zeros_like(v)
            friction = (
                coulomb + seals.viscous * v + seals.stribeck * np.exp(-((v / seals.speed) ** 2))
            )
            force = np.where(sliding, friction, np.where(t <= broke, 20.0 * t, 0.0))
            force = force + settings.moving_mass * np.where(sliding, (slowest - 45e-3) / lasts, 0.0)
            x = glide.side * (np.cumsum(v) * PERIOD - 15e-3)
            half = 0.5 * glide.side * force / settings.area
            one, other = noise * rng.standard_normal((2, len(t)))
            columns = {
                "t": t,
                "reading.position": np.round(x / 1e-6) * 1e-6,
                "reading.pressure_agonist": glide.base + half + one,
                "reading.pressure_antagonist": glide.base - half + other,
            }
            self.rows[glide.name] = Stretch(columns)

    def require(self, names):
        missing = [name for name in names if name not in self.rows]
        if missing:
            raise CalibrationRefused(f"missing: {missing}")

    def __getitem__(self, name):
        return self.rows[name]


def found_in(profile, recording):
    (finding,) = procedures(profile)["friction"].identify(profile, recording, {})
    return finding, {e.name.removeprefix("friction."): e for e in finding.estimates}


def test_finds_all_four_whatever_grows_with_the_pressure(profile):
    seals = Seals()
    finding, found = found_in(profile, Made(profile, seals, noise=250.0))
    for name, true in (
        ("coulomb", seals.coulomb), ("viscous", seals.viscous),
        ("breakaway", seals.coulomb + seals.stribeck), ("stribeck_velocity", seals.speed),
    ):  # fmt: skip
        assert found[name].value == pytest.approx(true, abs=max(5 * found[name].std, 0.02 * true))
        assert found[name].std < 0.02 * true
    assert not finding.notes
    assert finding.values["friction"]["stribeck_velocity"].endswith(" m/s")


def test_where_friction_does_not_turn_up_its_stribeck_velocity_is_not_told(profile):
    finding, found = found_in(profile, Made(profile, Seals(speed=4e-3), slowest=18e-3, noise=250.0))
    assert "stribeck_velocity" not in found
    assert "stribeck_velocity" not in finding.values["friction"]
    (note,) = finding.notes
    assert "19 mm/s" in note and "not told" in note
    assert found["coulomb"].value == pytest.approx(9.0, abs=0.05)


def test_tells_a_pair_that_does_not_move(profile):
    with pytest.raises(CalibrationRefused, match=r"glide 3 \+: the pair moved by 0 mm with"):
        found_in(profile, Made(profile, Seals(), stuck=("glide 3 +",)))


def test_a_glide_that_something_catches_tells_its_breakaway_alone(profile):
    seals, caught = Seals(), ("glide 4 -", "glide 7 +")
    finding, found = found_in(profile, Made(profile, seals, noise=250.0, caught=caught))
    assert [note.split(":")[0] for note in finding.notes] == [
        f"an even slide in {name}" for name in caught
    ]
    for name, true in (
        ("coulomb", seals.coulomb), ("viscous", seals.viscous),
        ("breakaway", seals.coulomb + seals.stribeck),
    ):  # fmt: skip
        assert found[name].value == pytest.approx(true, abs=max(5 * found[name].std, 0.02 * true))


def test_more_than_a_fifth_of_the_glides_caught_is_refused(profile):
    caught = ("glide 1 +", "glide 4 -", "glide 7 +")
    with pytest.raises(CalibrationRefused, match=r"glide 7 \+: .*, as in 2 glides before"):
        found_in(profile, Made(profile, Seals(), caught=caught))


def test_tells_glides_that_were_not_recorded(profile):
    recording = Made(profile, Seals())
    del recording.rows["glide 2 -"]
    with pytest.raises(CalibrationRefused, match="glide 2 -"):
        found_in(profile, recording)


class Pair:
    """A mass with friction between two chambers of regulators of 40 rad/s."""

    def __init__(self, area):
        self.area, self.seals, self.x, self.v = area, Seals(), 0.0, 0.0
        self.force = self.rate = 0.0

    def step(self, command):
        wanted = self.area * (command.agonist - command.antagonist)
        self.rate += PERIOD * (1600.0 * (wanted - self.force) - 80.0 * self.rate)
        self.force += PERIOD * self.rate
        force = self.force
        s, inner = self.seals, 20
        for _ in range(inner):
            fade = math.exp(-((self.v / s.speed) ** 2))
            most = s.coulomb + s.stribeck * fade
            push = force - s.viscous * self.v
            free = self.v + PERIOD / inner * push / 0.138
            brake = PERIOD / inner * most / 0.138
            self.v = math.copysign(max(abs(free) - brake, 0.0), free)
            self.x += self.v * PERIOD / inner
        return self.v


def test_a_glide_breaks_away_slows_down_and_ends_within_its_way(profile):
    motion = procedures(profile)["friction"].excite(profile, ()).motion
    assert isinstance(motion, GlideScript)
    pair = Pair(profile.mechanism_settings.area)
    motion.reset(PairState(0.0, 0.0, 120e3, 120e3))
    first = next(iter(motion.settings.glides()))
    speeds, t = [], 0.0
    pair.x = -motion.settings.travel
    while t < first.end:
        command = motion.update(PairState(t, pair.x, 0.0, 0.0), motion.at(t))
        assert command.agonist + command.antagonist == pytest.approx(2.0 * first.base) or (
            t < first.rise
        )
        pair.v = 0.0 if t < first.rise else pair.v
        v = pair.step(command) if t >= first.rise else 0.0
        speeds.append(v)
        t += PERIOD
    moving = [v for v in speeds if v > 5e-3]
    assert 0.7 < len(moving) * PERIOD < 1.4
    assert max(moving) < 0.1
    # The regulators' lag makes it swing once; then it slows down all the way.
    assert all(b < a + 1e-4 for a, b in itertools.pairwise(moving[400:]))
    assert moving[400] < 0.035
    assert abs(pair.x) < motion.settings.travel + 3e-3
    assert speeds[-1] == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_a_pair_that_runs_ahead_of_its_spring_is_let_go_before_its_end(profile, seed):
    """Its seals take less than half way, and it runs until the chambers have long been level."""
    chance = random.Random(f"ahead {seed}")
    speed, lag = chance.uniform(0.05, 0.1), chance.uniform(0.03, 0.07)
    motion = procedures(profile)["friction"].excite(profile, ()).motion
    motion.reset(PairState(0.0, 0.0, 120e3, 120e3))
    first = next(iter(motion.settings.glides()))
    low, high = profile.mechanism_settings.limits.position
    area, breakaway = profile.mechanism_settings.area, chance.uniform(10.0, 25.0)
    x, t, level, slides = -motion.settings.travel, 0.0, 0.0, False
    while t < first.end:
        command = motion.update(PairState(t, x, 0.0, 0.0), motion.at(t))
        force = area * (command.agonist - command.antagonist)
        slides |= t > first.rise and force > breakaway
        level = 0.0 if force > 0.0 else level + PERIOD
        if slides and level < lag:
            x += PERIOD * (speed if x > 0.3 * motion.settings.travel else 0.02)
        t += PERIOD
    assert 0.5 * motion.settings.travel < x < high
    assert low < x


def test_preview_says_that_no_controller_holds_the_pair(profile):
    procedure = procedures(profile)["friction"]
    told = "\n".join(preview(procedure, profile, procedure.excite(profile, ())))
    assert "moves -16 mm … 16 mm and glides between them, no controller holding it" in told
    assert "mean pressures 96 kPa … 144 kPa" in told
