"""How much further each rod of a joint stands out than the others, where the wires are taut.

A rod's extension tells its own wire's length only if it is known how the ring stands, and the rods
cannot tell that from lengths that are not known: that takes an inclinometer on the ring, along the
ball's x and y axes. With the ring's axis u, a rod stands out by

    x_k = h_k - s_k(u) - A p_k / k + side (f_k + g_k A p_k),

s_k being the shortening that the pose asks of the wire, k the wires' stiffness and side +1 on the
way up, where the seals keep a part of the pull from the wire. Each reading errs by itself.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.calibration.estimates import Estimate, fit
from rig.calibration.instruments import Instrument
from rig.calibration.mechanism import pneumatics_of
from rig.calibration.procedure import Readings
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
    estimates : tuple of Estimate
        Of the extension of each rod where its wire is taut and the ring upright.
    lean, lean_std : float
        How much shorter all wires are in the mean because the ring leans, m: to second order.
    """

    offsets: tuple[float, ...]
    estimates: tuple[Estimate, ...]
    lean: float
    lean_std: float


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

    Raises
    ------
    CalibrationRefused
        It was not read everywhere, or the ring does not stand upright.
    """
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
    from controllers.spherical_joint.wires import InverseKinematics

    inverse = InverseKinematics(profile.mechanism_settings.geometry)
    shortened = np.array(
        [
            inverse.shortening((x, y, math.sqrt(1.0 - x * x - y * y)))
            for x, y in np.sin(leaning).tolist()
        ]
    )
    settings, pneumatics = profile.mechanism_settings, pneumatics_of(profile)
    side = np.array([float(value) for value in sides.values()])
    estimates = []
    for k, channel in enumerate(pneumatics.channels):
        parts = [recording[name] for name in sides]
        extension = np.array([pneumatics.extension(part, channel).mean() for part in parts])
        pull = settings.area * np.array([p.mean(f"reading.pressure_{channel}") for p in parts])
        taut = 1e3 * (extension + shortened[:, k] + pull / stiffness)
        share = pull / pull.mean()
        found = fit(
            lambda q: taut - q[0] - side * (q[1] + q[2] * share),  # noqa: B023
            (taut.mean(), 0.0, 0.0), (0.1, 0.01, 0.01),
        )  # fmt: skip
        value = 1e-3 * float(found.values[0])
        estimates.append(found.estimate(f"home.{channel}", "m", (1e-3, 0.0, 0.0), value))
    homes = [estimate.value for estimate in estimates]
    mean = sum(homes) / len(homes)
    leans = shortened.mean(axis=1)
    return WireOffsets(
        tuple(value - mean for value in homes), tuple(estimates),
        float(leans.mean()), float(leans.std(ddof=1)) / math.sqrt(len(leans)),
    )  # fmt: skip
