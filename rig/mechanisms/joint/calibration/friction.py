"""Friction of a joint's pairs: Coulomb, viscous and breakaway.

The ring leans to and fro between its pairs, so that both slide, at two base pressures, so that
friction that grows with the tensions shows (`rig.mechanisms.joint.calibration.stroke_fit`). How
ring and wires share that growth stays as believed: no such motion shows it. The controller is far
less stiff than in use (`JointPneumatics.with_gentle_controller`), since the usual one hunts where
the seals have less friction than it was tuned for. Behind late regulators no controller leads a
ring that sticks: there its pairs slide by themselves (`rig.mechanisms.joint.calibration.slides`).

Breakaway is the greatest force of a pair before it moves; see
`rig.mechanisms.joint.calibration.breakaway`. The pair is pushed alone, by 20 N/s, with the ring
upright. The force at which bristles of seals and seat would yield infinitely slowly is a little
higher.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from rig.assembly import make_controller
from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel, Procedure, quantity
from rig.calibration.recording import Recording
from rig.config import Profile
from rig.mechanisms.joint.calibration.ball_friction import Belief, belief_of
from rig.mechanisms.joint.calibration.breakaway import Breakaways, cases_of, forces_of_tugs
from rig.mechanisms.joint.calibration.leaning import Strokes
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.joint.calibration.slide_script import SlideScript
from rig.mechanisms.joint.calibration.slides import GOAL, Slides
from rig.mechanisms.joint.calibration.stroke_fit import (
    COULOMB,
    GROWTH,
    VISCOUS,
    LeftOut,
    StrokeFit,
    fit_strokes,
)
from rig.mechanisms.joint.calibration.tugs import DEPTH, PER_ROUND, StrokesAndTugs, Tug, TugScript

SPEEDS: Final = (0.03, 0.045, 0.06) * 4
_TURN: Final = 0.15
_RAISED: Final = 1.3
"""Base pressure of the second half of the strokes, over that of the first."""

_SHARE: Final = 0.6
"""Share of the permitted way that the strokes use; both pairs share it."""

_MORE: Final = 1.6
"""Times the breakaway that is believed, as far as a tug goes."""

_MOST: Final = 2.7
"""The same where slides come before: friction may be nearly twice what is believed."""

_SLIDDEN: Final = 1.4
"""Base pressure of tugs after slides, over that of the slides."""

_PUSH: Final = 0.8
"""Of what may be between the tensions of a pair's wires, the greatest force that slides it."""

_HIGHEST: Final = 0.6
"""Greatest base pressure of slides over what a chamber may have."""

_MODEL: Final = LeftOut(coulomb=0.15, viscous=0.15)
_MODEL_OF_BREAKAWAY: Final = 0.08
"""What the model leaves out of slides, and of tugs that wires on one side alone pull: bounds as
shares of Coulomb and viscous friction, and of breakaway. Tensions are two or three times those at
base pressure there. E: on ten simulated joints with 0.6 to 1.9 times the friction, slides showed 3
to 18 % more Coulomb friction than was true, and tugs up to 7 % less breakaway."""

_OF_STROKES: Final = LeftOut(coulomb=4e-3, viscous=4e-3, growth=6e-3)
"""Of strokes, the same. What seals and ball take of the tensions multiplies, and the fit adds it:
ten simulated pairs with low-speed seals showed 0.2 % more Coulomb friction than was true, and
0.07 % where the seals' part does not grow."""

_OF_LATE_STROKES: Final = LeftOut(coulomb=0.015, viscous=0.12, growth=0.1)
"""The same behind late regulators, whose monitors do not show when a force changes. E: eight
simulated pairs showed up to 9 % more viscous friction than was true, up to 9 % less growth, and
Coulomb friction that was 1.1 % off."""

_LATE_BY: Final = 0.5
"""Of a monitor's filter, by which strokes are taken to be seen late: anything from none to all."""

_MOMENT: Final = 2.0
"""Cycles to which the moment is known at which a tug breaks a pair away: its force goes on rising
meanwhile. Tugs showed 0.02 to 0.04 N less than was true, where it rises by 20 N/s."""

_ONWARD: Final = 4.0
"""Time in which both pairs slide back upright before a tug, s."""

_STILL: Final = Strokes(1e-5, (1e-5,), 0.1)
"""What is planned of slides: to stay at home."""

_TAUT: Final = 1.15
"""Of the least tension that is permitted, what a tug leaves in a wire."""

_LEAST_TUGS: Final = 3
"""So many tugs to each side must have moved a pair, or its breakaway is not estimated."""

