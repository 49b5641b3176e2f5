"""Friction of a pair: Coulomb, viscous and breakaway, from strokes under a position controller.

While both seals slide faster than the Stribeck effect reaches, the pull of the chambers is

    A (p_a - p_b) = c_0 + (F_c + D (p_a + p_b - 2 p_0)) sgn v + B v + M a.

A controller on such seals never moves evenly, so velocity and acceleration are not taken by
differences: every term is weighed with one smooth bump of 20 ms, and the derivatives are moved to
the bump by parts, where they are exact. Only bumps in which the pair slides all the time count.

Breakaway is the greatest pull between rest and a slip, over the slips of a stroke so slow that
the pair sticks and slips. It is what a controller has to overcome; the force at which
the bristles of a seal would yield at no speed at all is a little higher.

References
----------
M. Shinbrot, "On the analysis of linear and nonlinear systems", Trans. ASME 79, 1957, pp. 547-552:
the modulating functions.
"""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.assembly import make_controller
from rig.calibration.estimates import fit, interval, mean_of
from rig.calibration.excitation import Strokes
from rig.calibration.instruments import Instrument
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SPEEDS: Final = (0.03, 0.04) * 4
CREEP: Final = 0.002
BUMP: Final = 0.021
_SLIDING: Final = 2.75
"""Times the believed Stribeck velocity: what is left of the effect there is 5e-4 of it."""

_MODEL: Final = 3e-3
"""What the model leaves out, over the Coulomb friction: bristles bend over within 1 ms of sliding
and the seat's load swings. Found on simulated rigs without noise."""

_REST: Final = 15
"""So many samples of rest make the next motion a slip."""

_THIN: Final = 5
_LEAST_ROWS: Final = 50
_LEAST_SLIPS: Final = 5
_BOUND: Final = 0.5


class _Smooth(NamedTuple):
    """A stretch, weighed with the bump."""

    pull: "Array"
    velocity: "Array"
    acceleration: "Array"
    sum: "Array"


