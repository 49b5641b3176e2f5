"""How slow a motion has to be: the same path with less speed, and the words for it."""

import dataclasses
import math
from typing import Any, NamedTuple

from controllers.arm.paths import Circle, DwellLine
from controllers.arm.trajectories import ArmPathSettings
from controllers.arm.turn_path import TurnPath
from controllers.rounding import floor


class Slower(NamedTuple):
    """A path that is passed more slowly.

    Parameters
    ----------
    path : object
        Its settings.
    words : str
        What has changed: ``"at 0.05 m/s"``.
    """

    path: ArmPathSettings
    words: str


def slower_path(path: ArmPathSettings, factor: float) -> Slower | None:
    """Return a path that takes at least `factor` times as long, in numbers of four digits.

    None: the settings have no speed, as those of another package's paths may.
    """
    settings: Any = path
    if isinstance(path, Circle | TurnPath):
        rate = floor(path.rate / factor)
        about = " round the circle" if isinstance(path, Circle) else ""
        return Slower(dataclasses.replace(path, rate=rate), f"at a rate of {rate:g} rad/s{about}")
    if isinstance(path, DwellLine):
        speed = floor(path.speed / factor)
        dwell = float(f"{path.dwell * path.speed / speed:.6g}")
        changed: ArmPathSettings = dataclasses.replace(path, speed=speed, dwell=dwell)
        return Slower(changed, f"at {speed:g} m/s with a dwell of {dwell:g} s")
    if not hasattr(path, "speed"):
        return None
    changes, words = {"speed": floor(settings.speed / factor)}, "at {speed:g} m/s"
    turn_rate = getattr(path, "turn_rate", 0.0)
    if turn_rate:
        changes["turn_rate"] = math.copysign(floor(abs(turn_rate) / factor), turn_rate)
        words += " and {turn_rate:g} rad/s"
    return Slower(dataclasses.replace(settings, **changes), words.format(**changes))
