"""Friction of a pair: breakaway, Coulomb, viscous and Stribeck, from glides.

In each glide (`rig.mechanisms.cylinder.calibration.glides`) the force of the chambers rises until
the pair breaks away. The pair then slides ever more slowly until it sticks. While it slides,

    f = c_0 + (F_c + D (T - T_0) + F_s exp(-(v / v_s)^2)) sgn v + B v + M a,

T being the sum of the two tensions and T_0 that at base pressure. The mean pressure differs from
glide to glide, which separates D, the growth with it, from the rest. The greatest force before the
pair moves, its breakaway, is taken as the same with v = 0: F_c + F_s.

**The Stribeck velocity** v_s shows little in sliding. Where friction falls with the speed faster
than viscous friction grows, a pair runs away within a millisecond, which no regulator can hold.
For standard seals this is below 1.7 v_s, where a few hundredths of F_s are left: they give v_s to
3 to 10 %. With F_s from the breakaway it is better known, if seals have the shape above. Where
friction does not turn up before the pair sticks, v_s is not estimated.

**Breakaway and F_c + F_s** are not quite the same. Bristles that slide a little while they bend
let the pair go too soon; and the force still rises until the pair is seen to move. Under 20 N/s
either is 1 to 1.5 % at most, by the force between a creep of 2 mm/s and 5 mm/s, and they oppose
each other. Each is taken to lie anywhere between nothing and 1.5 % of the breakaway (a type B
evaluation). So it enters the interval of v_s, beside the glides' scatter.

**B holds the air's damping, too**: it flows through the tubes as the pistons move, behind what the
monitors see. That is 2 N s/m at 16 mm of bore and as much as the seals' at 32 mm; the regulators
have to overcome it alike.

Each glide is a block of its own: its samples depend on each other, and the intervals are robust
against that.

References
----------
JCGM 100:2008, Guide to the expression of uncertainty in measurement, 4.3.7; JCGM 101:2008.
H. Olsson, K. J. Åström, C. Canudas de Wit, M. Gäfvert and P. Lischinsky, "Friction models and
friction compensation", European J. Control 4(3), 1998, pp. 176-195: the shape.
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.assembly import make_controller
from rig.calibration.arrays import Array
from rig.calibration.error_sums import estimate_of_sum
from rig.calibration.estimates import Estimate, Fit, fit, fit_or_refuse
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel, Procedure, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.cylinder.calibration.glides import Glides, GlideScript
from rig.mechanisms.cylinder.calibration.pneumatics import PairPneumatics
from rig.mechanisms.pneumatic.calibration.smoothing import Bump

_BASES: Final = (1.0, 0.8, 1.2, 0.9, 1.1)
_SHARE: Final = 0.8
"""Of the permitted positions that the glides use."""

_MOST: Final = (30.0, 1.81e-4)
"""Force that breaks away a pair of standard seals (N) at such an area of a chamber, m²: 16 mm."""
_BUMP: Final = 0.041
"""Width of the bump that glides are weighed with, s: they change slowly."""

_MOVING: Final = 5e-3
_EVEN: Final = 2.5
"""A pair that changes its speed by a larger share of it in a second is breaking away or being
caught: seals need tens of micrometres to settle on a new speed's friction, 1/s."""

_THIN: Final = 14
_LEAST_ROWS: Final = 10
_CAUGHT: Final = 0.2
"""Of so many glides at most the breakaway alone is used: they slid evenly too shortly."""
_CLEAR: Final = 0.4
"""A Stribeck velocity is used if its interval is no wider than this share of it either way."""

_APART: Final = 0.015
"""By this share of it at most a pair is let go too soon, or seen to move too late."""

_BOUND: Final = 0.2
"""rms of the residuals, N."""


class _Glides(NamedTuple):
    """Rows of all glides, forwards being where each went; one element per row.

    Parameters
    ----------
    glide : ndarray
        Its number.
    side : ndarray
        +1 or -1.
    force, velocity, acceleration : ndarray
        N, m/s and m/s². Velocity and acceleration are 0 where it was about to break away.
    load : ndarray
        Sum of the tensions less that at base pressure, N.
    """

    glide: Array
    side: Array
    force: Array
    velocity: Array
    acceleration: Array
    load: Array


