"""Where each wire of a joint is taut, from how its ring stands.

A rod's extension tells its own wire's length only if it is known how the ring stands, and the rods
cannot tell that from lengths that are not known: that takes an inclinometer on the ring, along the
ball's x and y axes. With the ring's axis u, a rod stands out by

    x_k = h_k - s_k(u) - A p_k / k + side (f_k + g_k A p_k),

s_k being the shortening that the pose asks of the wire, k the wires' stiffness and side +1 on the
way up, where the seals keep a part of the pull from the wire. `rig.calibration.wire_fit` finds the
mean of all rods; what one differs from it by is found here, where what bristles do is the same to
second order. Each reading of the inclinometer errs by itself.

The shortening is the drawing's. Where the ring leans, what the joint was made to instead makes the
rods err: everything within `joint.tolerance`, equally likely (JCGM 101), in proportion to the
lean. Upright nothing is left of it.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.calibration.estimates import Estimate, fit, welch
from rig.calibration.instruments import Instrument
from rig.calibration.joint.model import Wires
from rig.calibration.joint.parameters import ANGLES, LENGTHS, PARTS, WIRES, made_of
from rig.calibration.mechanism import pneumatics_of
from rig.calibration.procedure import Readings
from rig.calibration.propagation import half_width
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

INCLINOMETER_ACCURACY: Final = 2e-4
"""Standard uncertainty of a reading, rad: a digital one of 0.01 deg, turned round to lose its zero.
"""

_AXES: Final = ("x", "y")
_MOST: Final = math.radians(10.0)
"""A ring that leans more does not stand upright."""


class WireOffsets(NamedTuple):
    """What is found of the single wires.

    Parameters
    ----------
    offsets : tuple of float
        How much further each rod stands out than all in the mean, m.
    home : Estimate
        Where all of them are taut in the mean, the ring upright.
    single : tuple of Estimate
        And each.
    """

    offsets: tuple[float, ...]
    home: Estimate
    single: tuple[Estimate, ...]


def inclinometers(stretches: Sequence[str]) -> tuple[Instrument, ...]:
    """Return the inclinometer on the ring, read along both axes in some stretches."""
    return tuple(
        Instrument(
            f"inclinometer {axis}", "rad", INCLINOMETER_ACCURACY, tuple(stretches), f"axis_{axis}"
        )
        for axis in _AXES
    )


def wire_offsets(
    profile: Profile,
    recording: Recording,
    readings: Readings,
    sides: Mapping[str, int],
    stiffness: float,
    leaning_home: tuple[float, float, float],
) -> WireOffsets | None:
    """Return what is found of the single wires; None if nobody read the inclinometer.

    Parameters
    ----------
    profile : Profile
        Of a joint.
    recording : Recording
        What was recorded.
    readings : mapping
        Of the inclinometer.
    sides : mapping of str to int
        The stretches in which it is read: +1 on the way up.
    stiffness : float
        Of a wire, N/m.
    leaning_home : tuple of float
        Mean of the rods' extensions where their wires are taut and the ring leans as it does, with
        its standard deviation, m, and degrees of freedom.

    Raises
    ------
    CalibrationRefused
        It was not read everywhere, or the ring does not stand upright.
    """
    axes = _axes(readings, sides)
    if axes is None:
        return None
    believed = _believed(profile)
    shortened = _shortened(believed, axes)
    lean = shortened.mean(axis=1)
    known = (float(lean.std(ddof=1)) / math.sqrt(len(lean)), len(lean) - 1.0)
    value, std, freedom = leaning_home
    mean = value + float(lean.mean())
    parts = [(std, freedom), known]
    made = _made(profile, believed, axes)
    home = _home("home", mean, parts, made.mean(axis=1))

    settings, pneumatics = profile.mechanism_settings, pneumatics_of(profile)
    recorded = [recording[name] for name in sides]
    extension = np.array(
        [[pneumatics.extension(p, c).mean() for c in pneumatics.channels] for p in recorded]
    )
    pull = settings.area * np.array(
        [[p.mean(f"reading.pressure_{c}") for c in pneumatics.channels] for p in recorded]
    )
    taut = extension + shortened + pull / stiffness
    apart = 1e3 * (taut - taut.mean(axis=1)[:, None])
    side = np.array([float(value) for value in sides.values()])
    share = (pull / pull.mean()).mean(axis=1)
    offsets, single = [], []
    for k, channel in enumerate(pneumatics.channels):
        found = fit(
            lambda q: apart[:, k] - q[0] - side * (q[1] + q[2] * share),  # noqa: B023
            (0.0, 0.0, 0.0), (0.1, 0.01, 0.01),
        )  # fmt: skip
        own = found.parameter(0, "", "mm")
        offsets.append(1e-3 * own.value)
        others = [*parts, (1e-3 * own.std, found.freedom)]
        single.append(_home(f"home.{channel}", mean + offsets[-1], others, made[:, k]))
    return WireOffsets(tuple(offsets), home, tuple(single))


def _axes(readings: Readings, sides: Mapping[str, int]) -> "Array | None":
    """Return the ring's axis in each stretch, shape (n, 3), as the inclinometer shows it."""
    shown = [readings.get(f"inclinometer {axis}", {}) for axis in _AXES]
    if not any(shown):
        return None
    for axis, told in zip(_AXES, shown, strict=True):
        lacking = [name for name in sides if name not in told]
        if lacking:
            raise CalibrationRefused(
                f"the inclinometer along {axis} was not read in {len(lacking)} of {len(sides)} "
                f"stretches, first in {lacking[0]!r}"
            )
    leaning = np.array([[told[name] for told in shown] for name in sides])
    if float(np.hypot(*leaning.T).max()) > _MOST:
        raise CalibrationRefused(
            f"the ring leans by {math.degrees(float(np.hypot(*leaning.T).max())):.3g} deg: put it "
            "upright before its wires are measured"
        )
    x, y = np.sin(leaning).T
    return np.column_stack([x, y, np.sqrt(1.0 - x * x - y * y)])


