"""Wires: how far the rods stand out when the wires are just taut, and how they give.

All chambers rise and fall together. The mean of the rods' extensions is what the wires leave of
their free length; on the way up the seals' friction keeps a part of the pull from the wire, on the
way down it adds to it. The extrapolation to no pull and no friction is `home`. Seals keep up with
the rods only after their bristles have bent over, which puts both ways off to the same side:
`rig.mechanisms.pneumatic.calibration.wire_fit` follows them over the whole way. How soft the
bristles are is seen where the pressure turns round, in steps that are small.

Of a joint this is the mean of all rods, which hardly depends on how the ring stands; for what the
single ones have beyond it, see `rig.mechanisms.joint.calibration.wire_offsets`.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from rig.calibration.estimates import Estimate
from rig.calibration.instruments import Instrument
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.joint.calibration.wire_offsets import inclinometers, wire_offsets
from rig.mechanisms.pneumatic.calibration.pneumatics import open_loop, pneumatics_of, relaxed
from rig.mechanisms.pneumatic.calibration.pressure_steps import PressureSteps
from rig.mechanisms.pneumatic.calibration.wire_fit import Level, fit_wires

SWEEPS: Final = 3
LEVELS: Final = 6
_TURN: Final = (0.3, 0.6, 1.0, 1.5, 2.2)
"""Steps after the upper turn, in spacings of the levels: while the bristles bend over."""

_GOLDEN: Final = 0.618
"""Its multiples leave remainders that are spread evenly."""

_ROOM: Final = 3e-3
"""By how much more than usual the rods may disagree, m: it is the wires that are looked for."""

_BOUND: Final = 20e-6
_UNSTEADY: Final = (
    "whole sweeps err together (F test, 99.9 %), so that the intervals are too narrow: does the "
    "rig drift, does a wire creep?"
)
_LEAST_GIVE: Final = 50e-6


class Wires:
    """Wire offset, stiffness and pretension."""

    name = "wires"
    title = "wire offset, stiffness and pretension"

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
        steps = [step for sweep in range(SWEEPS) for step in _sweep(profile, sweep) if step[0]]
        recording.require(name for name, _, _ in steps)
        settings = profile.mechanism_settings
        levels = [level for sweep in range(SWEEPS) for level in _levels(profile, recording, sweep)]
        seen = [level for level in levels if not math.isnan(level.extension)]
        extension = np.array([level.extension for level in seen])
        pull = np.array([level.pull for level in seen])
        if np.ptp(extension) < _LEAST_GIVE:
            raise CalibrationRefused(
                f"the rods moved by {1e6 * np.ptp(extension):.3g} µm while the pull went through "
                f"{np.ptp(pull):.3g} N: too little to tell where the wires are slack; is one off?"
            )
        try:
            found, fitted, steady = fit_wires(levels)
        except ValueError as error:
            raise CalibrationRefused(f"the wires: {error}") from error
        home, give = (1e-3 * float(value) for value in found.values[:2])
        if give <= 0.0:
            raise CalibrationRefused("the rods come out as the pull grows: an encoder is reversed")
        base = settings.area * settings.base_pressure
        # Of a pair nobody believes anything: its controllers do without.
        gave = 1.0 / settings.wire_stiffness if profile.mechanism == "joint" else 0.0
        panel = Panel(
            "mean extension of the rods", "pull of a chamber (N)", "extension (mm)",
            "residual (µm)", pull, 1e3 * extension, 1e3 * fitted,
            1e3 * (settings.home - gave * pull), 1e3,
        )  # fmt: skip
        told = found.estimate("home", "m", (1e-3, 0, 0, 0, 0), home)
        gives = found.estimate("give", "m/N", (0, 1e-3, 0, 0, 0), give)
        values: dict[str, Any] = {}
        single: tuple[Estimate, ...] = ()
        notes: tuple[str, ...] = () if steady else (_UNSTEADY,)
        if profile.mechanism == "joint":
            wires = wire_offsets(profile, recording, readings, _read(profile), found)
            if wires is None:
                notes += ("nobody read the inclinometer on the ring: single wires are not told",)
            else:
                values["wire_offsets"] = [quantity(offset, "m") for offset in wires.offsets]
                told, gives, single = wires.home, wires.give, wires.single
        values["home"] = quantity(told.value, "m")
        stretch = Estimate("wire.stretch", gives.value * base, "m", *(base * x for x in gives[3:]))
        stiffness = Estimate(
            "wire.stiffness", 1.0 / gives.value, "N/m", gives.std / gives.value**2,
            1.0 / gives.high, 1.0 / gives.low,
        )  # fmt: skip
        if profile.mechanism == "joint":
            values["wire_stiffness"] = quantity(stiffness.value, "N/m")
        return (
            Finding(
                profile.mechanism, values, (told, stiffness, stretch, *single),
                extension - fitted, "m", _BOUND, 2 * SWEEPS, (panel,), notes=notes,
            ),
        )  # fmt: skip


def _levels(profile: Profile, recording: Recording, sweep: int) -> list[Level]:
    """Return all steps of a sweep.

    What is only passed is not recorded: its pressure is what was asked for, less what those that
    are recorded lack of it.
    """
    pneumatics, area = pneumatics_of(profile), profile.mechanism_settings.area
    channels, steps = pneumatics.channels, list(_sweep(profile, sweep))
    pressures = {
        name: sum(recording[name].mean(f"reading.pressure_{c}") for c in channels) / len(channels)
        for name, *_ in steps
        if name
    }
    lack = float(np.mean([p - pressures[name] for name, p, _ in steps if name]))
    return [
        Level(
            sweep, side, area * pressures.get(name, p - lack),
            sum(pneumatics.extension(recording[name], c).mean() for c in channels) / len(channels)
            if name else math.nan,
        )
        for name, p, side in steps
    ]  # fmt: skip


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
        yield f"sweep {sweep + 1} up {k + 1}", low + shift + (_uneven(k) + 5.0) * spacing, 1
    for k, passed in enumerate((0.0, *_TURN)):
        yield f"sweep {sweep + 1} turn {k}", high + (0.5 - passed) * spacing, 0
    yield "", high - 3.0 * spacing, 0
    for k in reversed(range(LEVELS)):
        yield f"sweep {sweep + 1} down {k + 1}", low + shift + (_uneven(k) + 0.2) * spacing, -1


def _uneven(level: int) -> float:
    """Return a level's place in spacings, such that what encoders round off never comes again.

    At even ones whole sweeps would err together wherever a spacing is a whole number of steps.
    """
    return level + 0.2 * (_GOLDEN * level % 1.0)


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
