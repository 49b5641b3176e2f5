"""Friction of each pair of a joint, from strokes that lean between the pairs.

While both pairs slide faster than the Stribeck effect reaches, the force of a pair's chambers is

    f = c_0 + (F_c + g (G - L_0)) sgn v + B w + M a + c_1 x
        + L / L_0 (c_2 + c_3 x + c_4 x^3 + (c_5 x + c_6 x^2) sgn v).

| symbol | meaning |
|---|---|
| L, L_0 | sum of the pair's tensions, and that at base pressure |
| g | growth of friction with the tensions of both pairs |
| G | sum of a pair's tensions that loads seals and ball as much, both pairs sliding upright |
| w | speed with the same viscous friction if both rods were equally fast |
| c_1 | weight of what the joint carries |
| c_2 to c_6 | rods and wires with other friction than their kind: there and back then differ |

G is the friction on the ball as `ball_friction` believes it, over its coefficient: its coefficient
may be wrong by as much as it likes. It depends besides on what seals and ball take of the tensions.
So the fit is made twice, the second time with the friction of the first. Strokes leave some things
open, which are part of every interval (type B evaluations):

- how much of the growth is the seals': anything from none to a fifth;
- how ring and wires share the friction on the ball (`joint.tolerance.friction`);
- how stiff the wires are (`joint.tolerance.stiffness`), on which the ring's pose depends;
- how late the monitors are: much of slides, whose forces change fast, and some of strokes. Their
  filter comes after the chamber's air, and a tube, which nobody has measured, before it: by no more
  than the filter.

References
----------
JCGM 100:2008, Guide to the expression of uncertainty in measurement, 4.3.7.
JCGM 101:2008, its Supplement 1: the interval is that of drawn sums.
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.error_sums import estimate_of_sum
from rig.calibration.estimates import Estimate, Fit, fit_or_refuse
from rig.calibration.recording import CalibrationRefused, Recording, Stretch
from rig.config import Profile
from rig.mechanisms.joint.calibration.ball_friction import (
    Belief,
    axis_of,
    belief_of,
    friction_on_ball,
    sheared,
    with_stiffer_wires,
)
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.pneumatic.calibration.smoothing import Bump, PairSignals, SmoothSignals

_SLIDING: Final = 2.75
"""Times the believed Stribeck velocity: what is left of the effect there is 5e-4 of it."""

_LEAST_ROWS: Final = 50
_NO_BALL: Final = 1e-6
"""Friction on the ball over the tensions that is none."""
_SEALS: Final = (0.0, 0.2)
"""What of the friction that grows with the tensions may be the seals'."""

COULOMB, VISCOUS, GROWTH = 1, 2, 3
"""Where they stand among the parameters: N at base pressure, N s/m, g."""


class Sliding(NamedTuple):
    """Samples of a sliding pair, one element per row; forces are of its chambers.

    Parameters
    ----------
    name : str
        Of the pair.
    stroke : ndarray
        Number of the stroke.
    force, position, velocity, acceleration : ndarray
        N, m, m/s and m/s².
    sheared : ndarray
        Speed that the viscous friction of both rods amounts to, m/s.
    on_ball : ndarray
        Friction on the ball as it is believed, N.
    load : ndarray
        Sum of the pair's tensions, N.
    """

    name: str
    stroke: Array
    force: Array
    position: Array
    velocity: Array
    acceleration: Array
    sheared: Array
    on_ball: Array
    load: Array


class _Stroke(NamedTuple):
    stretch: Stretch
    axis: Array
    pairs: list[PairSignals]
    signals: list[SmoothSignals]


class LeftOut(NamedTuple):
    """Bounds of what the model leaves out, as shares of what is fitted: none.

    Parameters
    ----------
    coulomb, viscous, growth : float
        Of Coulomb friction, of viscous friction, of how friction grows with the tensions.
    """

    coulomb: float = 0.0
    viscous: float = 0.0
    growth: float = 0.0

    def of(self, index: int) -> float:
        """Return that of a parameter."""
        return {COULOMB: self.coulomb, VISCOUS: self.viscous, GROWTH: self.growth}.get(index, 0.0)


NOTHING: Final = LeftOut()


