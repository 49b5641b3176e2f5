"""Proportional valves: where each begins to feed and to exhaust, and how much passes beyond.

All chambers rise and fall together in even ramps, some slow and some fast, so that the pulls cancel
and nothing moves. The inner loops hold them on their ramps, whatever the valves are like: the
openings that they need are in the log, and the pressures tell what flow passed. The flow is

    m = V p' / (n R T)

with the same polytropic exponent n as the loop has, and over what a choked port of 1 m³/(s Pa)
passes at these pressures it is the conductance G that an opening u makes,

    u = feeds_from + G (1 - feeds_from) / C    or    u = exhausts_from - G (1 + exhausts_from) / C.

So C is the conductance at full stroke of a port that goes on as it begins, near the middle, where a
loop lives. A leak past the lands is in the two openings, as it is for the loop. An error in the
volume of the chamber is in C as it is in the loop: there the two cancel.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from controllers.cylinder.valve_flow import ATMOSPHERE, flow_of_pressure, port_flow
from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate, Fit, fit_or_refuse
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel
from rig.calibration.recording import CalibrationRefused, Recording, RigLacks, Stretch
from rig.config import Profile
from rig.hal.devices import device_column
from rig.mechanisms.pneumatic.calibration.pneumatics import AnyPneumatics, PneumaticProcedure
from rig.mechanisms.pneumatic.calibration.pressure_steps import PressureSteps

REPEATS: Final = 5
_HEIGHTS: Final = (40e3, 80e3, 120e3, 160e3)
"""Of the ramps, Pa: what opens a valve by less is rounded by the loop."""
_RAMP: Final = 0.08
_DWELL: Final = 0.2
_SETTLED: Final = 0.4
"""Share of a ramp after which the loop follows it evenly."""
_LEAST_RISE: Final = 0.5
"""Share of its ramp that a pressure has to come to."""
_BOUND: Final = 4e-3
"""rms of the residuals, openings: the hysteresis of a spool, and as much again."""
_OPENING, _CONDUCTANCE = 1e-2, 1e-9


class _Points(NamedTuple):
    """Ramps of one valve in one direction, one element per ramp.

    Parameters
    ----------
    opening : ndarray
        That the loop gave.
    conductance : ndarray
        That passed, m³/(s Pa).
    """

    opening: Array
    conductance: Array


class Valves(PneumaticProcedure):
    """Procedure for dead zone and conductance of every valve."""

    name = "valves"
    title = "dead zone and conductance of proportional valves, from ramps of the pressures"

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the mechanism, if proportional valves feed it."""
        return () if profile.mechanism_settings.valves is None else super().targets(profile)

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the ramps that are not done.

        Raises
        ------
        RigLacks
            The rig has regulators.
        """
        pneumatics = self._of(profile)
        if profile.mechanism_settings.valves is None:
            raise RigLacks(
                f"{pneumatics.regulators} has regulators, whose valves have a loop of their own; "
                f"it takes proportional valves, and {profile.mechanism}.valves in the profile"
            )
        base = profile.mechanism_settings.base_pressure
        names: list[str] = []
        levels: list[float] = []
        for repeat in range(REPEATS):
            for number, height in enumerate(_HEIGHTS):
                pair = [_name(side, repeat, number) for side in ("up", "down")]
                if not all(name in done for name in pair):
                    names += pair
                    levels += [base + height, base]
        plan = PressureSteps(
            tuple(names), tuple(levels), ramp=_RAMP, dwell=_DWELL, judged=_DWELL + _RAMP
        )
        return pneumatics.together(plan, room=0.0, approach=1.0)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit both ports of every valve."""
        pneumatics = self._of(profile)
        repeats, heights = range(REPEATS), range(len(_HEIGHTS))
        names = {s: [_name(s, r, h) for r in repeats for h in heights] for s in ("up", "down")}
        data.require(name for side in names.values() for name in side)
        values: dict[str, object] = {}
        estimates: list[Estimate] = []
        residuals: list[Array] = []
        panels: list[Panel] = []
        for channel in pneumatics.channels:
            was = profile.mechanism_settings.valves.of(channel)
            found: dict[str, float] = {}
            for side, edge, port, sign, before in (
                ("up", "feeds_from", "conductance_in", 1.0, was.conductance_in),
                ("down", "exhausts_from", "conductance_out", -1.0, was.conductance_out),
            ):
                points = _points(pneumatics, [data[name] for name in names[side]], channel)
                fitted = _fit(channel, points, sign)
                start, slope = fitted.values
                conductance = (1.0 - sign * start) / (slope * _OPENING / _CONDUCTANCE)
                edge_was = getattr(was, edge)
                found[edge], found[port] = start, conductance
                estimates += [
                    fitted.parameter(0, f"{channel}.{edge}", "1"),
                    fitted.estimate(
                        f"{channel}.{port}", "m^3/(s Pa)",
                        (-sign * conductance / (1.0 - sign * start), -conductance / slope),
                        conductance,
                    ),
                ]  # fmt: skip
                residuals.append(fitted.residuals)
                line = edge_was + sign * points.conductance * (1.0 - sign * edge_was) / before
                panels.append(
                    Panel(
                        f"{channel}, {'feed' if sign > 0.0 else 'exhaust'}",
                        "conductance (1e-9 m³/(s Pa))", "opening (%)", "residual (%)",
                        points.conductance * 1e9, 100.0 * points.opening,
                        100.0 * (points.opening - fitted.residuals), 100.0 * line,
                    )
                )  # fmt: skip
            values[channel] = {name: float(f"{value:.4g}") for name, value in found.items()}
        return (
            Finding(
                profile.mechanism, {"valves": {"channels": values}}, estimates,
                np.concatenate(residuals), "1", _BOUND, REPEATS, panels,
            ),
        )  # fmt: skip