class Friction:
    """Coulomb, viscous and breakaway friction of a pair."""

    name = "friction"
    title = "friction of the pair: Coulomb, viscous, breakaway"
    mechanisms = ("cylinder",)

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the mechanism's file."""
        return (profile.mechanism,)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return none: monitors and encoders measure it."""
        return ()

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the strokes; those of a run that was broken off are done again."""
        strokes = _strokes(profile)
        # It knows nothing of friction: a wrong belief would shake the pair.
        controller = make_controller(profile, "pid")
        return Excitation(strokes, strokes, controller, "pid", profile, approach=2.0)

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Fit sliding, and find the slips."""
        settings = profile.mechanism_settings
        names = [segment.name for segment in _strokes(profile).segments]
        recording.require(names)
        travel = max(float(np.ptp(recording[name]["reading.position"])) for name in names)
        if travel < 0.5 * _strokes(profile).travel:
            raise CalibrationRefused(
                f"the pair moved by {1e3 * travel:.3g} mm at most where "
                f"{2e3 * _strokes(profile).travel:.3g} mm were asked for: a rod is stuck, or the "
                "supply is shut"
            )
        base = 2.0 * settings.base_pressure
        least = _SLIDING * settings.friction.stribeck_velocity
        rows, slips = [], []
        for group, name in enumerate(names):
            smooth = _smooth(recording, name, settings.area, profile.loop.period)
            if name.endswith((f" {1e3 * CREEP:+g} mm/s", f" {-1e3 * CREEP:+g} mm/s")):
                slips.append(np.array(list(_slips(smooth, 1.0 if "+" in name else -1.0))))
                continue
            width = len(_bump(profile.loop.period)[0])
            for k in _sliding(smooth.velocity, least, width):
                rows.append((group, *(column[k] for column in smooth)))
        if len(rows) < _LEAST_ROWS:
            raise CalibrationRefused(
                f"the pair slid faster than {1e3 * least:.3g} mm/s in {len(rows)} places, "
                f"{_LEAST_ROWS} are needed: too little motion to tell friction"
            )
        if min(map(len, slips)) < _LEAST_SLIPS:
            raise CalibrationRefused(
                f"{min(map(len, slips))} slips in a slow stroke, {_LEAST_SLIPS} are needed to tell "
                "breakaway; seals that do not stick have none to speak of"
            )
        group, pull, velocity, acceleration, total = np.array(rows).T
        sign = np.sign(velocity)
        regressors = np.column_stack(
            (np.ones_like(pull), sign, velocity, acceleration, sign * (total - base) * 1e-5)
        )
        believed = settings.friction
        try:
            found = fit(
                lambda q: pull - regressors @ q,
                (0.0, believed.coulomb, believed.viscous, settings.moving_mass, 1.0),
                (1.0, 1.0, 10.0, 0.1, 1.0),
                groups=group,
            )
        except ValueError as error:
            raise CalibrationRefused(f"the friction: {error}") from error
        zero, coulomb, viscous, mass, _ = (float(x) for x in found.values)
        # Both directions, so that a zero of the monitors does not count; a slip is one repetition.
        count = min(map(len, slips))
        forward, backward = (part[:count] for part in slips)
        breakaway = mean_of("friction.breakaway", "N", (0.5 * (forward + backward)).tolist())
        dry = pull - zero - viscous * velocity - mass * acceleration
        panels = (
            Panel(
                "sliding, without inertia", "velocity (mm/s)", "friction (N)", "residual (N)",
                1e3 * velocity, dry + viscous * velocity,
                dry + viscous * velocity - found.residuals,
                sign * believed.coulomb + believed.viscous * velocity,
            ),
            Panel(
                "slips of the slow strokes", "number", "pull (N)", "residual (N)",
                np.arange(2.0 * count), np.concatenate((forward, backward)),
                np.full(2 * count, breakaway.value), np.full(2 * count, believed.breakaway),
            ),
        )  # fmt: skip
        values = {
            "friction": {
                "coulomb": quantity(coulomb, "N"),
                "breakaway": quantity(max(breakaway.value, coulomb), "N"),
                "viscous": quantity(max(viscous, 0.0), "N s/m"),
            }
        }
        return (
            Finding(
                profile.mechanism,
                values,
                (
                    interval(
                        "friction.coulomb", coulomb, "N",
                        math.hypot(found.covariance[1, 1] ** 0.5, _MODEL * coulomb),
                        found.freedom,
                    ),
                    found.parameter(2, "friction.viscous", "N s/m"),
                    breakaway,
                ),
                found.residuals, "N", _BOUND, len(set(group.tolist())), panels,
            ),
        )  # fmt: skip


def _strokes(profile: Profile) -> Strokes:
    low, high = profile.mechanism_settings.limits.position
    return Strokes(0.6 * min(-low, high), (*SPEEDS, CREEP))


def _bump(period: float) -> tuple["Array", "Array", "Array"]:
    """Return the bump and its two derivatives, for sums over samples."""
    width = max(2 * round(0.5 * BUMP / period) + 1, 7)
    omega = 2.0 * math.pi / ((width + 1) * period)
    u = omega * period * (np.arange(width) - 0.5 * (width - 1))
    rise = 1.0 + np.cos(u)
    weight = float((rise**2).sum())
    first = -2.0 * omega * rise * np.sin(u)
    second = 2.0 * omega**2 * (np.sin(u) ** 2 - rise * np.cos(u))
    return rise**2 / weight, first / weight, second / weight


def _smooth(recording: Recording, name: str, area: float, period: float) -> _Smooth:
    part = recording[name]
    bump, first, second = _bump(period)
    a, b = part["reading.pressure_agonist"], part["reading.pressure_antagonist"]
    x = part["reading.position"] - part["reading.position"][0]
    return _Smooth(
        np.correlate(area * (a - b), bump, "valid"),
        -np.correlate(x, first, "valid"),
        np.correlate(x, second, "valid"),
        np.correlate(a + b, bump, "valid"),
    )


def _sliding(velocity: "Array", least: float, width: int) -> "NDArray[np.int_]":
    """Return where the pair slides one way during the whole bump, thinned out."""
    from numpy.lib.stride_tricks import sliding_window_view

    half = width // 2
    if len(velocity) <= width:
        return np.zeros(0, int)
    around = sliding_window_view(velocity, width)
    inside = (around.min(axis=1) > least) | (around.max(axis=1) < -least)
    return np.flatnonzero(inside)[::_THIN] + half


def _slips(smooth: _Smooth, direction: float) -> Iterator[float]:
    """Yield the greatest pull before each slip, N."""
    still = np.abs(smooth.velocity) < 5e-4
    fast = direction * smooth.velocity > 4e-3
    rested, last = 0, 0
    for k in range(len(still)):
        if still[k]:
            rested, last = rested + 1, k
        elif fast[k] or direction * smooth.velocity[k] < -4e-3:
            if rested >= _REST and fast[k]:
                yield float((direction * smooth.pull[max(last - 20, 0) : k]).max())
            rested = 0