class StrokeFit(NamedTuple):
    """Fits of one pair's strokes, for each case of what strokes do not show.

    Parameters
    ----------
    rows : Sliding
        Where it slides.
    fits : tuple of Fit
        With the least and the most of what grows being the seals'.
    ring, stiffer : Fit
        With the least, and with the ring's part at its bound or wires stiffer by a standard
        deviation.
    prompt : Fit, optional
        With the least, and monitors that are not late, where it matters.
    model : LeftOut
        What the model leaves out.
    """

    rows: Sliding
    fits: tuple[Fit, Fit]
    ring: Fit
    stiffer: Fit
    prompt: Fit | None = None
    model: LeftOut = NOTHING

    @property
    def values(self) -> Array:
        """The parameters."""
        return 0.5 * (self.fits[0].values + self.fits[1].values)

    @property
    def residuals(self) -> Array:
        """Measured less fitted, N."""
        return 0.5 * (self.fits[0].residuals + self.fits[1].residuals)

    def estimate(self, index: int, name: str, unit: str) -> Estimate:
        """Return the estimate of one parameter."""
        one, other = (found.parameter(index, name, unit) for found in self.fits)
        scatter = 0.5 * (one.std + other.std)
        bounds = [0.5 * (other.value - one.value), float(self.ring.values[index]) - one.value]
        if self.prompt is not None:
            bounds.append(float(self.prompt.values[index]) - one.value)
        bounds.append(self.model.of(index) * 0.5 * (one.value + other.value))
        even = [abs(bound) / math.sqrt(3.0) for bound in bounds]
        stiffer = abs(float(self.stiffer.values[index]) - one.value)
        unity = np.eye(len(self.values))[index].tolist()
        value, freedom = 0.5 * (one.value + other.value), self.fits[0].freedom_of(unity)
        return estimate_of_sum(name, value, unit, scatter, freedom, stiffer, even)


def fit_strokes(
    profile: Profile,
    recording: Recording,
    names: Sequence[str],
    travel: float,
    late: float = 0.0,
    model: LeftOut = NOTHING,
) -> tuple[list[StrokeFit], Belief]:
    """Fit the strokes; return what they say of each pair, and of the joint's friction.

    Parameters
    ----------
    profile : Profile
        Of the joint as it is believed to be.
    recording : Recording
        The strokes.
    names : sequence of str
        Of their stretches.
    travel : float
        That each pair was asked for, m.
    late : float
        By how much the monitors are taken to come after the chambers, s: as likely not at all.
    model : LeftOut
        See `StrokeFit`.

    Raises
    ------
    CalibrationRefused
        A pair hardly moved, or did not slide long enough.
    """
    prompt = [recording[name] for name in names]
    stretches = [_seen_late(profile, stretch, late) for stretch in prompt]
    believed = belief_of(profile)
    strokes = _strokes(profile, believed, stretches)
    _check(profile, strokes, travel)
    first = [_fit(profile, believed, pair) for pair in _rows(profile, believed, strokes)]

    def again(
        profile: Profile, belief: Belief, stretches: Sequence[Stretch] = stretches
    ) -> tuple[list[Sliding], list[Fit]]:
        rows = _rows(profile, belief, _strokes(profile, belief, stretches))
        return rows, [_fit(profile, belief, pair) for pair in rows]

    least, most = (_found(believed, [fit.values for fit in first], seals) for seals in _SEALS)
    rows, fits = again(profile, least)
    share = profile.mechanism_settings.tolerance.friction
    others = [
        again(profile, most), again(profile, least.with_ring(share)),
        again(with_stiffer_wires(profile), least),
    ]  # fmt: skip
    if late > 0.0:
        others.append(again(profile, least, prompt))
    found = [
        StrokeFit(pair, (one, other), *rest)._replace(model=model)
        for pair, one, other, *rest in zip(rows, fits, *(each[1] for each in others), strict=True)
    ]
    return found, _found(believed, [pair.values for pair in found], sum(_SEALS) / len(_SEALS))


def least_speed(profile: Profile) -> float:
    """Return the speed above which the Stribeck effect is over, m/s."""
    return float(_SLIDING * profile.mechanism_settings.friction.stribeck_velocity)


def _seen_late(profile: Profile, stretch: Stretch, late: float) -> Stretch:
    """Return a stretch with pressures as early as the rods, of monitors that are late (s)."""
    cycles = round(late / profile.loop.period)
    if cycles == 0:
        return stretch
    names = [f"reading.pressure_{channel}" for channel in JointPneumatics(profile).channels]
    columns = {name: column[:-cycles] for name, column in stretch.items()}
    return Stretch(columns | {name: stretch[name][cycles:] for name in names})


