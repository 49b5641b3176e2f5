"""Friction of a joint's pairs: Coulomb, viscous and breakaway, from strokes under a controller.

While both seals slide faster than the Stribeck effect reaches, the force of the chambers is

    f = c_0 + c_1 x + (F_c + D (T - T_0)) sgn v + B v + M a,

T being the sum of the pair's tensions, T_0 at base pressure; c_1 is the weight of what the joint
carries. The strokes lean between its pairs, so that both move, and are done at two base pressures:
what of the friction grows with the tensions is that on the ball.

Breakaway is the greatest force between rest and a slip, over the slips of a stroke so slow that
the pair sticks and slips. It is what a controller has to overcome; the force at which
the bristles of a seal would yield at no speed at all is a little higher.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from rig.assembly import make_controller
from rig.calibration.estimates import Estimate, Fit, fit, mean_of
from rig.calibration.excitation import Strokes
from rig.calibration.instruments import Instrument
from rig.calibration.mechanism import follower, leaning, reach, relaxed
from rig.calibration.pairs import pairs_of
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.calibration.sliding import bump_of, sliding, slips, smooth
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SPEEDS: Final = (0.05, 0.07) * 4
CREEP: Final = 0.002
_RAISED: Final = 1.6
"""Base pressure of a joint's second half of the strokes, over the usual one."""

_SHARE: Final = 0.9
"""Of what is permitted that the strokes use: the pairs share the way."""

_BETWEEN: Final = 0.25 * math.pi
_SLIDING: Final = 2.75
"""Times the believed Stribeck velocity: what is left of the effect there is 5e-4 of it."""

_LEAST_ROWS: Final = 50
_LEAST_SLIPS: Final = 5
_BOUND: Final = 1.5
"""rms of the residuals, N: a ring on its seat slides less evenly than a carriage."""


class _Rows(NamedTuple):
    """Where a pair slides, and the slips of its slow strokes by direction."""

    name: str
    sliding: "Array"
    slips: tuple[list[float], ...]


