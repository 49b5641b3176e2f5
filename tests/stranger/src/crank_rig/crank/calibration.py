"""The rod's zero, from a short move: where the rod is unstrained, it pulls neither crank.

Across the rod, at a quarter of a turn, the right crank is led and lagged by some milliradians. The
drives give way to the rod: what they are off is its torque over their stiffness. A straight line
through that over the twist crosses zero where the rod is unstrained. Each twist is held twice,
reached from below and from above, so that friction cancels.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Gt, Unit

from controllers.minimum_jerk import minimum_jerk
from crank_rig.crank.types import CrankReference
from rig.assembly import make_controller
from rig.calibration.estimates import fit
from rig.calibration.instruments import Instrument
from rig.calibration.procedure import Excitation, Finding, Panel, Readings, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.calibration.sequence import ScriptedMotion
from rig.config import Profile
from rig.hal import Segment

_LAW = "independent"
"""The one law that does not trim the twists away."""
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


class TwistMoves(ScriptedMotion[CrankReference]):
    """The cranks a quarter of a turn up, and the right one's lead from step to step."""

    def __init__(self, twists: Twists) -> None:
        self._hold = twists.hold
        self._levels = [twists.steps[0][1], *(twist for _, twist in twists.steps)]
        super().__init__(
            twists.hold * len(twists.steps) + 0.1,
            [
                Segment(name, (k + 0.5) * twists.hold, (k + 1.0) * twists.hold)
                for k, (name, _) in enumerate(twists.steps)
            ],
        )

    def at(self, t: float) -> CrankReference:
        """Return where the cranks should be at `t`."""
        k = min(int(t / self._hold), len(self._levels) - 2)
        into = t - k * self._hold
        twist, speed, _ = minimum_jerk(self._levels[k], self._levels[k + 1], 0.3 * self._hold, into)
        return CrankReference((0.5 * math.pi, 0.5 * math.pi + twist), (0.0, speed))


class RodZero:
    """The twist at which the rod is unstrained."""

    name = "rod-zero"
    title = "twist at which the rod is unstrained"

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the file that it writes: the mechanism's."""
        return (profile.mechanism,)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return none: the drives' own encoders suffice."""
        return ()

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the twists; friction has a memory, so none is left out."""
        twists = Twists()
        controller = make_controller(profile, _LAW)
        return Excitation(twists, TwistMoves(twists), controller, _LAW, profile)

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Fit the line and take its zero."""
        names = [name for name, _ in Twists().steps]
        recording.require(names)
        twist = np.array([_lead(recording, name, "reading") for name in names])
        off = np.array([_lead(recording, name, "applied") for name in names]) - twist
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