_BOUND: Final = 1.5
"""rms of the residuals, N: a ring on its seat slides less evenly than a carriage."""


class JointFrictionFit(Procedure[Recording]):
    """Procedure for Coulomb, viscous and breakaway friction of a joint's pairs."""

    name = "friction"
    title = "friction of the pairs: Coulomb, viscous, breakaway"

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return strokes and tugs; those of a run that was broken off are done again."""
        settings = _settings(profile)
        strokes = settings.strokes
        wider, notes = JointPneumatics(profile).with_wider_limits()
        wider, name = JointPneumatics(wider).with_gentle_controller()
        controller, pneumatics = make_controller(wider, name), JointPneumatics(wider)
        base = pneumatics.gentle_pressure
        if isinstance(strokes, Slides):
            still = pneumatics.along_line(_STILL, controller, ((0.0, base),))
            limits, own = pneumatics.settings.limits, pneumatics.settings
            sliding = SlideScript(
                settings, still, controller, _SLIDDEN * base, base, slides=strokes,
                geometry=own.geometry, least=limits.tension[0] + 0.5 * own.friction.breakaway,
                area=pneumatics.area, stiffness=own.wire_stiffness,
            )  # fmt: skip
            return pneumatics.scripted(settings, sliding, name, notes, 2.0)
        half = strokes.segments[len(strokes.speeds) - 1].end
        bases = ((0.0, base), (half, _RAISED * base))
        motion = pneumatics.along_line(strokes, controller, bases)
        script = TugScript(settings, motion, controller, _base(pneumatics, profile), base)
        return pneumatics.scripted(settings, script, name, notes, 2.0, follows=True)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit sliding, and find what breaks the pairs away."""
        settings = _settings(profile)
        data.require(segment.name for segment in settings.segments)
        names = [segment.name for segment in settings.strokes.segments]
        late = profile.mechanism_settings.regulator_response.monitor_time
        model, of_tugs = _MODEL, _MODEL_OF_BREAKAWAY
        if not isinstance(settings.strokes, Slides):
            model = _OF_LATE_STROKES if JointPneumatics(profile).air_is_late else _OF_STROKES
            late, of_tugs = _LATE_BY * late, 0.0
        travel = _travel(settings.strokes)
        strokes, belief = fit_strokes(profile, data, names, travel, late, model)
        growth = [pair.estimate(GROWTH, "", "1") for pair in strokes]
        spread = math.hypot(*(g.std for g in growth)) / max(sum(g.value for g in growth), 1e-9)
        cases, tugs = cases_of(profile, belief, spread), settings.tugs
        forces = forces_of_tugs(cases, data, tugs)
        sides = [_sides(tugs, forces[0], number) for number in range(len(strokes))]
        moved = [k for k, both in enumerate(sides) if min(map(len, both)) >= _LEAST_TUGS]
        risen = _MOMENT * profile.loop.period * settings.rate
        breakaways = Breakaways(tugs, forces[0], moved, risen)
        estimates: list[Estimate] = []
        panels: list[Panel] = []
        notes: list[str] = []
        broken: list[float] = []
        for number, pair in enumerate(strokes):
            name = pair.rows.name
            prefix = f"friction.{name}."
            estimates += [
                pair.estimate(COULOMB, f"{prefix}coulomb", "N"),
                pair.estimate(VISCOUS, f"{prefix}viscous", "N s/m"),
                pair.estimate(GROWTH, f"{prefix}load", "1"),
            ]
            panels.append(_panel_of_sliding(profile, pair))
            if number not in moved:
                count = min(map(len, sides[number]))
                notes.append(
                    f"{name} moved in {count} of {settings.rounds * PER_ROUND} tugs of up to "
                    f"{settings.most:.3g} N to one side, {_LEAST_TUGS} are needed: its breakaway "
                    "is not told, and stays in proportion to Coulomb friction"
                )
                continue
            breakaway = breakaways.estimate(number, f"{prefix}breakaway", cases, forces, of_tugs)
            estimates.append(breakaway)
            broken.append(breakaway.value)
            panels.append(_panel_of_tugs(profile, name, *sides[number], breakaway.value))
        residuals = np.concatenate([pair.residuals for pair in strokes])
        values = _values(profile, belief, float(np.mean(broken)) if broken else None)
        return (
            Finding(
                profile.mechanism, {"friction": values}, estimates, residuals, "N", _BOUND,
                len(names), panels, notes=notes,
            ),
        )  # fmt: skip


