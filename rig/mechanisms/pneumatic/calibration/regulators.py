"""Regulators: set-point and monitor against a pressure gauge.

All chambers rise and fall together in steps, so that the pulls cancel and nothing moves. At each
step somebody reads a gauge on each chamber. The monitor is a straight line through the gauge's
readings. The set-point's characteristic is a line with a bow (the catalogue's linearity error,
zero at both ends) and a loop (hysteresis: the play of the regulator and the overlap of its valve),

    s = offset + gain c -/+ loop / 2,      P = s + 4 bow s (1 - s / FS)

with the minus sign on the way up; c is the set-point and P the chamber's pressure, gauge.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate, Fit, fit_or_refuse
from rig.calibration.instruments import Instrument, Readings, shown_in
from rig.calibration.procedure import Excitation, Finding, Panel, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.pneumatic.calibration.pneumatics import AnyPneumatics, PneumaticProcedure
from rig.mechanisms.pneumatic.calibration.pressure_steps import PressureSteps

SWEEPS: Final = 2
LEVELS: Final = 9

GAUGE_ACCURACY: Final = 100.0
"""Standard uncertainty of a reading of the gauge, Pa: a class 0.05 instrument of 600 kPa."""

_WHAT: Final = "the regulators' characteristic"
_BOUND: Final = 1.5e3
"""rms above which a fit is not to be used, Pa: 0.3 % of full scale."""


class Regulators(PneumaticProcedure):
    """Procedure for offset, gain, linearity and hysteresis of every regulator and monitor."""

    name = "regulators"
    title = "set-point and monitor of the regulators against a gauge"

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the module's file."""
        return (self._of(profile).regulators,)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return a gauge per chamber, read at every step."""
        pneumatics = self._of(profile)
        names = tuple(name for sweep in range(SWEEPS) for name, _, _ in _sweep(pneumatics, sweep))
        return tuple(
            Instrument(f"gauge {channel}", "Pa", GAUGE_ACCURACY, names, f"pressure_{channel}")
            for channel in pneumatics.channels
        )

    def check_rig(self, profile: Profile) -> None:
        """Refuse a rig on proportional valves."""
        why = "an opening is no set-point of a pressure: calibrate valves"
        self._of(profile).need_regulators(why)

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the sweeps that are not done as a whole."""
        self.check_rig(profile)
        names: list[str] = []
        levels: list[float] = []
        pneumatics = self._of(profile)
        for sweep in range(SWEEPS):
            steps = list(_sweep(pneumatics, sweep))
            if all(name in done for name, _, _ in steps):
                continue
            # Below the first and above the last step, so that each is reached from one side.
            rising = [step for step in steps if step[2] > 0]
            falling = [step for step in steps if step[2] < 0]
            names += ["", *(n for n, _, _ in rising), "", *(n for n, _, _ in falling)]
            levels += [
                pneumatics.lowest, *(p for _, p, _ in rising),
                pneumatics.highest, *(p for _, p, _ in falling),
            ]  # fmt: skip
        plan = PressureSteps(tuple(names), tuple(levels))
        return pneumatics.together(plan, room=0.0, approach=0.5)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit both characteristics of every channel."""
        pneumatics = self._of(profile)
        steps = [step for sweep in range(SWEEPS) for step in _sweep(pneumatics, sweep)]
        names, levels, ways = zip(*steps, strict=True)
        data.require(names)
        sides = np.array(ways, float)
        entry = profile.devices[pneumatics.regulators]
        values: dict[str, object] = {}
        estimates: list[Estimate] = []
        residuals: list[Array] = []
        panels: list[Panel] = []
        for channel in pneumatics.channels:
            wired, nominal = entry.settings.channels[channel], entry.nominal.channels[channel]
            lack = f"the gauge of {channel} was not read"
            gauge = np.array(shown_in(readings, f"gauge {channel}", names, lack))
            sent, read = (
                np.array([data[name].mean(column) for name in names])
                for column in (f"applied.{channel}", f"reading.pressure_{channel}")
            )
            _check(channel, np.array(levels), sent, gauge)
            # In the maker's terms, whatever calibration was in force while it was recorded.
            sent = _through(wired.setpoint, nominal.setpoint, sent)
            read = _through(wired.monitor, nominal.monitor, read)
            scale = max(nominal.setpoint.pressure)
            setpoint = _fit_setpoint(sent, gauge, sides, scale)
            monitor = _fit_line(read, gauge, scale)
            slope, zero = _best_line(setpoint.values, scale)
            a, b = monitor.values[1], monitor.values[0] * scale
            ends = [slope * p + zero for p in nominal.setpoint.pressure]
            values[channel] = {
                "setpoint": {"pressure": [quantity(p, "Pa") for p in ends]},
                "monitor": {
                    "pressure": [quantity(a * p + b, "Pa") for p in nominal.monitor.pressure]
                },
            }
            estimates += _setpoint_estimates(channel, setpoint, scale)
            estimates += [
                monitor.estimate(f"{channel}.monitor.offset", "Pa", (scale, 0.0), b),
                monitor.parameter(1, f"{channel}.monitor.gain", "1"),
            ]
            residuals += [setpoint.residuals * scale, monitor.residuals * scale]
            gain_was, zero_was = _line_between(nominal.setpoint, wired.setpoint)
            panels.append(
                _panel(
                    f"{channel}: set-point", "set-point (kPa)", sent, gauge,
                    gauge - setpoint.residuals * scale, gain_was * sent + zero_was,
                )
            )  # fmt: skip
            gain_was, zero_was = _line_between(nominal.monitor, wired.monitor)
            panels.append(
                _panel(
                    f"{channel}: monitor", "monitor (kPa)", read, gauge,
                    gauge - monitor.residuals * scale, gain_was * read + zero_was,
                )
            )  # fmt: skip
        return (
            Finding(
                pneumatics.regulators, {"channels": values}, estimates,
                np.concatenate(residuals), "Pa", _BOUND, len(steps), panels,
            ),
        )  # fmt: skip


def _sweep(pneumatics: AnyPneumatics, sweep: int) -> Iterator[tuple[str, float, int]]:
    """Yield name, pressure and side (+1 from below) of the steps of one sweep."""
    spacing = (pneumatics.highest - pneumatics.lowest) / (LEVELS + 1)
    # Each sweep has levels of its own: the converter's steps then err independently.
    shift = 0.5 * spacing * (sweep / SWEEPS)
    levels = [pneumatics.lowest + shift + spacing * (k + 0.75) for k in range(LEVELS)]
    for k, level in enumerate(levels):
        yield f"sweep {sweep + 1} up {k + 1}", level, 1
    for k, level in reversed(list(enumerate(levels))):
        yield f"sweep {sweep + 1} down {k + 1}", level - 0.2 * spacing, -1


def _check(channel: str, wanted: Array, sent: Array, gauge: Array) -> None:
    """Refuse a regulator that was clipped, does not follow or has run out of supply."""
    off = np.abs(sent - wanted).max()
    if off > 1e3:
        raise CalibrationRefused(
            f"{channel}: the set-point was clipped by {off:.0f} Pa; widen limits.pressure or "
            "limits.pressure_rate"
        )
    order = np.argsort(sent)
    x, y = sent[order], gauge[order]
    if np.ptp(y) < 0.2 * np.ptp(x):
        raise CalibrationRefused(
            f"{channel}: the gauge moved by {np.ptp(y) / 1e3:.3g} kPa while the set-point went "
            f"through {np.ptp(x) / 1e3:.4g} kPa: too little to tell a gain; is the supply open?"
        )
    third = len(x) // 3
    slope = np.polyfit(x[:-third], y[:-third], 1)
    top = y[-3:].mean() - np.polyval(slope, x[-3:]).mean()
    if abs(top) > 0.05 * np.ptp(x):
        raise CalibrationRefused(
            f"{channel}: above {x[-third] / 1e3:.4g} kPa the pressure leaves its line by "
            f"{top / 1e3:.3g} kPa: the regulator is saturated; is the supply pressure too low?"
        )


def _fit_setpoint(sent: Array, gauge: Array, sides: Array, scale: float) -> Fit:
    """Fit offset, gain, bow and loop, pressures over full scale."""
    c, p = sent / scale, gauge / scale

    def residuals(q: Array) -> Array:
        return p - _characteristic(c, sides, q)

    return fit_or_refuse(_WHAT, residuals, (0.0, 1.0, 0.0, 0.005), (1e-3, 1e-2, 1e-2, 1e-2))


def _characteristic(c: Array, sides: Array, q: Array) -> Array:
    offset, gain, bow, loop = q
    s = offset + gain * c - 0.5 * loop * sides
    return np.asarray(s + 4.0 * bow * s * (1.0 - s))


def _fit_line(read: Array, gauge: Array, scale: float) -> Fit:
    x, y = read / scale, gauge / scale
    return fit_or_refuse(_WHAT, lambda q: y - (q[0] + q[1] * x), (0.0, 1.0), (1e-3, 1e-2))


def _setpoint_estimates(channel: str, found: Fit, scale: float) -> list[Estimate]:
    offset, _, _, loop = found.values
    name = f"{channel}.setpoint"
    return [
        found.estimate(f"{name}.offset", "Pa", (scale, 0.0, 0.0, 0.0), float(offset * scale)),
        found.parameter(1, f"{name}.gain", "1"),
        found.parameter(2, f"{name}.linearity", "1"),
        found.estimate(f"{name}.hysteresis", "Pa", (0.0, 0.0, 0.0, scale), float(loop * scale)),
    ]


def _best_line(q: Array, scale: float) -> tuple[float, float]:
    """Return gain and offset (Pa) of the straight line that is nearest over the whole scale."""
    c = np.linspace(0.0, 1.0, 101)
    middle = _characteristic(c, np.zeros_like(c), q)
    gain, offset = np.polyfit(c, middle, 1)
    return float(gain), float(offset) * scale


def _line_between(one: Any, other: Any) -> tuple[float, float]:
    """Return the line from a pressure of one signal to that of the other's same counts."""
    a = (one.pressure[1] - one.pressure[0]) / (one.raw[1] - one.raw[0])
    b = (other.pressure[1] - other.pressure[0]) / (other.raw[1] - other.raw[0])
    gain = b / a
    return gain, other.pressure[0] - b * other.raw[0] - gain * (one.pressure[0] - a * one.raw[0])


def _through(one: Any, other: Any, pressure: Array) -> Array:
    gain, offset = _line_between(one, other)
    return gain * pressure + offset


def _panel(title: str, x_label: str, x: Array, y: Array, fitted: Array, before: Array) -> Panel:
    """Show what is off a perfect line, since the line itself would hide it."""
    return Panel(
        title, x_label, "gauge less it (kPa)", "residual (kPa)",
        x / 1e3, (y - x) / 1e3, (fitted - x) / 1e3, (before - x) / 1e3,
    )  # fmt: skip
