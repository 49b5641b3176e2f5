"""Wires: how far the rods stand out when the wires are just taut, and how they give.

All chambers rise and fall together. The mean of the rods' extensions is what the wires leave of
their free length,

    x = home - (A p - side (f_0 + f_1 A p)) / k,

side +1 on the way up: the seals' friction then keeps a part of the pull from the wire. The
extrapolation to no pull is `home`. While the friction grows with the pressure it follows only
after the bristles between seal and barrel have bent over, a length l = c f of the rod's way behind
on both ways, which puts the mean of both off by f_1 l; the intercept is corrected for it. How
soft the bristles are, c, is seen where the pressure turns round: there the friction changes from
f to -f as 2 f exp(-way / l) over the first steps, which are small.

Of a joint this is the mean of all rods, which hardly depends on how the ring stands; for what the
single ones have beyond it, see `rig.calibration.wire_offsets`.

References
----------
P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
"""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from rig.calibration.estimates import Estimate, fit, interval
from rig.calibration.excitation import PressureSteps
from rig.calibration.instruments import Instrument
from rig.calibration.mechanism import open_loop, pneumatics_of, relaxed
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.calibration.wire_offsets import inclinometers, wire_offsets
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SWEEPS: Final = 3
LEVELS: Final = 6
_TURN: Final = (0.3, 0.6, 1.0, 1.5, 2.2)
"""Steps after the upper turn, in spacings of the levels: while the bristles bend over."""

_ROOM: Final = 3e-3
"""By how much more than usual the rods may disagree, m: it is the wires that are looked for."""

_BOUND: Final = 20e-6
_LEAST_GIVE: Final = 50e-6


class Wires:
    """Wire offset, stiffness and pretension."""

    name = "wires"
    title = "wire offset, stiffness and pretension"
    mechanisms = ("cylinder", "joint")

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the mechanism's file."""
        return (profile.mechanism,)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return none for a pair: the encoders measure it; for a joint, how its ring stands."""
        return () if profile.mechanism == "cylinder" else inclinometers(tuple(_read(profile)))

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
        count = len(pneumatics.channels)
        motion = open_loop(profile, times, [(p,) * count for p in pressures], plan.segments)
        wider, notes = relaxed(profile, _ROOM)
        return Excitation(plan, motion, motion, "open-loop", wider, notes, approach=0.5)

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Fit free length, compliance and friction."""
        every = [step for sweep in range(SWEEPS) for step in _sweep(profile, sweep) if step[0]]
        recording.require(name for name, _, _ in every)
        steps = [(sweep, *s) for sweep in range(SWEEPS) for s in _sweep(profile, sweep) if s[2]]
        settings = profile.mechanism_settings
        sides = np.array([side for *_, side in steps], float)
        groups = np.array([2 * sweep + (side > 0) for sweep, _, _, side in steps])
        extension, pressure = _means(profile, recording, [name for _, name, *_ in steps])
        pull = settings.area * pressure
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
        give = 1e-3 * float(found.values[1])
        if give <= 0.0:
            raise CalibrationRefused("the rods come out as the pull grows: an encoder is reversed")
        # f_1 l for the friction at no pull, where the lines are extrapolated to, m.
        lag = [
            1e-3 * found.values[3] / give * soft * found.values[2] / found.values[1]
            for soft in _softness(profile, recording, found.values, settings.area)
        ]
        home = 1e-3 * float(found.values[0]) + float(np.mean(lag))
        spread = float(np.std(lag, ddof=1)) / math.sqrt(SWEEPS)
        base = settings.area * settings.base_pressure
        residuals = 1e-3 * found.residuals
        panel = Panel(
            "mean extension of the rods", "pull of a chamber (N)", "extension (mm)",
            "residual (µm)", pull, 1e3 * extension, 1e3 * (extension - residuals),
            np.full_like(pull, 1e3 * settings.home), 1e3,
        )  # fmt: skip
        values: dict[str, Any] = {}
        single: tuple[Estimate, ...] = ()
        notes: tuple[str, ...] = ()
        if profile.mechanism == "joint":
            wires = wire_offsets(profile, recording, readings, _read(profile), 1.0 / give)
            if wires is None:
                notes = ("nobody read the inclinometer on the ring: single wires are not told",)
            else:
                home, spread = home + wires.lean, math.hypot(spread, wires.lean_std)
                values["wire_offsets"] = [quantity(offset, "m") for offset in wires.offsets]
                single = wires.estimates
        values["home"] = quantity(home, "m")
        return (
            Finding(
                profile.mechanism, values,
                (
                    interval(
                        "home", home, "m",
                        math.hypot(1e-3 * found.covariance[0, 0] ** 0.5, spread), found.freedom,
                    ),
                    found.estimate("wire.stiffness", "N/m", (0, 1e-3 / give**2, 0, 0), 1.0 / give),
                    found.estimate("wire.stretch", "m", (0, 1e-3 * base, 0, 0), give * base),
                    *single,
                ),
                residuals, "m", _BOUND, len(set(groups.tolist())), (panel,),
                notes=notes,
            ),
        )  # fmt: skip


