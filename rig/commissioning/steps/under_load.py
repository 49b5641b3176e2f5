"""Wake-ups of the computer and load of the buses while the law runs and the log is written."""

from pathlib import Path
from typing import Final, cast

import numpy as np

from rig.assembly.buses import bus_loads
from rig.commissioning.lost_frames import MOST, lost_frames
from rig.commissioning.step import MeasuredValue, require_within
from rig.config import Profile
from rig.run_folder import RunFolder
from rig.runtime.log import Log

_SHARES: Final = (50.0, 99.0, 99.9)
"""Of the wake-ups, %."""
_SET_UP: Final = 1.1
"""So much more than in the worst case of a cycle: the frames that set devices up are counted."""
_FEW: Final = 0.1
"""On a bus that has little to carry they are most; so full a bus may be anyhow."""


def judge_load(profile: Profile, folder: Path, log: Log) -> list[MeasuredValue]:
    """Return what a run has asked of computer and buses.

    Parameters
    ----------
    profile : Profile
        As it ran.
    folder : Path
        Of the run.
    log : Log
        Its log.

    Raises
    ------
    Defect
        A cycle came too late, frames were lost, or a bus is fuller than it may be.
    """
    period = profile.loop.period
    # Differences of virtual times are rounded by less than a nanosecond.
    late = np.round(log.column("timing.lateness"), 9)
    measured = [
        MeasuredValue(f"wake-ups under control, {share:g} % of them", float(value), "s")
        for share, value in zip(_SHARES, np.percentile(late, _SHARES), strict=True)
    ]
    most = profile.loop.max_missed * period
    latest = MeasuredValue("latest wake-up under control", float(late.max()), "s", high=most)
    measured.append(require_within("computer", latest, "cycles come too late under control"))
    seconds = len(late) * period
    counted = _counters(folder)
    for name, load in bus_loads(profile).items():
        counts = counted.get(name, {})
        in_bytes = "bytes_in" in counts
        unit = "bytes" if in_bytes else "frames"
        seen = (counts.get(f"{unit}_in", 0.0) + counts.get(f"{unit}_out", 0.0)) / seconds
        expected = sum(its.rate * (its.size if in_bytes else 1.0) for its in load.frames)
        share = MeasuredValue(
            f"load of the bus {name} under control, by its {unit}",
            load.total * seen / expected if expected else 0.0, "1",
            high=max(_SET_UP * load.total, _FEW),
        )  # fmt: skip
        measured.append(require_within(name, share, "the bus is fuller than it may be"))
        lost = lost_frames(" under control", name, counts, MOST)
        measured.append(require_within(name, lost, "frames are lost under control"))
    return measured


def _counters(folder: Path) -> dict[str, dict[str, float]]:
    """Return the counters of every bus, as the run's manifest has them."""
    manifest: dict[str, object] = dict(RunFolder.open(folder).manifest)
    return cast("dict[str, dict[str, float]]", manifest.get("buses", {}))
