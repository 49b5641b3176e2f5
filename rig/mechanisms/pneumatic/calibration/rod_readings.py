"""How far off the calibrated readings of a rod and of its chamber may be, all of them alike."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from rig.config import Profile
from rig.config.models import Calibration
from rig.mechanisms.pneumatic.calibration.pneumatics import AnyPneumatics

Part = tuple[float, float]
"""Standard deviation, and the degrees of freedom that it is known with."""

_FITTED = 2
"""Zero and scale of an encoder."""


class RodErrors(NamedTuple):
    """The errors that all readings of one rod have in common, as standard deviations.

    A device that nobody calibrated has none: what is measured is told as it counts.

    Parameters
    ----------
    zero : tuple of float
        Of the encoder where the rod is at home, m, and the degrees of freedom of that.
    scale : float
        Of the encoder's scale, 1.
    offset : float
        Of the monitor of its chamber without pressure, Pa.
    gain : float
        Of the monitor's scale, 1.
    """

    zero: Part
    scale: float
    offset: float
    gain: float

    def home(self, area: float, compliance: float) -> tuple[Part, ...]:
        """Return the parts of the error of where its wire is taut, m.

        Parameters
        ----------
        area : float
            Of the piston, m².
        compliance : float
            Of the wire, m/N.
        """
        return self.zero, (area * compliance * self.offset, math.inf)

    def compliance(self, compliance: float) -> tuple[Part, ...]:
        """Return the part of the error of its wire's compliance, m/N.

        Parameters
        ----------
        compliance : float
            Of the wire, m/N.
        """
        return ((compliance * math.hypot(self.scale, self.gain), math.inf),)


def rod_errors(profile: Profile, pneumatics: AnyPneumatics) -> tuple[RodErrors, ...]:
    """Return the errors of each rod, in the order of the channels.

    Parameters
    ----------
    profile : Profile
        Of the rig, with what was calibrated.
    pneumatics : Pneumatics
        Its cylinders.
    """
    monitors = _deviations(profile.devices[pneumatics.regulators].calibration)
    return tuple(
        [
            RodErrors(
                _zero(profile.devices[encoder].calibration),
                _deviations(profile.devices[encoder].calibration).get("scale", 0.0),
                monitors.get(f"{channel}.monitor.offset", 0.0),
                monitors.get(f"{channel}.monitor.gain", 0.0),
            )
            for encoder, channel in zip(pneumatics.encoders, pneumatics.channels, strict=True)
        ]
    )


def in_mean(parts: Sequence[Sequence[Part]]) -> list[Part]:
    """Return the parts that the errors of all rods have in their mean."""
    return [(std / len(parts), freedom) for own in parts for std, freedom in own]


def _deviations(calibration: Calibration | None) -> dict[str, float]:
    return {} if calibration is None else calibration.deviations


def _zero(calibration: Calibration | None) -> Part:
    """Return the error of a calibrated encoder in the middle of the levels of its line.

    That is home, and there the line is known best: by what the caliper scattered, over the root of
    how often it was read.
    """
    if calibration is None:
        return 0.0, math.inf
    scattered, levels = calibration.provenance.residual_rms, calibration.provenance.blocks
    if scattered is None or levels is None or levels <= _FITTED:
        return 0.0, math.inf
    freedom = float(levels - _FITTED)
    return scattered / math.sqrt(freedom), freedom
