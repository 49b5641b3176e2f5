"""Encoders of the rods: zero, direction and scale against a caliper.

The pair goes to one level after the other and stays, and a joint's ring leans so that all four
rods move; at each level somebody measures how far every rod stands out. The extension is a
straight line through what the encoder counted.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from rig.assembly import make_controller
from rig.calibration.arrays import Array
from rig.calibration.estimates import fit_or_refuse
from rig.calibration.instruments import Instrument, Readings, shown_in
from rig.calibration.procedure import Excitation, Finding, Panel, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.cylinder.references import Staircase
from rig.mechanisms.pneumatic.calibration.pneumatics import AnyPneumatics, PneumaticProcedure

CALIPER_ACCURACY: Final = 10e-6
"""Standard uncertainty of a reading of the caliper, m: a digital one of 0.01 mm."""

_SHARE: Final = 0.6
"""Of the permitted positions that is used."""

_LEVELS: Final = 15
_ROOM: Final = 5e-3
"""By how much the two rods may disagree more than usual: their zeros are what is looked for, m."""

_LEAST_TRAVEL: Final = 10e-3
_BOUND: Final = 50e-6


class Encoders(PneumaticProcedure):
    """Procedure for zero, direction and scale of the rods' encoders."""

    name = "encoders"
    title = "zero, direction and scale of the rods' encoders against a caliper"

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the encoders' files."""
        return self._of(profile).encoders

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return a caliper per rod, read at every level."""
        pneumatics = self._of(profile)
        names = tuple(segment.name for segment in _stairs(pneumatics).segments)
        return tuple(
            Instrument(f"caliper {channel}", "m", CALIPER_ACCURACY, names, f"extension_{channel}")
            for channel in pneumatics.channels
        )

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the levels; a staircase that was broken off is climbed again from its foot."""
        stairs = _stairs(self._of(profile))
        wider, notes = self._of(profile).with_wider_limits(_ROOM)
        wider, name = self._of(wider).with_placing_controller()
        controller, moved = make_controller(wider, name), self._of(wider)
        motion = moved.along_line(stairs, controller)
        return moved.excitation(stairs, motion, controller, name, notes, approach=3.0)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit a line per encoder."""
        pneumatics = self._of(profile)
        names = [segment.name for segment in _stairs(pneumatics).segments]
        data.require(names)
        findings = []
        for device, channel in zip(pneumatics.encoders, pneumatics.channels, strict=True):
            lack = f"the caliper of {channel} was not read"
            extension = np.array(shown_in(readings, f"caliper {channel}", names, lack))
            read = np.array([pneumatics.extension(data[n], channel).mean() for n in names])
            settings, nominal = (
                profile.devices[device].settings,
                profile.devices[device].nominal,
            )
            sign = -1.0 if settings.reversed else 1.0
            counted = sign * (read - settings.offset) / settings.scale
            before = sign * settings.scale * counted + settings.offset
            findings.append(_line(device, counted, extension, before, nominal.step or 1e-6))
        return findings


def _stairs(pneumatics: AnyPneumatics) -> Staircase:
    half = pneumatics.reach(_SHARE)
    count = _LEVELS // 2 + 1
    up = [half * (-1.0 + 2.0 * k / (count - 1)) for k in range(count)]
    down = [0.5 * (a + b) for a, b in pairwise(up)][::-1]
    # The first level is where the approach ends; it is not judged.
    return Staircase((0.0, *up, *down), rise=0.8, dwell=1.0)


def _line(
    device: str,
    counted: Array,
    extension: Array,
    before: Array,
    step: float,
) -> Finding:
    travel, moved = float(np.ptp(extension)), float(np.ptp(counted))
    if travel < _LEAST_TRAVEL:
        raise CalibrationRefused(
            f"{device}: the rod moved by {1e3 * travel:.3g} mm, at least "
            f"{1e3 * _LEAST_TRAVEL:g} mm are needed; is it stuck?"
        )
    if not 0.5 < moved / travel < 2.0:
        raise CalibrationRefused(
            f"{device}: the encoder went through {1e3 * moved:.3g} mm while the rod moved by "
            f"{1e3 * travel:.3g} mm: it is frozen, slips, or has another step"
        )
    middle = float(counted.mean())
    x = counted - middle
    found = fit_or_refuse(
        device, lambda q: 1e3 * (extension - q[0] - q[1] * x), (extension.mean(), 1.0), (1e-3, 1.0)
    )
    slope = float(found.values[1])
    zero = float(found.values[0]) - slope * middle
    sign = 1.0 if slope > 0.0 else -1.0
    residuals = found.residuals / 1e3
    fitted = extension - residuals
    panel = Panel(
        f"{device}", "counted (mm)", "caliper less it (mm)", "residual (µm)",
        1e3 * counted, 1e3 * (extension - counted), 1e3 * (fitted - counted),
        1e3 * (before - counted), 1e3,
    )  # fmt: skip
    return Finding(
        device,
        {"scale": float(f"{abs(slope):.9g}"), "offset": quantity(zero, "m"), "reversed": sign < 0},
        (
            found.estimate("scale", "1", (0.0, sign), abs(slope)),
            found.estimate("offset", "m", (1.0, -middle), zero),
        ),
        residuals, "m", max(_BOUND, 5.0 * step), len(x), (panel,),
    )  # fmt: skip
