"""Wires: the rods' extension where they are just taut, and their stiffness.

All chambers rise and fall together, and the wires stretch. On the way up the seals' friction keeps
a part of the pull from the wire, on the way down it adds to it. The mean extension of the rods,
extrapolated to no pull and no friction, is `home`. Seals slide only after their bristles have bent
over, which shifts both ways to the same side: `rig.mechanisms.pneumatic.calibration.wire_fit`
models that over the whole way. Small steps where the pressure turns round show how soft the
bristles are. What the readings of calibrated encoders and monitors are off by, all of them alike,
is part of the intervals: `rig.mechanisms.pneumatic.calibration.rod_readings`.

The mean of a joint's rods hardly depends on how the ring stands. For the single wires see
`rig.mechanisms.joint.calibration.wire_offsets`.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from rig.calibration.estimates import Estimate, Fit, interval, welch
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.pneumatic.calibration.pneumatics import AnyPneumatics, PneumaticProcedure
from rig.mechanisms.pneumatic.calibration.pressure_steps import PressureSteps
from rig.mechanisms.pneumatic.calibration.rod_readings import in_mean, rod_errors
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


class WireEstimates(NamedTuple):
    """Extensions at which the wires are taut, and their compliance.

    Parameters
    ----------
    home : Estimate
        Extension of the rods where the wires are just taut, in their mean, m.
    compliance : Estimate
        Of a wire, m/N.
    each : tuple of Estimate
        Where each single wire is taut, if that is known.
    offsets : tuple of float
        How much further each rod stands out than the mean of all, m, if that is known.
    notes : tuple of str
        What was not found.
    """

    home: Estimate
    compliance: Estimate
    each: tuple[Estimate, ...] = ()
    offsets: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()


class WireSweeps(PneumaticProcedure):
    """Procedure for wire offset, stiffness and pretension."""

    name = "wires"
    title = "wire offset, stiffness and pretension"

    def believed_stiffness(self, profile: Profile) -> float | None:
        """Return the wires' stiffness that the profile has, N/m; None if it has none."""
        return None

    def with_single_wires(
        self, profile: Profile, data: Recording, readings: Readings, found: Fit, mean: WireEstimates
    ) -> WireEstimates:
        """Return what is known beyond the mean of all rods; default: nothing.

        Parameters
        ----------
        profile, data, readings
            See `identify`.
        found : Fit
            Of the mean of all rods: home (mm), compliance (mm/N) and three of the seals.
        mean : WireEstimates
            What follows from it.
        """
        return mean

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the sweeps that are not done as a whole."""
        pneumatics = self._of(profile)
        steps = [
            step
            for sweep in range(SWEEPS)
            for step in _sweep(pneumatics, sweep)
            if not all(name in done for name, _, _ in _sweep(pneumatics, sweep) if name)
        ]
        plan = PressureSteps(
            tuple(name for name, _, _ in steps), tuple(p for _, p, _ in steps),
            ramp=0.5, dwell=0.6, judged=0.3,
        ) if steps else PressureSteps(("",), (pneumatics.lowest,))  # fmt: skip
        return pneumatics.together(plan, _ROOM, approach=0.5)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit free length, compliance and friction."""
        pneumatics = self._of(profile)
        every = [step for sweep in range(SWEEPS) for step in _sweep(pneumatics, sweep)]
        data.require(name for name, _, _ in every if name)
        levels = [level for sweep in range(SWEEPS) for level in _levels(pneumatics, data, sweep)]
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
        home, compliance = (1e-3 * float(value) for value in found.values[:2])
        if compliance <= 0.0:
            raise CalibrationRefused("the rods come out as the pull grows: an encoder is reversed")
        rods = rod_errors(profile, pneumatics)
        wires = WireEstimates(
            _with_errors(
                found.estimate("home", "m", (1e-3, 0, 0, 0, 0), home), found.freedom,
                in_mean([rod.home(pneumatics.area, compliance) for rod in rods]),
            ),
            _with_errors(
                found.estimate("compliance", "m/N", (0, 1e-3, 0, 0, 0), compliance), found.freedom,
                in_mean([rod.compliance(compliance) for rod in rods]),
            ),
            notes=() if steady else (_UNSTEADY,),
        )  # fmt: skip
        wires = self.with_single_wires(profile, data, readings, found, wires)
        stiffness, stretch = _stiffness(
            wires.compliance, pneumatics.area * pneumatics.base_pressure
        )
        values: dict[str, object] = {}
        if wires.offsets:
            values["wire_offsets"] = [quantity(offset, "m") for offset in wires.offsets]
        values["home"] = quantity(wires.home.value, "m")
        believed = self.believed_stiffness(profile)
        if believed is not None:
            values["wire_stiffness"] = quantity(stiffness.value, "N/m")
        # A controller that knows no stiffness takes the wires as rigid.
        before = 0.0 if believed is None else 1.0 / believed
        panel = Panel(
            "mean extension of the rods", "pull of a chamber (N)", "extension (mm)",
            "residual (µm)", pull, 1e3 * extension, 1e3 * fitted,
            1e3 * (profile.mechanism_settings.home - before * pull), 1e3,
        )  # fmt: skip
        return (
            Finding(
                profile.mechanism, values, (wires.home, stiffness, stretch, *wires.each),
                extension - fitted, "m", _BOUND, 2 * SWEEPS, (panel,), notes=wires.notes,
            ),
        )  # fmt: skip