class PairFriction(Procedure[Recording]):
    """Procedure for breakaway, Coulomb, viscous and Stribeck friction of a pair."""

    name = "friction"
    title = "friction of the pair: breakaway, Coulomb, viscous, Stribeck"

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the glides; those of a run that was broken off are done again."""
        glides = _glides(profile)
        wider, notes = PairPneumatics(profile).with_wider_limits()
        wider, name = PairPneumatics(wider).with_gentle_controller()
        pneumatics = PairPneumatics(wider)
        script = GlideScript(glides, make_controller(wider, name), pneumatics.area)
        return pneumatics.scripted(glides, script, name, notes, approach=2.5)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit all glides as one."""
        glides = _glides(profile)
        data.require(segment.name for segment in glides.segments)
        rows, short = _rows(PairPneumatics(profile), data, glides)
        found, stribeck, notes = _fit(profile, rows)
        growth = [0.0] * len(found.values)
        growth[0] = growth[4] = 1.0
        breakaway = float(found.values[0] + found.values[4])
        estimates: list[Estimate] = [
            found.parameter(0, "friction.coulomb", "N"),
            found.parameter(1, "friction.viscous", "N s/m"),
            found.estimate("friction.breakaway", "N", growth, breakaway),
        ]
        coulomb, viscous = max(float(found.values[0]), 0.0), max(float(found.values[1]), 0.0)
        values = {
            "coulomb": quantity(coulomb, "N"),
            "breakaway": quantity(max(breakaway, coulomb), "N"),
            "viscous": quantity(viscous, "N s/m"),
        }
        if stribeck is not None:
            estimates.append(stribeck)
            values["stribeck_velocity"] = quantity(stribeck.value, "m/s")
        return (
            Finding(
                profile.mechanism, {"friction": values}, estimates, found.residuals, "N", _BOUND,
                len(list(glides.glides())), (_panel(profile, rows, found),), notes=[*short, *notes],
            ),
        )  # fmt: skip


def _glides(profile: Profile) -> Glides:
    pneumatics = PairPneumatics(profile)
    bases = tuple(share * pneumatics.base_pressure for share in _BASES)
    # Seals are as long as the bore is round, and they and the seat take the more the chambers pull.
    most = _MOST[0] * max(1.0, math.sqrt(pneumatics.area / _MOST[1]))
    return Glides(pneumatics.reach(_SHARE), bases, most=most)


def _rows(
    pneumatics: PairPneumatics, recording: Recording, glides: Glides
) -> tuple[_Glides, list[str]]:
    """Return where the pair slides evenly, and where each glide breaks away.

    Returns
    -------
    rows : _Glides
        Of all glides.
    short : list of str
        A sentence for each glide that slid evenly too shortly; it tells its breakaway alone.

    Raises
    ------
    CalibrationRefused
        It did not move, or hardly; or it slid evenly in too few glides.
    """
    period = pneumatics.profile.loop.period
    narrow, wide = Bump(period), Bump(period, _BUMP)
    usual = 2.0 * pneumatics.area * pneumatics.base_pressure
    rows: list[tuple[float, ...]] = []
    short: list[str] = []
    done = list(glides.glides())
    for number, glide in enumerate(done):
        pair = pneumatics.signals(recording[glide.name])
        sharp = narrow.smooth(pair)
        way = glide.side * float(pair.position[-1] - pair.position[0])
        signals = wide.smooth(pair)
        pull, velocity, acceleration = (
            glide.side * x for x in (signals.force, signals.velocity, signals.acceleration)
        )
        moving = np.flatnonzero(velocity > _MOVING)
        if not len(moving) or way < glides.least_way:
            raise CalibrationRefused(
                f"{glide.name}: the pair moved by {1e3 * way:.3g} mm with {pull.max():.3g} N, "
                f"about {2e3 * glides.travel:.2g} mm are needed: a rod is stuck, the supply is "
                "shut, or there is more friction than that"
            )
        load = signals.load - usual
        start = int(moving[0])
        # Where a narrower bump is centred when the pair starts, the force was a little later.
        broke = int(np.argmax(glide.side * sharp.velocity > _MOVING)) + narrow.width // 2
        most = float((glide.side * sharp.force[:broke]).max())
        rows.append((number, glide.side, most, 0.0, 0.0, load[start]))
        # Nothing but the glide itself: what happens after it has stopped is none.
        begin, end = _longest_stretch(velocity > 0.5 * _MOVING)
        start = begin + int(np.argmax(velocity[begin:end] > _MOVING))
        even = np.flatnonzero((np.abs(acceleration) < _EVEN * velocity) & (velocity > _MOVING))
        even = even[(even >= start + wide.width) & (even < end - wide.width)][::_THIN]
        if len(even) < _LEAST_ROWS:
            if len(short) + 1 > _CAUGHT * len(done):
                raise CalibrationRefused(
                    f"{glide.name}: the pair slid evenly in {len(even)} places, {_LEAST_ROWS} are "
                    f"needed, as in {len(short)} glides before: something catches it"
                )
            short.append(
                f"an even slide in {glide.name}: {len(even)} places, {_LEAST_ROWS} are needed; its "
                "breakaway alone is used"
            )
            continue
        rows += [
            (number, glide.side, pull[k], velocity[k], acceleration[k], load[k])
            for k in even.tolist()
        ]
    return _Glides(*np.array(rows, float).T), short