class JointFriction:
    """Coulomb, viscous and breakaway friction of a joint's pairs."""

    name = "friction"
    title = "friction of the pairs: Coulomb, viscous, breakaway"
    mechanisms = ("joint",)

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the mechanism's file."""
        return (profile.mechanism,)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return none: monitors and encoders measure it."""
        return ()

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the strokes; those of a run that was broken off are done again."""
        strokes = _strokes(profile)
        wider, notes = relaxed(profile)
        wider, name = follower(wider)
        controller = make_controller(wider, name)
        fast = strokes.segments[: 2 * len(SPEEDS)]
        base = profile.mechanism_settings.base_pressure
        bases = ((fast[len(SPEEDS) - 1].end, _RAISED * base), (fast[-1].end, base))
        motion = leaning(wider, strokes, _BETWEEN, controller, bases)
        return Excitation(strokes, motion, controller, name, wider, notes, approach=2.0)

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Fit sliding, and find the slips."""
        strokes = _strokes(profile)
        recording.require(segment.name for segment in strokes.segments)
        least = _SLIDING * profile.mechanism_settings.friction.stribeck_velocity
        pairs = _pairs(profile, recording, strokes, least)
        fits = [_fit_sliding(profile, pair) for pair in pairs]
        estimates: list[Estimate] = []
        panels: list[Panel] = []
        notes: list[str] = []
        broken: list[float] = []
        for pair, found in zip(pairs, fits, strict=True):
            prefix = f"friction.{pair.name}."
            estimates += [
                found.parameter(1, f"{prefix}coulomb", "N"),
                found.parameter(2, f"{prefix}viscous", "N s/m"),
            ]
            estimates.append(found.parameter(4, f"{prefix}load", "1"))
            panels.append(_panel_of_sliding(profile, pair, found))
            count = min(map(len, pair.slips))
            if count < _LEAST_SLIPS:
                notes.append(
                    f"{pair.name} slipped {count} times on its slow strokes, "
                    f"{_LEAST_SLIPS} are needed: its breakaway is not told"
                )
                continue
            # Both directions, so that a zero of the monitors does not count.
            forward, backward = (np.array(part[:count]) for part in pair.slips)
            breakaway = mean_of(f"{prefix}breakaway", "N", (0.5 * (forward + backward)).tolist())
            estimates.append(breakaway)
            broken.append(breakaway.value)
            panels.append(_panel_of_slips(profile, forward, backward, breakaway.value))
        residuals = np.concatenate([found.residuals for found in fits])
        mean = np.mean([found.values for found in fits], axis=0)
        blocks = len(strokes.segments) - 2
        values = _values(profile, mean, float(np.mean(broken)) if broken else None)
        return (
            Finding(
                profile.mechanism, {"friction": values}, estimates, residuals, "N", _BOUND, blocks,
                panels, notes=notes,
            ),
        )  # fmt: skip


def _strokes(profile: Profile) -> Strokes:
    return Strokes(reach(profile, _SHARE), (*SPEEDS, CREEP))


def _pairs(profile: Profile, recording: Recording, strokes: Strokes, least: float) -> list[_Rows]:
    """Return what each pair did.

    Raises
    ------
    CalibrationRefused
        One hardly moved, or did not slide long enough.
    """
    period = profile.loop.period
    width = len(bump_of(period)[0])
    names = [segment.name for segment in strokes.segments]
    rows: dict[str, list[tuple[float, ...]]] = {}
    slow: dict[str, tuple[list[float], ...]] = {}
    travel: dict[str, float] = {}
    for group, name in enumerate(names):
        for pair in pairs_of(profile, recording[name]):
            went = float(np.ptp(pair.position))
            travel[pair.name] = max(travel.get(pair.name, 0.0), went)
            signals = smooth(pair.force, pair.position, pair.load, period)
            if group >= len(names) - 2:
                forth = "+" in name
                told = slow.setdefault(pair.name, ([], []))
                told[0 if forth else 1].extend(slips(signals, 1.0 if forth else -1.0))
                continue
            start = float(pair.position[0])
            mine = rows.setdefault(pair.name, [])
            for k in sliding(signals.velocity, least, width):
                force, x, *rest = (float(column[k]) for column in signals)
                mine.append((float(group), force, start + x, *rest))
    wanted = 2.0 * strokes.travel * 0.7
    for name, went in travel.items():
        if went < 0.5 * wanted:
            raise CalibrationRefused(
                f"{name} moved by {1e3 * went:.3g} mm at most where {1e3 * wanted:.3g} mm were "
                "asked for: a rod is stuck, or the supply is shut"
            )
        if len(rows[name]) < _LEAST_ROWS:
            raise CalibrationRefused(
                f"{name} slid faster than {1e3 * least:.3g} mm/s in {len(rows[name])} places, "
                f"{_LEAST_ROWS} are needed: too little motion to tell friction"
            )
    return [_Rows(name, np.array(found), slow[name]) for name, found in rows.items()]


def _fit_sliding(profile: Profile, pair: _Rows) -> Fit:
    """Fit c_0, F_c, B, M, D and c_1."""
    settings = profile.mechanism_settings
    group, force, position, velocity, acceleration, load = pair.sliding.T
    sign = np.sign(velocity)
    base = 2.0 * settings.area * settings.base_pressure
    grown = sign * (load - base)
    regressors = np.column_stack(
        [np.ones_like(force), sign, velocity, acceleration, grown, position]
    )
    believed = settings.friction
    start = [0.0, believed.coulomb, believed.viscous, settings.moving_mass, 0.1, 0.0]
    scale = [1.0, 1.0, 10.0, 0.1, 0.1, 10.0]
    try:
        return fit(lambda q: force - regressors @ q, start, scale, groups=group)
    except ValueError as error:
        raise CalibrationRefused(f"the friction: {error}") from error


def _values(profile: Profile, mean: "Array", breakaway: float | None) -> Mapping[str, Any]:
    """Return what to lay over the believed friction; breakaway is never below Coulomb friction.

    A joint's model has seals whose friction does not grow and a ball's that is in proportion to
    the tensions: ring and wires share what does grow as they were believed to.
    """
    believed = profile.mechanism_settings.friction
    coulomb, viscous, growth = float(mean[1]), max(float(mean[2]), 0.0), float(mean[4])
    ratio = believed.breakaway / max(believed.coulomb, 1e-9)
    settings = profile.mechanism_settings
    known = _on_ball(profile)
    share = max(growth, 0.0) / known
    ball = {"ring": share * believed.ring, "wire": share * believed.wire}
    on_ball = share * known * 2.0 * settings.area * settings.base_pressure
    coulomb = max(coulomb - on_ball, 0.0)
    breakaway = ratio * coulomb if breakaway is None else max(breakaway - on_ball, 0.0)
    return {
        "coulomb": quantity(coulomb, "N"),
        "breakaway": quantity(max(breakaway, coulomb), "N"),
        "viscous": quantity(viscous, "N s/m"),
        **{name: float(f"{value:.6g}") for name, value in ball.items()},
    }


def _on_ball(profile: Profile) -> float:
    """Return what of a pair's friction is believed to be on the ball, over its tensions."""
    settings = profile.mechanism_settings
    wound = 0.5 * math.pi - settings.geometry.ring_half_angle
    # Leaning between the pairs, the ring's friction is shared by both.
    return float(math.sqrt(2.0) * settings.friction.ring + wound * settings.friction.wire)


def _panel_of_sliding(profile: Profile, pair: _Rows, found: Fit) -> Panel:
    believed = profile.mechanism_settings.friction
    _, force, position, velocity, acceleration, load = pair.sliding.T
    sign = np.sign(velocity)
    zero, _, _, mass, _, weight = found.values
    friction = force - zero - mass * acceleration - weight * position
    return Panel(
        f"{pair.name} sliding, without inertia".strip(), "velocity (mm/s)", "friction (N)",
        "residual (N)", 1e3 * velocity, friction, friction - found.residuals,
        sign * (believed.coulomb + _on_ball(profile) * load) + believed.viscous * velocity,
    )  # fmt: skip


def _panel_of_slips(profile: Profile, forward: "Array", backward: "Array", mean: float) -> Panel:
    count, settings = 2 * len(forward), profile.mechanism_settings
    load = 2.0 * settings.area * settings.base_pressure
    return Panel(
        "slips of the slow strokes", "number", "force (N)", "residual (N)",
        np.arange(float(count)), np.concatenate((forward, backward)), np.full(count, mean),
        np.full(count, settings.friction.breakaway + _on_ball(profile) * load),
    )  # fmt: skip