def ends_of_sweeps() -> dict[str, int]:
    """Return the first and last stretch of each way, and whether it goes up (+1) or down (-1)."""
    return {
        f"sweep {sweep + 1} {name}": side
        for sweep in range(SWEEPS)
        for name, side in (
            ("up 1", 1), (f"up {LEVELS}", 1), (f"down {LEVELS}", -1), ("down 1", -1)
        )
    }  # fmt: skip


def _with_errors(
    scattered: Estimate, freedom: float, errors: Sequence[tuple[float, float]]
) -> Estimate:
    """Return an estimate that errs besides by what its readings have in common.

    Parameters
    ----------
    scattered : Estimate
        As the levels scatter.
    freedom : float
        Degrees of freedom of that.
    errors : sequence of tuple
        Standard deviation, in the estimate's unit, and degrees of freedom of each.
    """
    std, known = welch([(scattered.std, freedom), *errors])
    return interval(scattered.name, scattered.value, scattered.unit, std, known)


def _stiffness(compliance: Estimate, base_pull: float) -> tuple[Estimate, Estimate]:
    """Return the stiffness of a wire, and its stretch under the pull at base pressure (N)."""
    spread = (base_pull * x for x in (compliance.std, compliance.low, compliance.high))
    stretch = Estimate("wire.stretch", compliance.value * base_pull, "m", *spread)
    return compliance.inverse("wire.stiffness", "N/m"), stretch


def _levels(pneumatics: AnyPneumatics, recording: Recording, sweep: int) -> list[Level]:
    """Return all steps of a sweep.

    A step that is only passed is not recorded. It lacks as much of its setpoint as recorded steps
    do in the mean.
    """
    channels, steps = pneumatics.channels, list(_sweep(pneumatics, sweep))
    pressures = {
        name: sum(recording[name].mean(f"reading.pressure_{c}") for c in channels) / len(channels)
        for name, *_ in steps
        if name
    }
    lack = float(np.mean([p - pressures[name] for name, p, _ in steps if name]))
    return [
        Level(
            sweep, side, pneumatics.area * pressures.get(name, p - lack),
            sum(pneumatics.extension(recording[name], c).mean() for c in channels) / len(channels)
            if name else math.nan,
        )
        for name, p, side in steps
    ]  # fmt: skip


def _sweep(pneumatics: AnyPneumatics, sweep: int) -> Iterator[tuple[str, float, int]]:
    """Yield name (empty: not recorded), pressure and side (0: not on a line) of a sweep's steps."""
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