def _settings(profile: Profile) -> StrokesAndTugs:
    pneumatics, believed = JointPneumatics(profile), belief_of(profile)
    if pneumatics.nobody_leads:
        return _slides(pneumatics, believed)
    load = 2.0 * pneumatics.area * _base(pneumatics, profile)
    most = min(_MORE * _expected(pneumatics, believed, load), load - 2.0 * _slack(pneumatics))
    return StrokesAndTugs(Strokes(pneumatics.reach(_SHARE), SPEEDS, _TURN), most=most)


def _slides(pneumatics: JointPneumatics, believed: Belief) -> StrokesAndTugs:
    tension, base = pneumatics.settings.limits.tension, pneumatics.gentle_pressure
    slides = Slides(base, _HIGHEST * pneumatics.highest, _PUSH * (tension[1] - tension[0]))
    expected = _expected(pneumatics, believed, 2.0 * pneumatics.area * _SLIDDEN * base)
    return StrokesAndTugs(slides, most=min(_MOST * expected, slides.most), move=_ONWARD)


def _expected(pneumatics: JointPneumatics, believed: Belief, load: float) -> float:
    """Return the breakaway that is believed of a pair under a sum of its tensions, N."""
    return float(pneumatics.settings.friction.breakaway + believed.alone * load)


def _slack(pneumatics: JointPneumatics) -> float:
    """Return what a tug leaves in the wire that it lets go, N: it stays taut."""
    return _TAUT * pneumatics.settings.limits.tension[0]


def _base(pneumatics: JointPneumatics, profile: Profile) -> float:
    """Return the base pressure of the tugs, Pa gauge: all that swings is permitted.

    It is the usual one, or, since upright a ring does not fall, a higher one if a tug needs that:
    a tug can be no greater than what it lets go of.
    """
    limits, believed = pneumatics.settings.limits, belief_of(profile)
    most = min(limits.pressure[1], limits.tension[1] / pneumatics.area) / (1.0 + DEPTH)
    seals = _MORE * pneumatics.settings.friction.breakaway + 2.0 * _slack(pneumatics)
    grows = 1.0 - _MORE * believed.alone  # so does what it has to overcome
    needed = seals / (2.0 * pneumatics.area * grows) if grows > 0.0 else most
    return min(max(pneumatics.base_pressure, needed), most)


def _travel(strokes: Strokes | Slides) -> float:
    """Return the way of each pair in a slide, or the longest of strokes at constant speed, m."""
    if isinstance(strokes, Slides):
        return 2.0 * GOAL
    ways = (
        (segment.end - segment.start) * speed
        for segment, speed in zip(strokes.segments[::2], strokes.speeds, strict=True)
    )
    return math.sqrt(0.5) * max(ways)


def _sides(tugs: Sequence[Tug], forces: Array, pair: int) -> tuple[Array, Array]:
    """Return the forces of tugs that moved a pair, to either side."""
    mine = np.isfinite(forces) & np.array([tug.pair == pair for tug in tugs])
    side = np.array([tug.side for tug in tugs])
    return forces[mine & (side > 0)], forces[mine & (side < 0)]


def _values(profile: Profile, belief: Belief, breakaway: float | None) -> Mapping[str, object]:
    """Return what to lay over the believed friction; breakaway is never below Coulomb friction.

    Parameters
    ----------
    profile : Profile
        The rig's.
    belief : Belief
        What was found of the joint.
    breakaway : float, optional
        Of a pair with the ring, N. Without it the seals' part stays in proportion to their Coulomb
        friction.
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

    def was(v: Array, side: Array) -> Array:
        dry = believed.coulomb + believed.shared * believed.usual
        force: Array = dry * side + believed.viscous * v
        return force

    return Panel(
        f"{pair.rows.name} sliding, at base pressure", "velocity (mm/s)", "friction (N)",
        "residual (N)", 1e3 * velocity, friction + pair.residuals, friction, was(velocity, sign),
        curve=(1e3 * speeds, was(speeds, sides)),
    )  # fmt: skip


def _panel_of_tugs(
    profile: Profile, name: str, forward: Array, backward: Array, mean: float
) -> Panel:
    count, believed = len(forward) + len(backward), belief_of(profile)
    before = profile.mechanism_settings.friction.breakaway + believed.alone * believed.usual
    return Panel(
        f"{name}: tugs to one side, then to the other", "number", "force (N)", "residual (N)",
        np.arange(float(count)), np.concatenate((forward, backward)), np.full(count, mean),
        np.full(count, before),
    )  # fmt: skip
