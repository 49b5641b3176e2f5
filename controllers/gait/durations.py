"""What says how long a phase lasts, and a motion whose phases have the time that they need."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from controllers.gait.footsteps import FootstepsSettings, LegsMotion
from controllers.gait.geometry import LegGeometry
from controllers.gait.motions import SquatSettings
from controllers.gait.phases import DurationSetting, GaitPhase
from controllers.motion import InfeasibleMotion
from controllers.rounding import ceiling

_TRIES = 8
"""Motions that are tried for one whose phases all have the time that they need."""


class Need(NamedTuple):
    """The least time of a phase that was too short.

    Parameters
    ----------
    phase : GaitPhase
        As it was asked for.
    least : float
        s.
    """

    phase: GaitPhase
    least: float


class ShortPhases(InfeasibleMotion):
    """All phases of a motion that are too short; the message is of the first.

    Attributes
    ----------
    needs : tuple of Need
        One for each.
    """

    def __init__(self, message: str, needs: Sequence[Need]) -> None:
        super().__init__(message)
        self.needs = tuple(needs)


def find_longer(
    accept: Callable[[LegsMotion], None],
    motion: LegsMotion,
    refused: ShortPhases,
    geometry: LegGeometry,
    period: float,
) -> tuple[LegsMotion, str]:
    """Return a motion whose phases have the time that they need, and why it is refused still.

    Parameters
    ----------
    accept : callable
        Raises what a motion is refused with.
    motion : LegsMotion
        That was refused.
    refused : ShortPhases
        What it was refused with.
    geometry : LegGeometry
        Of the legs.
    period : float
        s; a phase that begins between two cycles may lose one.

    Notes
    -----
    Corners of the joints' curve count more or less at other times, so each motion is tried.
    """
    for _ in range(_TRIES):
        motion = _lengthened(motion, refused.needs, geometry, period)
        try:
            accept(motion)
        except ShortPhases as error:
            refused = error
        except InfeasibleMotion as error:
            return motion, str(error)
        else:
            return motion, ""
    return motion, str(refused)


def _lengthened(
    motion: LegsMotion, needs: Sequence[Need], geometry: LegGeometry, period: float
) -> LegsMotion:
    least: dict[DurationSetting, float] = {}
    for need in needs:
        timing = need.phase.timing
        least[timing] = max(need.least + 1.001 * period, least.get(timing, 0.0))
    times = {timing: ceiling(its * motion.speed) for timing, its in least.items()}
    if isinstance(motion, FootstepsSettings) and any(timing.step for timing in times):
        steps = list(motion.footsteps(geometry))
        for (setting, step), time in times.items():
            if step:
                was = steps[step - 1]
                steps[step - 1] = (
                    replace(was, shift=time) if setting == "shift" else replace(was, swing=time)
                )
        motion = replace(motion, file=None, numbers=None, steps=tuple(steps))
    common = {its.setting: time for its, time in times.items() if not its.step}
    if isinstance(motion, SquatSettings):
        return replace(motion, time=common.get("time", motion.time))
    changed = replace(
        motion,
        first_shift_time=common.get("first_shift_time", motion.first_shift_time),
        shift_time=common.get("shift_time", motion.shift_time),
        swing_time=common.get("swing_time", motion.swing_time),
    )
    if isinstance(changed, FootstepsSettings):
        last = common.get("last_shift_time", changed.last_shift_time)
        return replace(changed, last_shift_time=last)
    return changed


def name_times(asked: LegsMotion, longer: LegsMotion, geometry: LegGeometry) -> str:
    """Return the times that two motions differ in, as one says them: "swing_time at 4 s"."""
    words = [
        f"{key} at {getattr(longer, key):.4g} s instead of {getattr(asked, key):.4g} s"
        for key in ("time", "first_shift_time", "shift_time", "swing_time", "last_shift_time")
        if hasattr(asked, key) and getattr(asked, key) != getattr(longer, key)
    ]
    if isinstance(asked, FootstepsSettings) and isinstance(longer, FootstepsSettings):
        both = zip(asked.footsteps(geometry), longer.footsteps(geometry), strict=True)
        words += [
            f"the {key} of step {number} at {getattr(new, key):.4g} s instead of "
            f"{getattr(old, key):.4g} s"
            for number, (old, new) in enumerate(both, 1)
            for key in ("shift", "swing")
            if getattr(old, key) != getattr(new, key)
        ]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
