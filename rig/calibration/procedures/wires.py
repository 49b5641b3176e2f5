"""Wires of a pair: how far the rods stand out when the wires are just taut, and how they give.

All chambers rise and fall together. The mean of the rods' extensions is what the wires leave of
their free length,

    (x_a + x_b) / 2 = home - (A p - side (f_0 + f_1 p)) / k,

side +1 on the way up: the seals' friction then keeps a part of the pull from the wire. The
extrapolation to no pull is `home`. As the pressure changes, the friction follows only after the
rod has gone the seals' presliding distance, behind on both ways, which makes the mean of both
ways too short by f_1 / A times that distance: the intercept is corrected for it.
"""

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from rig.calibration.estimates import fit, interval
from rig.calibration.excitation import PressureSteps
from rig.calibration.instruments import Instrument
from rig.calibration.mechanism import open_loop, pneumatics_of
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile

SWEEPS: Final = 3
LEVELS: Final = 6
_BOUND: Final = 20e-6
_PRESLIDING: Final = (30e-6, 10e-6)
"""Distance in which the bristles of a seal follow a change, and its standard uncertainty, m."""

_LEAST_GIVE: Final = 50e-6


class Wires:
    """Wire offset, stiffness and pretension of a pair."""

    name = "wires"
    title = "wire offset, stiffness and pretension"
    mechanisms = ("cylinder",)

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the mechanism's file."""
        return (profile.mechanism,)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return none: the encoders measure it."""
        return ()

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the sweeps that are not done as a whole."""
        pneumatics = pneumatics_of(profile)
        steps = [
            step
            for sweep in range(SWEEPS)
            for step in _sweep(profile, sweep)
            if not all(name in done for name, _, _ in _sweep(profile, sweep) if name)
        ]
        plan = PressureSteps(
            tuple(name for name, _, _ in steps), tuple(p for _, p, _ in steps),
            ramp=0.5, dwell=0.6, judged=0.3,
        ) if steps else PressureSteps(("",), (pneumatics.lowest,))  # fmt: skip
        times, pressures = plan.knots(profile.mechanism_settings.base_pressure)
        motion = open_loop(profile, times, [(p, p) for p in pressures], plan.segments)
        settings = profile.mechanism_settings
        wider = dataclasses.replace(settings.limits, mismatch=settings.limits.mismatch + 3e-3)
        relaxed = dataclasses.replace(
            profile, mechanism_settings=dataclasses.replace(settings, limits=wider)
        )
        note = f"limits.mismatch is {1e3 * wider.mismatch:g} mm: it rests on the home looked for"
        return Excitation(plan, motion, motion, "open-loop", relaxed, (note,), approach=0.5)

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Fit free length, compliance and friction."""
        steps = [
            (sweep, *step) for sweep in range(SWEEPS) for step in _sweep(profile, sweep) if step[0]
        ]
        recording.require(name for _, name, _, _ in steps)
        settings = profile.mechanism_settings
        sides = np.array([side for *_, side in steps], float)
        groups = np.array([2 * sweep + (side > 0) for sweep, _, _, side in steps])
        extension = np.array([_mean(recording, name, "reading.position") for _, name, *_ in steps])
        pull = settings.area * np.array(
            [_mean(recording, name, "reading.pressure") for _, name, _, _ in steps]
        )
        if np.ptp(extension) < _LEAST_GIVE:
            raise CalibrationRefused(
                f"the rods moved by {1e6 * np.ptp(extension):.3g} µm while the pull went through "
                f"{np.ptp(pull):.3g} N: too little to tell where the wires are slack; is one off?"
            )
        start = (1e3 * float(extension.max()), 0.01, 0.03, 0.0)
        try:
            found = fit(
                lambda q: 1e3 * extension - (q[0] - q[1] * pull + sides * (q[2] + q[3] * pull)),
                start, (1.0, 0.01, 0.01, 1e-3), groups=groups,
            )  # fmt: skip
        except ValueError as error:
            raise CalibrationRefused(f"the wires: {error}") from error
        give, growth = 1e-3 * found.values[1], found.values[3] / found.values[1]
        home = 1e-3 * found.values[0] + growth * _PRESLIDING[0]
        if give <= 0.0:
            raise CalibrationRefused("the rods come out as the pull grows: an encoder is reversed")
        residuals = 1e-3 * found.residuals
        base = settings.area * settings.base_pressure
        stretch = 1e-3 * (found.values[1] * base)
        panel = Panel(
            "mean extension of the rods", "pull of a chamber (N)", "extension (mm)",
            "residual (µm)", pull, 1e3 * extension, 1e3 * (extension - residuals),
            np.full_like(pull, 1e3 * settings.home),
        )  # fmt: skip
        return (
            Finding(
                profile.mechanism,
                {"home": quantity(float(home), "m")},
                (
                    interval(
                        "home", float(home), "m",
                        math.hypot(1e-3 * found.covariance[0, 0] ** 0.5, growth * _PRESLIDING[1]),
                        found.freedom,
                    ),
                    found.estimate("wire.stiffness", "N/m", (0, 1e-3 / give**2, 0, 0), 1.0 / give),
                    found.estimate("wire.stretch", "m", (0, 1e-3 * base, 0, 0), float(stretch)),
                ),
                residuals, "m", _BOUND, len(set(groups)), (panel,),
            ),
        )  # fmt: skip


def _sweep(profile: Profile, sweep: int) -> Iterator[tuple[str, float, int]]:
    """Yield name (empty: not judged), pressure and side of the steps of one sweep."""
    pneumatics = pneumatics_of(profile)
    low, high = pneumatics.lowest, 0.9 * pneumatics.highest
    spacing = (high - low) / (LEVELS + 5)
    shift = 0.3 * spacing * sweep
    # After each turn the seals' bristles bend over before the seals slide the other way: what
    # lies between is passed and not judged.
    for passed in (0.0, 2.0, 4.0):
        yield "", low + passed * spacing, 0
    for k in range(LEVELS):
        yield f"sweep {sweep + 1} up {k + 1}", low + shift + (k + 5.0) * spacing, 1
    for passed in (0.0, 2.0, 4.0):
        yield "", high + 0.5 * spacing - passed * spacing, 0
    for k in reversed(range(LEVELS)):
        yield f"sweep {sweep + 1} down {k + 1}", low + shift + (k + 0.8) * spacing, -1


def _mean(recording: Recording, name: str, column: str) -> float:
    part = recording[name]
    return 0.5 * (part.mean(f"{column}_agonist") + part.mean(f"{column}_antagonist"))