def _strokes(profile: Profile, belief: Belief, stretches: Sequence[Stretch]) -> list[_Stroke]:
    strokes, bump, pneumatics = [], Bump(profile.loop.period), JointPneumatics(profile)
    for stretch in stretches:
        axis = axis_of(profile, belief, stretch)
        pairs = pneumatics.signals(stretch, axis)
        strokes.append(_Stroke(stretch, axis, pairs, [bump.smooth(pair) for pair in pairs]))
    return strokes


def _check(profile: Profile, strokes: Sequence[_Stroke], travel: float) -> None:
    """Raise if there is too little sliding to fit."""
    bump, least = Bump(profile.loop.period), least_speed(profile)
    for number, pair in enumerate(strokes[0].pairs):
        went = max(float(np.ptp(stroke.pairs[number].position)) for stroke in strokes)
        if went < 0.5 * travel:
            raise CalibrationRefused(
                f"{pair.name} moved by {1e3 * went:.3g} mm at most where {1e3 * travel:.3g} mm "
                "were asked for: a rod is stuck, or the supply is shut"
            )
        places = sum(len(bump.sliding(s.signals[number].velocity, least)) for s in strokes)
        if places < _LEAST_ROWS:
            raise CalibrationRefused(
                f"{pair.name} slid evenly and faster than {1e3 * least:.3g} mm/s in {places} "
                f"places, {_LEAST_ROWS} are needed: it hunts or sticks, because seals, supply or "
                "regulators are far from what the profile says"
            )


def _rows(profile: Profile, belief: Belief, strokes: Sequence[_Stroke]) -> list[Sliding]:
    bump, least = Bump(profile.loop.period), least_speed(profile)
    parts: list[list[Array]] = [[] for _ in strokes[0].pairs]
    for number, (stretch, axis, pairs, signals) in enumerate(strokes):
        on_ball = friction_on_ball(profile, belief, stretch, axis, signals)
        speeds = sheared(profile, stretch, signals)
        for mine, pair, one, speed, on in zip(parts, pairs, signals, speeds, on_ball, strict=True):
            position = pair.position[0] + one.position
            k = bump.sliding(one.velocity, least)
            mine.append(
                np.column_stack([np.full(len(k), float(number)), one.force[k], position[k],
                                 one.velocity[k], one.acceleration[k], speed[k], on[k],
                                 one.load[k]])
            )  # fmt: skip
    return [
        Sliding(pair.name, *np.concatenate(mine).T)
        for pair, mine in zip(strokes[0].pairs, parts, strict=True)
    ]


def _fit(profile: Profile, belief: Belief, rows: Sliding) -> Fit:
    """Fit c_0, F_c, B, g, and c_1 to c_6; the mass is known better than strokes can tell."""
    settings, usual, x = profile.mechanism_settings, belief.usual, rows.position
    sign, load = np.sign(rows.velocity), rows.load / usual
    # What grows is by its share the seals', with the pair's own tensions, else the ball's, as
    # believed: which of the four tensions load it, and how, is known better than how much.
    growth, grows = belief.seals + belief.shared, rows.load * sign
    if belief.shared > _NO_BALL:
        grows = (belief.seals * grows + rows.on_ball) / growth
    regressors = np.column_stack(
        [np.ones_like(x), sign, rows.sheared, grows - usual * sign,
         x, load, load * x, load * x**3, load * x * sign, load * x**2 * sign]
    )  # fmt: skip
    force = rows.force - settings.moving_mass * rows.acceleration
    start = [0.0, belief.coulomb, belief.viscous, growth, *(0.0,) * 6]
    scale = [1.0, 1.0, 10.0, 0.1, 10.0, 1.0, 10.0, 1e5, 10.0, 1e3]
    return fit_or_refuse(
        f"the friction of {rows.name}", lambda q: force - regressors @ q, start, scale, rows.stroke
    )


def _found(belief: Belief, values: Sequence[Array], seals: float) -> Belief:
    """Return the joint's friction by the mean of both pairs.

    Parameters
    ----------
    belief : Belief
        Gives the proportion of the ring's and the wires' friction.
    values : sequence of ndarray
        Parameters of the pairs' fits.
    seals : float
        Share of the seals in the friction that grows.
    """
    mean = np.mean(values, axis=0)
    growth = max(float(mean[GROWTH]), 0.0)
    on_ball = (1.0 - seals) * growth
    share = on_ball / max(belief.shared, 1e-9)
    return belief._replace(
        coulomb=max(float(mean[COULOMB]) - on_ball * belief.usual, 0.0),
        viscous=max(float(mean[VISCOUS]), 0.0),
        ring=min(share * belief.ring, 1.0),
        wire=min(share * belief.wire, 1.0),
        seals=seals * growth,
    )
