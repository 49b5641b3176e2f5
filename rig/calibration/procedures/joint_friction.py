"""Friction of a joint's pairs: Coulomb, viscous and breakaway.

The ring leans to and fro between its pairs, so that both slide, at two base pressures, so that what
grows with the tensions is told from the rest (`rig.calibration.joint.stroke_fit`). Of what grows,
ring and wires share as they were believed to: no such motion tells them apart. The controller has
far less stiffness than in use (`rig.calibration.mechanism.follower`): where seals have less
friction than it was tuned for, the usual one hunts and never slides.

Breakaway is the greatest force of a pair before it moves, when it alone is pushed ever harder with
the ring upright (`rig.calibration.joint.tugs`). The force at which the bristles of a seal would
yield at no speed at all is a little higher.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from rig.assembly import make_controller
from rig.calibration.estimates import Estimate, mean_of
from rig.calibration.excitation import Strokes
from rig.calibration.instruments import Instrument
from rig.calibration.joint.on_ball import Belief, belief_of
from rig.calibration.joint.stroke_fit import COULOMB, GROWTH, VISCOUS, StrokeFit, fit_strokes
from rig.calibration.joint.tugs import BROKEN, PER_ROUND, StrokesAndTugs, Tugging
from rig.calibration.mechanism import follower, leaning, reach, relaxed
from rig.calibration.pairs import pairs_of
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import Recording
from rig.calibration.sliding import bump_of, smooth
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SPEEDS: Final = (0.045, 0.06, 0.08) * 4
_TURN: Final = 0.15
_RAISED: Final = 1.6
"""Base pressure of the second half of the strokes, over that of the first."""

_MOST_RAISED: Final = 192e3
"""Pa gauge: the more wires pull, the faster a ring that leans falls on, until no regulator can
follow. A profile with more pressure than that is measured with less."""

_SHARE: Final = 0.9
"""Of what is permitted that the strokes use: the pairs share the way."""

_BETWEEN: Final = 0.25 * math.pi
_MOVING: Final = 5e-3
"""A pair that is faster has broken away, m/s."""

_LEAST_TUGS: Final = 3
"""To each side that a pair has to have followed, or its breakaway is not told."""

_BOUND: Final = 1.5
"""rms of the residuals, N: a ring on its seat slides less evenly than a carriage."""


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
        """Return strokes and tugs; those of a run that was broken off are done again."""
        settings = _settings(profile)
        strokes = settings.strokes
        wider, notes = relaxed(profile)
        wider, name = follower(wider)
        controller = make_controller(wider, name)
        half = strokes.segments[len(strokes.speeds) - 1].end
        base = min(profile.mechanism_settings.base_pressure, _MOST_RAISED / _RAISED)
        bases = ((0.0, base), (half, _RAISED * base))
        motion = leaning(wider, strokes, _BETWEEN, controller, bases)
        tugging = Tugging(settings, motion, controller, base)
        return Excitation(settings, tugging, tugging, name, wider, notes, approach=2.0)

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Fit sliding, and find what breaks the pairs away."""
        settings = _settings(profile)
        recording.require(segment.name for segment in settings.segments)
        names = [segment.name for segment in settings.strokes.segments]
        strokes, belief = fit_strokes(profile, recording, names, _travel(settings.strokes))
        tugs = _tugs(profile, belief, recording, settings)
        estimates: list[Estimate] = []
        panels: list[Panel] = []
        notes: list[str] = []
        broken: list[float] = []
        for pair in strokes:
            name = pair.rows.name
            prefix = f"friction.{name}."
            estimates += [
                pair.estimate(COULOMB, f"{prefix}coulomb", "N"),
                pair.estimate(VISCOUS, f"{prefix}viscous", "N s/m"),
                pair.estimate(GROWTH, f"{prefix}load", "1"),
            ]
            panels.append(_panel_of_sliding(profile, pair))
            mine = tugs[name]
            count = min(map(len, mine))
            if count < _LEAST_TUGS:
                notes.append(
                    f"{name} moved in {count} of {settings.rounds * PER_ROUND} tugs of up to "
                    f"{settings.most:g} N to one side, {_LEAST_TUGS} are needed: its breakaway is "
                    "not told, and stays in proportion to Coulomb friction"
                )
                continue
            # Both directions, so that a zero of the monitors does not count.
            forward, backward = (np.array(part[:count]) for part in mine)
            breakaway = mean_of(f"{prefix}breakaway", "N", (0.5 * (forward + backward)).tolist())
            estimates.append(breakaway)
            broken.append(breakaway.value)
            panels.append(_panel_of_tugs(profile, name, forward, backward, breakaway.value))
        residuals = np.concatenate([pair.residuals for pair in strokes])
        values = _values(profile, belief, float(np.mean(broken)) if broken else None)
        return (
            Finding(
                profile.mechanism, {"friction": values}, estimates, residuals, "N", _BOUND,
                len(names), panels, notes=notes,
            ),
        )  # fmt: skip