def _name(side: str, repeat: int, number: int) -> str:
    return f"{side} {repeat + 1}.{number + 1}"


def _points(pneumatics: AnyPneumatics, ramps: Sequence[Stretch], channel: str) -> _Points:
    """Return what each ramp says of a valve."""
    settings = pneumatics.profile.mechanism_settings
    supply = settings.valves.supply
    opening_of = device_column(pneumatics.regulators, f"opening_{channel}", "", "").name
    openings, conductances = [], []
    for ramp in ramps:
        applied = ramp[f"applied.{channel}"]
        moving = np.flatnonzero(np.abs(np.diff(applied, prepend=applied[0])) > 0.0)
        if len(moving) < _SETTLED * 10:
            raise CalibrationRefused(f"{channel}: a ramp of its set-point was clipped away")
        rows = moving[int(_SETTLED * len(moving)) :]
        t, pressure = ramp["t"][rows], ramp[f"reading.pressure_{channel}"][rows]
        slope, _ = np.polyfit(t - t.mean(), pressure, 1)
        wanted = np.polyfit(t - t.mean(), applied[rows], 1)[0]
        if slope / wanted < _LEAST_RISE:
            raise CalibrationRefused(
                f"{channel}: the pressure went at {slope / 1e3:.3g} kPa/s where "
                f"{wanted / 1e3:.3g} kPa/s were wanted; is the supply open, does the valve move?"
            )
        extension = float(pneumatics.extension(ramp, channel)[rows].mean())
        volume = settings.dead_volume + settings.area * (settings.stroke - extension)
        flow = flow_of_pressure(float(slope), volume)
        openings.append(float(ramp[opening_of][rows].mean()))
        passed = [port_flow(flow, p + ATMOSPHERE, supply) for p in pressure.tolist()]
        conductances.append(abs(flow) * float(np.mean(1.0 / np.array(passed))))
    return _Points(np.array(openings), np.array(conductances))


def _fit(channel: str, points: _Points, sign: float) -> Fit:
    """Fit opening over conductance: where it begins, and its slope in `_OPENING`/`_CONDUCTANCE`."""

    def residuals(q: Array) -> Array:
        line = q[0] + sign * q[1] * _OPENING * points.conductance / _CONDUCTANCE
        return np.asarray(points.opening - line)

    found = fit_or_refuse(
        f"the valve of {channel}", residuals, (0.015 * sign, 30.0), (_OPENING, 10.0)
    )
    if found.values[1] <= 0.0:
        raise CalibrationRefused(
            f"{channel}: the valve passes less the more it is opened; are the ports swapped?"
        )
    return found