def _longest_stretch(moving: NDArray[np.bool_]) -> tuple[int, int]:
    """Return begin and end of the longest stretch of samples in which a pair moves."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], moving, [False])).astype(int)))
    begins, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - begins))
    return int(begins[longest]), int(ends[longest])


def _model(rows: _Glides, q: Array, speed: float) -> Array:
    coulomb, viscous, mass, growth, stribeck, zero = q[:6]
    fade = np.exp(-((rows.velocity / speed) ** 2))
    return np.asarray(
        coulomb + viscous * rows.velocity + mass * rows.acceleration + growth * rows.load
        + stribeck * fade + zero * rows.side
    )  # fmt: skip


def _fit(profile: Profile, rows: _Glides) -> tuple[Fit, Estimate | None, list[str]]:
    """Fit everything, or all but the Stribeck velocity if it does not show.

    Returns
    -------
    found : Fit
        Coulomb, viscous, mass, growth, Stribeck force, zero and, if it shows, Stribeck velocity.
    stribeck : Estimate or None
        The Stribeck velocity.
    notes : list of str
        Why it does not show.
    """
    settings = profile.mechanism_settings
    believed = settings.friction
    start = [
        believed.coulomb, believed.viscous, settings.moving_mass, 0.1,
        believed.breakaway - believed.coulomb, 0.0,
    ]  # fmt: skip
    scale = [1.0, 10.0, 0.1, 0.1, 1.0, 0.1]
    usual = believed.stribeck_velocity

    def without(q: Array) -> Array:
        return rows.force - _model(rows, q, usual)

    try:
        found = fit(
            lambda q: _left(rows, q), [*start, usual], [*scale, 1e-3], groups=rows.glide
        )  # fmt: skip
        speed = _stribeck(rows, found, [*scale, 1e-3])
        if speed.value > 0.0 and speed.high - speed.low < 2.0 * _CLEAR * speed.value:
            return found, speed, []
    except ValueError:
        pass  # it is refused below if that is not the one parameter that does not show
    found = fit_or_refuse("the friction", without, start, scale, rows.glide)
    slowest = float(rows.velocity[rows.velocity > 0.0].min())
    note = (
        f"the pair slides down to {1e3 * slowest:.2g} mm/s without its friction turning up: its "
        "Stribeck velocity is not told, and stays what it was believed to be"
    )
    return found, None, [note]


def _left(rows: _Glides, q: Array) -> Array:
    """Return what the model leaves of the force, N."""
    return rows.force - _model(rows, q, abs(float(q[6])) + 1e-9)


def _stribeck(rows: _Glides, found: Fit, scale: Sequence[float]) -> Estimate:
    """Return the Stribeck velocity; its interval holds what the breakaway leaves open."""
    from scipy.optimize import least_squares

    breakaway = float(found.values[0] + found.values[4])
    apart = np.where(rows.velocity == 0.0, _APART / math.sqrt(12.0) * breakaway, 0.0)
    below, above = (
        least_squares(
            lambda q, force: _left(rows._replace(force=force), q), found.values, x_scale=scale,
            args=(rows.force + side * apart,),
        ).x[6]
        for side in (-1.0, 1.0)
    )  # fmt: skip
    scatter = found.parameter(6, "friction.stribeck_velocity", "m/s")
    either = 0.5 * abs(float(above - below))
    freedom = found.freedom_of([0.0] * 6 + [1.0])
    return estimate_of_sum(
        scatter.name, scatter.value, "m/s", scatter.std, freedom, even=(either, either)
    )


def _panel(profile: Profile, rows: _Glides, found: Fit) -> Panel:
    friction = profile.mechanism_settings.friction
    _, _, mass, growth, _, zero = found.values[:6]
    other = mass * rows.acceleration + growth * rows.load + zero * rows.side
    measured = rows.force - other

    def believed(velocity: Array) -> Array:
        fade = np.exp(-((velocity / friction.stribeck_velocity) ** 2))
        rise = friction.breakaway - friction.coulomb
        force: Array = friction.coulomb + rise * fade + friction.viscous * velocity
        return force

    speeds = np.linspace(0.0, rows.velocity.max(), 200)
    return Panel(
        "breaking away, and gliding", "velocity (mm/s)", "friction at base pressure (N)",
        "residual (N)", 1e3 * rows.velocity, measured, measured - found.residuals,
        believed(rows.velocity), curve=(1e3 * speeds, believed(speeds)),
    )  # fmt: skip