def _settings(profile: Profile) -> StrokesAndTugs:
    return StrokesAndTugs(Strokes(reach(profile, _SHARE), SPEEDS, _TURN))


def _travel(strokes: Strokes) -> float:
    """Return the way of each pair in the longest of the strokes' constant-speed parts, m."""
    ways = (
        (segment.end - segment.start) * speed
        for segment, speed in zip(strokes.segments[::2], strokes.speeds, strict=True)
    )
    return math.sqrt(0.5) * max(ways)


def _tugs(
    profile: Profile, belief: Belief, recording: Recording, settings: StrokesAndTugs
) -> dict[str, tuple[list[float], list[float]]]:
    """Return for each pair, by side, the greatest forces before it moved, N at base pressure."""
    period, usual = profile.loop.period, belief.usual
    half = len(bump_of(period)[0]) // 2
    found: dict[str, tuple[list[float], list[float]]] = {}
    for tug in settings.tugs:
        pairs = pairs_of(profile, recording[tug.name])
        pair = pairs[tug.pair]
        mine = found.setdefault(pair.name, ([], []))
        signals = smooth(pair.force, pair.position, pair.load, period)
        way, speed = tug.side * signals.position, tug.side * signals.velocity
        moved = np.flatnonzero((way > 0.5 * BROKEN) & (speed > _MOVING))
        if not len(moved):
            continue
        pull = tug.side * signals.force[: moved[0]]
        k = int(np.argmax(pull))
        # The ring bears all four wires, the pair's own friction grows with its two.
        four = sum(float(one.load[k + half]) for one in pairs) - 2.0 * usual
        own = float(signals.load[k]) - usual
        grown = belief.ring * four + (belief.wound * belief.wire + belief.seals) * own
        mine[0 if tug.side > 0 else 1].append(float(pull[k]) - grown)
    return found


def _values(profile: Profile, belief: Belief, breakaway: float | None) -> Mapping[str, Any]:
    """Return what to lay over the believed friction; breakaway is never below Coulomb friction.

    Parameters
    ----------
    profile : Profile
        The rig's.
    belief : Belief
        What was found of the joint.
    breakaway : float, optional
        Of a pair with the ring, N; the seals' stays in proportion to their Coulomb friction if it
        is not told.
    """
    if breakaway is None:
        usual = profile.mechanism_settings.friction
        seals = usual.breakaway / max(usual.coulomb, 1e-9) * belief.coulomb
    else:
        seals = breakaway - belief.alone * belief.usual
    return {
        "coulomb": quantity(belief.coulomb, "N"),
        "breakaway": quantity(max(seals, belief.coulomb), "N"),
        "viscous": quantity(belief.viscous, "N s/m"),
        "ring": float(f"{belief.ring:.6g}"),
        "wire": float(f"{belief.wire:.6g}"),
    }


def _panel_of_sliding(profile: Profile, pair: StrokeFit) -> Panel:
    believed = belief_of(profile)
    velocity, sign = pair.rows.velocity, np.sign(pair.rows.velocity)
    # What is left is Coulomb and viscous friction at base pressure with the ring upright.
    friction = pair.values[COULOMB] * sign + pair.values[VISCOUS] * velocity
    speeds = np.array([velocity.min(), 0.0, 0.0, velocity.max()])
    sides = np.array([-1.0, -1.0, 1.0, 1.0])

    def was(v: "Array", side: "Array") -> "Array":
        dry = believed.coulomb + believed.shared * believed.usual
        force: Array = dry * side + believed.viscous * v
        return force

    return Panel(
        f"{pair.rows.name} sliding, at base pressure", "velocity (mm/s)", "friction (N)",
        "residual (N)", 1e3 * velocity, friction + pair.residuals, friction, was(velocity, sign),
        curve=(1e3 * speeds, was(speeds, sides)),
    )  # fmt: skip


def _panel_of_tugs(
    profile: Profile, name: str, forward: "Array", backward: "Array", mean: float
) -> Panel:
    count, believed = 2 * len(forward), belief_of(profile)
    before = profile.mechanism_settings.friction.breakaway + believed.alone * believed.usual
    return Panel(
        f"{name}: tugs to one side, then to the other", "number", "force (N)", "residual (N)",
        np.arange(float(count)), np.concatenate((forward, backward)), np.full(count, mean),
        np.full(count, before),
    )  # fmt: skip
