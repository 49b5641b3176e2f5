"""The rod's zero, from a short move: where the rod is unstrained, it pulls neither crank.

Across the rod, at a quarter of a turn, the right crank is led and lagged by some milliradians. The
drives give way to the rod: what they are off is its torque over their stiffness. A straight line
through that over the twist crosses zero where the rod is unstrained. Each twist is held twice,
reached from below and from above, so that friction cancels.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Gt, Unit

from controllers.minimum_jerk import minimum_jerk
from crank_rig.crank.types import CrankCommand, CrankReference, CrankState
from rig.calibration.estimates import fit
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel, Procedure, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.calibration.sequence import ScriptedMotion
from rig.config import Profile, format_quantity
from rig.hal import Segment

_BOUND = 1e-3
"""Of the residuals' rms, rad: above it the rod is no spring."""


@dataclass(frozen=True, slots=True)
class Twists:
    """Twists in equal steps, up and down again.

    Parameters
    ----------
    most : float
        The greatest, to either side, rad.
    hold : float
        How long each is held, s; its second half is judged.
    """

    most: Annotated[float, Unit("rad"), Gt(0)] = 0.03
    hold: Annotated[float, Unit("s"), Gt(0)] = 0.6

    @property
    def steps(self) -> tuple[tuple[str, float], ...]:
        """Names and twists, rad."""
        up = [self.most * (k / 3.0 - 1.0) for k in range(7)]
        return (
            *((f"{1e3 * twist:+.0f} mrad up", twist) for twist in up),
            *((f"{1e3 * twist:+.0f} mrad down", twist) for twist in reversed(up)),
        )


class TwistMoves(ScriptedMotion[CrankReference, CrankState, CrankCommand]):
    """The cranks a quarter of a turn up, and the right one's lead from step to step.

    It is its own controller: a law would trim the twists away.
    """

    def __init__(self, twists: Twists) -> None:
        self._twists = twists
        self._levels = [twists.steps[0][1], *(twist for _, twist in twists.steps)]
        super().__init__(
            twists.hold * len(twists.steps) + 0.1,
            [
                Segment(name, (k + 0.5) * twists.hold, (k + 1.0) * twists.hold)
                for k, (name, _) in enumerate(twists.steps)
            ],
        )

    def describe(self) -> Iterator[str]:
        """Yield what moves and how far."""
        most = format_quantity(self._twists.most, "rad")
        yield f"the cranks stand at a quarter of a turn, and the right one leads by up to ±{most}"

    def reference_at(self, t: float) -> CrankReference:
        """Return where the cranks should be at `t`."""
        hold = self._twists.hold
        k = min(int(t / hold), len(self._levels) - 2)
        start, end = self._levels[k : k + 2]
        twist, speed, _ = minimum_jerk(start, end, 0.3 * hold, t - k * hold)
        return CrankReference((0.5 * math.pi, 0.5 * math.pi + twist), (0.0, speed))

    def play(self) -> Iterator[CrankCommand]:
        """Yield the reference as the command."""
        while True:
            yield CrankCommand(self.wanted.positions, self.wanted.velocities)


class RodZero(Procedure[Recording]):
    """The procedure that finds the twist at which the rod is unstrained."""

    name = "rod-zero"
    title = "twist at which the rod is unstrained"

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the twists; friction has a memory, so none is left out."""
        twists = Twists()
        script = TwistMoves(twists)
        return Excitation(twists, script, script, "twists", profile, script.describe)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit the line and take its zero."""
        names = [name for name, _ in Twists().steps]
        data.require(names)
        twist = np.array([_lead(data, name, "reading") for name in names])
        off = np.array([_lead(data, name, "applied") for name in names]) - twist
        try:
            line = fit(lambda p: off - p[1] * (twist - p[0]), (0.0, 1.0), (1e-2, 1.0))
        except ValueError as error:
            raise CalibrationRefused(f"the rod does not pull: {error}") from error
        zero = float(line.values[0])
        before = line.values[1] * (twist - profile.mechanism_settings.rod_zero)
        panel = Panel(
            "rod", "lead of the right crank (mrad)", "what the drives are off (mrad)",
            "residual (µrad)", 1e3 * twist, 1e3 * off, 1e3 * (off - line.residuals),
            1e3 * before, 1e3,
        )  # fmt: skip
        return [
            Finding(
                profile.mechanism,
                {"rod_zero": quantity(zero, "rad")},
                (line.parameter(0, "rod_zero", "rad"),),
                line.residuals,
                "rad",
                _BOUND,
                len(names),
                (panel,),
            )
        ]


def _lead(recording: Recording, stretch: str, group: str) -> float:
    rows = recording[stretch]
    return rows.mean(f"{group}.position_right") - rows.mean(f"{group}.position_left")
