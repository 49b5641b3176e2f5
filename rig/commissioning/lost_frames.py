"""Frames that a bus has lost, by all that tells of one."""

from collections.abc import Mapping
from typing import Final

from rig.commissioning.step import MeasuredValue

_TELL: Final = ("lost", "held_samples", "lost_setpoints", "missed", "damaged")
"""Counters: of the controller, of readings that were incomplete, of setpoints that no device
heard, of answers of a chain that did not come or were none."""
MOST: Final = 1e-3
"""Of all frames: a bus repeats what was disturbed, and loses it where a plug is bad."""
BRIEFLY: Final = 5e-3
"""The same within a second, in which a pause of the computer counts for more."""


def lost_frames(when: str, name: str, counts: Mapping[str, float], most: float) -> MeasuredValue:
    """Return which share of a bus' frames was lost.

    A SYNC is left out after answers were missing, and once at the start: each is at least one.

    Parameters
    ----------
    when : str
        For its name: ``" under control"``.
    name : str
        The bus'.
    counts : mapping of str to float
        Its counters.
    most : float
        Permitted share.
    """
    gaps = max(counts.get("omitted_syncs", 0.0) - 1.0, 0.0)
    lost = sum(counts.get(what, 0.0) for what in _TELL) + gaps
    frames = sum(counts.get(f"frames_{way}", 0.0) for way in ("in", "out"))
    # Of a chain bytes are counted: a telegram has some sixteen.
    frames = frames or sum(counts.get(f"bytes_{way}", 0.0) for way in ("in", "out")) / 16.0
    share = lost / frames if frames else lost
    return MeasuredValue(
        f"share of the frames on {name} that are lost{when}", share, "1", high=most
    )