def _home(name: str, value: float, parts: Sequence[tuple[float, float]], made: "Array") -> Estimate:
    """Return an estimate whose error is what scatters, and what tolerances leave."""
    std, freedom = welch(parts)
    half = half_width(std, freedom, even=made.tolist())
    return Estimate(
        name, value, "m", float(np.hypot(std, np.linalg.norm(made))), value - half, value + half
    )


def _believed(profile: Profile) -> dict[str, float]:
    """Return every dimension of the joint as its profile has it, with parts in their places."""
    geometry = profile.mechanism_settings.geometry
    return {
        **{name: getattr(geometry, name) for name in LENGTHS},
        **dict(zip(ANGLES, geometry.anchor_angles, strict=True)),
        **{f"{name}_{k}": 0.0 for k in WIRES for name in PARTS},
    }


def _shortened(values: Mapping[str, float], axes: "Array") -> "Array":
    """Return by how much shorter than upright each wire is for axes of shape (n, 3), m."""
    wires = Wires.of(values)
    return np.asarray(wires.lengths(np.array([[0.0, 0.0, 1.0]])) - wires.lengths(axes))


def _made(profile: Profile, believed: Mapping[str, float], axes: "Array") -> "Array":
    """Return what a standard deviation of each tolerance makes of each wire, m, shape (m, 4)."""
    rows = {
        prior.name: 0.5 * (ahead - behind).mean(axis=0)
        for priors in made_of(profile)
        for prior in priors
        if prior.name in believed
        for behind, ahead in [
            [_shortened({**believed, prior.name: believed[prior.name] + side * prior.std}, axes)
             for side in (-1.0, 1.0)]
        ]
    }  # fmt: skip
    # Angles count from the anchors' mean.
    turned = np.mean([rows[name] for name in ANGLES], axis=0)
    return np.array([row - turned if name in ANGLES else row for name, row in rows.items()])