def _softness(
    profile: Profile, recording: Recording, lines: "Array", area: float
) -> "Iterator[float]":
    """Yield how far a bristle bends per newton, m/N, as each sweep's turn shows it.

    Parameters
    ----------
    profile, recording
        What was recorded.
    lines : ndarray, shape (4,)
        Of the ways up and down: mm, mm/N, mm and mm/N.
    area : float
        Of a piston, m².
    """
    from scipy.optimize import least_squares

    for sweep in range(SWEEPS):
        names = [name for name, _, side in _sweep(profile, sweep) if name and not side]
        x, pressure = _means(profile, recording, names)
        pull, way = area * pressure, x - x[0]
        loop = lines[2] + lines[3] * pull
        # What is left of the turn's friction, over all of it; 1 at the turn itself.
        left = (1e3 * x - (lines[0] - lines[1] * pull - loop)) / (2.0 * loop)
        bend = least_squares(lambda q: left - q[0] * np.exp(-way / q[1]), (1.0, 3e-5),  # noqa: B023
                             x_scale=(0.1, 1e-5), bounds=((0.5, 1e-7), (2.0, 1e-3)))  # fmt: skip
        yield float(bend.x[1] * lines[1] / loop[:3].mean())


def _sweep(profile: Profile, sweep: int) -> Iterator[tuple[str, float, int]]:
    """Yield name (empty: not recorded), pressure and side (0: not on a line) of a sweep's steps."""
    pneumatics = pneumatics_of(profile)
    low, high = pneumatics.lowest, 0.9 * pneumatics.highest
    spacing = (high - low) / (LEVELS + 5)
    shift = 0.3 * spacing * sweep
    # After each turn the seals' bristles bend over before the seals slide the other way: what
    # lies between is on neither line.
    for passed in (0.0, 2.0, 4.0):
        yield "", low + passed * spacing, 0
    for k in range(LEVELS):
        yield f"sweep {sweep + 1} up {k + 1}", low + shift + (k + 5.0) * spacing, 1
    for k, passed in enumerate((0.0, *_TURN)):
        yield f"sweep {sweep + 1} turn {k}", high + (0.5 - passed) * spacing, 0
    yield "", high - 3.0 * spacing, 0
    for k in reversed(range(LEVELS)):
        yield f"sweep {sweep + 1} down {k + 1}", low + shift + (k + 0.2) * spacing, -1


def _read(profile: Profile) -> dict[str, int]:
    """Return the stretches in which the inclinometer on a joint's ring is read, and their sides."""
    return {
        name: side
        for sweep in range(SWEEPS)
        for name, side in (
            (f"sweep {sweep + 1} up 1", 1), (f"sweep {sweep + 1} up {LEVELS}", 1),
            (f"sweep {sweep + 1} down {LEVELS}", -1), (f"sweep {sweep + 1} down 1", -1),
        )
    }  # fmt: skip


def _means(profile: Profile, recording: Recording, names: Sequence[str]) -> tuple["Array", "Array"]:
    """Return mean extension (m) and pressure (Pa) of all rods in each stretch."""
    pneumatics = pneumatics_of(profile)
    count = len(pneumatics.channels)
    parts = [recording[name] for name in names]
    return (
        np.array([sum(pneumatics.extension(p, c).mean() for c in pneumatics.channels) / count
                  for p in parts]),
        np.array([sum(p.mean(f"reading.pressure_{c}") for c in pneumatics.channels) / count
                  for p in parts]),
    )  # fmt: skip
