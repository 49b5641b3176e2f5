"""Leak of every chamber, from the air that is gone after it was locked in for a while.

A regulator makes up for whatever leaks. So a valve at the cylinder has to shut the air in
(`lock_bit` of each channel). The monitor sits at the regulator, on the other side of that valve,
and is blind meanwhile. It sees the chamber again for the milliseconds after the valve has opened.
The regulators then have set-points far below, so that their exhausts stand wide open. Air leaves a
chamber through a choked orifice (ISO 6358) in proportion to its pressure. So

    p_opened(s) = h(s) p_1

with one h for all waits at a place, s being the time since the valve's command to open. How fast
valve, exhaust and monitor are is in h. The leak is choked, too: shut in for t,

    p_1 V_1 = p_0 V_0 exp(-r t),        r = C rho_0 R T / V,

and the logarithm of p_opened over p_0, both from the same monitor, falls with t in a straight line
of slope -r. Each wait is a repetition of its own: their scatter about the lines makes the
intervals.

The volume of a chamber with its tube is not well known, but its change with the rod's position is.
So the chambers leak at two places of the rods, and

    1 / C = rho_0 R T (1 / r_2 - 1 / r_1) / (V_2 - V_1)

needs nothing but the piston's area and the rods' way. The interval is that of the right side,
which is nearly linear in the rates; its inverse is not symmetrical.

References
----------
ISO 6358-1:2013, Pneumatic fluid power: determination of flow-rate characteristics.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from rig.assembly import make_controller
from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate, Fit, fit_or_refuse
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel
from rig.calibration.recording import CalibrationRefused, Recording, RigLacks
from rig.config import Profile
from rig.mechanisms.pneumatic.calibration.lock_cycles import (
    BEFORE,
    OPENED,
    SHUT,
    LockCycles,
    LockScript,
)
from rig.mechanisms.pneumatic.calibration.pneumatics import AnyPneumatics, PneumaticProcedure

ATMOSPHERE: Final = 101_325.0
_FLOW: Final = 1.185 * 287.05 * 293.15
"""Density at reference conditions times R T: from a conductance to the volume that it lets out, Pa.
"""

_PRESSURE: Final = 340e3
_BELOW: Final = 120e3
_WAITS: Final = (0.4, 4.0, 2.0, 0.4, 4.0, 2.0, 0.4, 4.0)
"""How long the chambers are shut, s; long and short by turns, so that a drift is no slope."""

_WIDE: Final = 40e3
"""By so much a chamber has to be above its regulator for the exhaust to stand wide open, Pa."""

_LEAST_ROWS: Final = 3
_SLIPPED: Final = 0.5e-3
"""A rod that moves further meanwhile has slipped, m: what its air does then is not isothermal."""

_GIVE: Final = 1e-3
"""How far a joint's wire may seem to move while the monitors are blind, m: three times their give.
"""

_BOUND: Final = 5e-3
"""rms of the residuals, 1: a few times the noise of a monitor."""


class _Waits(NamedTuple):
    """Waits of one chamber that are judged, one element per wait.

    Parameters
    ----------
    place : ndarray
        +1 or -1.
    time : ndarray
        For how long it was shut, s.
    left : ndarray
        Logarithm of the pressure right after over that before, as if the volume had stayed.
    volume : ndarray
        Of the chamber but for a part that is always the same, m³.
    """

    place: Array
    time: Array
    left: Array
    volume: Array


class Leak(PneumaticProcedure):
    """Procedure for the leak of every chamber."""

    name = "leak"
    title = "leak of the chambers, locked in for a while"

    def check_rig(self, profile: Profile) -> None:
        """Refuse a rig whose chambers cannot be locked.

        Raises
        ------
        RigLacks
            A chamber cannot be: says which, and what it takes.
        """
        _check_locks(self._of(profile))

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the waits that are not done.

        Raises
        ------
        RigLacks
            A chamber cannot be locked: says which, and what it takes.
        """
        self.check_rig(profile)
        pneumatics = self._of(profile)
        cycles = _cycles(pneumatics, done)
        wider, notes = pneumatics.with_wider_limits()
        wider, more = self._of(wider).with_blind_monitors(_GIVE)
        wider, name = self._of(wider).with_gentle_controller()
        moved = self._of(wider)
        script = LockScript(cycles, moved, make_controller(wider, name))
        return moved.scripted(cycles, script, name, (*notes, *more), 3.0, follows=True)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit the rates at both places."""
        pneumatics = self._of(profile)
        cycles = _cycles(pneumatics, ())
        data.require(segment.name for segment in cycles.segments)
        estimates: list[Estimate] = []
        residuals: list[Array] = []
        panels: list[Panel] = []
        notes: list[str] = []
        for channel in pneumatics.channels:
            waits = _waits(pneumatics, data, cycles, channel)
            found = _fit_rates(channel, waits)
            rates = found.values[:2]
            estimates.append(
                found.estimate(
                    f"leak.{channel}.rate", "1/s", (0.5, 0.5, 0.0, 0.0), float(rates.mean())
                )
            )
            conductance = _conductance(channel, waits, found)
            if conductance is None:
                most = max(found.parameter(k, "", "").high for k in (0, 1))
                notes.append(
                    f"{channel} loses at most {100.0 * most:.2g} % of its air in a second: too "
                    "little to tell by how much less where it is larger, and so its conductance"
                )
            else:
                estimates.append(conductance)
            residuals.append(found.residuals)
            panels.append(_panel(channel, waits, found))
        return (
            Finding(
                profile.mechanism, {}, estimates, np.concatenate(residuals), "1", _BOUND,
                len(_WAITS), panels, notes=notes,
            ),
        )  # fmt: skip


def _check_locks(pneumatics: AnyPneumatics) -> None:
    device = pneumatics.regulators
    pneumatics.need_regulators("its air cannot be locked in: a spool in the middle leaks")
    channels = pneumatics.profile.devices[device].settings.channels
    # Another's module may have its channels otherwise, and then says nothing of locks.
    known = channels if isinstance(channels, Mapping) else {}
    locks = {name: getattr(known.get(name), "lock_bit", None) for name in pneumatics.channels}
    open_ended = [name for name, bit in locks.items() if bit is None]
    if open_ended:
        key = f"devices.{device}.channels.{open_ended[0]}.lock_bit"
        raise RigLacks(
            f"the air of {', '.join(open_ended)} cannot be locked in: a regulator makes up for "
            "what its chamber loses; it takes a valve between the two, at the cylinder, and the "
            f"output that opens it as {key}" + (" and so on" if len(open_ended) > 1 else "")
        )


def _cycles(pneumatics: AnyPneumatics, done: Sequence[str]) -> LockCycles:
    rows = [
        (f"{'in' if place > 0 else 'out'} {k + 1}", place, wait)
        for place in (1, -1)
        for k, wait in enumerate(_WAITS)
    ]
    looks = (BEFORE, SHUT, OPENED)
    rows = [row for row in rows if not all(f"{row[0]} {look}" in done for look in looks)]
    names, places, waits = zip(*rows, strict=True) if rows else ((), (), ())
    travel = pneumatics.reach(pneumatics.locked_share)
    return LockCycles(travel, _PRESSURE, _BELOW, names, places, waits)


def _waits(
    pneumatics: AnyPneumatics, recording: Recording, cycles: LockCycles, channel: str
) -> _Waits:
    """Return what is judged of a chamber.

    Raises
    ------
    CalibrationRefused
        Too few waits tell anything; says why.
    """
    area, stroke = pneumatics.area, pneumatics.stroke
    monitor, period = f"reading.pressure_{channel}", pneumatics.profile.loop.period
    parts = []
    for place in (1, -1):
        traces, rows, slipped = [], [], 0
        for cycle in (cycle for cycle in cycles.cycles() if cycle.place == place):
            before, shut, opened = (
                recording[f"{cycle.name} {look}"] for look in (BEFORE, SHUT, OPENED)
            )
            x_0, x_1 = (pneumatics.extension(part, channel).mean() for part in (before, shut))
            if abs(x_1 - x_0) > _SLIPPED:
                slipped += 1
                continue
            v_0, v_1 = (area * (stroke - float(x)) for x in (x_0, x_1))
            # The tube's volume beside the cylinder's is not known: the wires' give is small.
            tube = 0.5 * area * stroke
            swelled = (v_1 - v_0) / (tube + v_1)
            after = np.rint((opened["t"] - opened["t"][0]) / period).astype(int)
            trace = np.full(after[-1] + 1, np.nan)
            trace[after] = opened[monitor] + ATMOSPHERE
            traces.append((trace, shut.mean(monitor) + ATMOSPHERE))
            start = math.log(before.mean(monitor) + ATMOSPHERE) - swelled
            rows.append((float(place), cycle.open - cycle.lock, start, tube + v_1))
        length = min((len(trace) for trace, _ in traces), default=0)
        seen = np.array([trace[:length] - behind for trace, behind in traces])
        if len(rows) < 5:
            raise CalibrationRefused(
                f"{channel}: its rod slipped in {slipped} of {len(_WAITS)} waits: too few are left"
            )
        wide = np.flatnonzero((seen > _WIDE).all(axis=0))
        if len(wide) < _LEAST_ROWS:
            raise CalibrationRefused(_nothing_seen(channel, seen, [time for _, time, *_ in rows]))
        pressures = np.array([trace[wide] for trace, _ in traces])
        table = np.array(rows)
        # What leaves, by leak and exhaust, leaves a chamber that crept larger in proportion later.
        left = np.log(pressures).mean(axis=1) - table[:, 2]
        table[:, 2] = left * table[:, 3] / table[:, 3].mean()
        parts.append(table)
    return _Waits(*np.concatenate(parts).T)


def _nothing_seen(channel: str, seen: Array, times: Sequence[float]) -> str:
    shortest = np.array(times) < 1.0
    if np.nanmax(seen[shortest], initial=0.0) > _WIDE:
        return (
            f"{channel}: after {max(times):g} s there is too little air left in the chamber to "
            "tell how fast it went: is its tube off?"
        )
    return (
        f"{channel}: the monitor does not show the chamber when the lock valve opens: does the "
        "valve of its lock_bit sit between regulator and cylinder, and does it open?"
    )


def _fit_rates(channel: str, waits: _Waits) -> Fit:
    """Fit the rates at both places (1/s), and where the lines begin."""
    inside = waits.place > 0

    def residuals(q: Array) -> Array:
        rate, begin = np.where(inside, q[0], q[1]), np.where(inside, q[2], q[3])
        return np.asarray(waits.left - begin + rate * waits.time)

    return fit_or_refuse(channel, residuals, (0.005, 0.005, 0.0, 0.0), (0.01, 0.01, 0.1, 0.1))


def _conductance(channel: str, waits: _Waits, found: Fit) -> Estimate | None:
    """Return the sonic conductance, m³/(s Pa); None if the rates do not tell it."""
    inside = waits.place > 0
    more = float(waits.volume[~inside].mean() - waits.volume[inside].mean())
    one, other = (float(rate) for rate in found.values[:2])
    if min(one, other) <= 0.0:
        return None
    per = _FLOW / more
    gradient = (per / one**2, -per / other**2, 0.0, 0.0)
    inverse = found.estimate("", "", gradient, per * (1.0 / other - 1.0 / one))
    if inverse.low <= 0.0:
        return None
    return inverse.inverse(f"leak.{channel}.conductance", "m^3/(s Pa)")


def _panel(channel: str, waits: _Waits, found: Fit) -> Panel:
    begin = np.where(waits.place > 0, found.values[2], found.values[3])
    return Panel(
        f"{channel}: what is left", "shut for (s)", "of what it had (%)", "residual (%)",
        waits.time, 100.0 * np.exp(waits.left - begin),
        100.0 * np.exp(waits.left - begin - found.residuals), np.full_like(waits.time, 100.0),
    )  # fmt: skip
