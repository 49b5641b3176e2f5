"""From the log of a joint to frames: where the camera saw the marker, and the rods just then."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from rig.calibration.joint.model import Sightings, rotation
from rig.calibration.mechanism import pneumatics_of
from rig.calibration.recording import CalibrationRefused, Recording, Stretch
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_HALF: Final = 5e-3
"""A rod's speed is its way from so long before to so long after, s."""

_REVERSAL: Final = 30e-6
"""Way over which friction turns round with a rod, m: seals and wire give that far. E."""

_STEP: Final = 1.3
"""Factor on it over which a slope is taken."""

_SEEN: Final = 0.5
"""Of the frames of a stretch that have to show the marker."""

_FRESH: Final = 0.25
"""A stamp is another frame's if it is later by this share of the frames' interval."""

_LEAST_TRAVEL: Final = 10e-3
"""Every rod has to move so far, m."""


def sightings_of(
    profile: Profile, recording: Recording, names: Sequence[str], late: float = 0.0
) -> Sightings:
    """Return the frames of some stretches.

    Parameters
    ----------
    profile : Profile
        What the camera's driver believed.
    recording : Recording
        The log.
    names : sequence of str
        The stretches, each a block.
    late : float
        By how much later than its stamp says a frame came than it was exposed, s, as far as that
        is known: the rods are taken so much earlier.

    Raises
    ------
    CalibrationRefused
        The marker was out of sight for too long.
    """
    parts = [_frames(profile, recording[name], name, k, late) for k, name in enumerate(names)]
    columns: Any = zip(*(part[:-1] for part in parts), strict=True)
    return Sightings._make([*(np.concatenate(column) for column in columns), late])


def check_travel(profile: Profile, seen: Sightings) -> None:
    """Refuse what moved too little to tell anything.

    Raises
    ------
    CalibrationRefused
        A rod hardly moved; which one, and by how much.
    """
    channels = pneumatics_of(profile).channels
    for channel, travel in zip(channels, np.ptp(seen.rods, axis=0), strict=True):
        if travel < _LEAST_TRAVEL:
            raise CalibrationRefused(
                f"the rod of {channel} moved by {1e3 * travel:.3g} mm, at least "
                f"{1e3 * _LEAST_TRAVEL:g} mm are needed: is it stuck, or its encoder frozen?"
            )


def _frames(profile: Profile, rows: Stretch, name: str, block: int, late: float) -> Sightings:
    settings = profile.mechanism_settings
    camera = profile.devices[settings.camera].settings
    t, age = rows["t"], rows["reading.marker_age"]
    stamp = t - age
    fresh = np.diff(stamp, prepend=stamp[0]) > _FRESH / camera.frame_rate
    # The rods are only known since the stretch began.
    fresh &= (age >= 0.0) & (stamp - late > t[0] + _HALF)
    expected = (t[-1] - t[0]) * camera.frame_rate
    if np.count_nonzero(fresh) < _SEEN * expected:
        raise CalibrationRefused(
            f"the camera saw the marker in {np.count_nonzero(fresh)} frames of {name!r}, at least "
            f"{_SEEN * expected:.0f} of {expected:.0f} are needed: is it lit, and in view?"
        )
    marker = np.column_stack([rows[f"reading.marker_{axis}"][fresh] for axis in "xyz"])
    # Whatever lens and pose its driver believes in: back from there, the ray is what was seen.
    turn = rotation(np.array(camera.rotation_base_from_camera))
    rays = (marker - camera.position_camera_in_base) @ turn
    rays /= rays[:, 2:]
    at, sampled = stamp[fresh] - late, t - rows["reading.age"]
    columns = []
    for channel in pneumatics_of(profile).channels:
        rod = rows[f"reading.rod_{channel}"]  # its shortening from home
        later, before = (np.interp(at + step, sampled, rod) for step in (_HALF, -_HALF))
        pull = settings.area * np.interp(at, sampled, rows[f"reading.pressure_{channel}"])
        slow, quick = senses_of(rod, _REVERSAL * _STEP), senses_of(rod, _REVERSAL / _STEP)
        sense = np.interp(at, sampled, senses_of(rod, _REVERSAL))
        turn = np.interp(at, sampled, slow - quick) / (2.0 * np.log(_STEP))
        shown = settings.home - np.interp(at, sampled, rod)
        columns.append((shown, (later - before) / (2.0 * _HALF), pull, sense, turn))
    rods, speeds, pulls, senses, turns = (
        np.column_stack(each) for each in zip(*columns, strict=True)
    )
    block_of = np.full(len(at), block)
    return Sightings(rays, rods, speeds, pulls, senses, turns, block_of, at, late)


def senses_of(rod: "Array", reversal: float) -> "Array":
    """Return which way friction acts on a rod, -1 … 1, for its way over time.

    Parameters
    ----------
    rod : ndarray, shape (n,)
        Its shortening, m.
    reversal : float
        Way over which friction turns round, m.

    Notes
    -----
    Dahl's model: friction turns round over a short way, not at once.
    """
    sense, senses = 0.0, []
    for step in np.diff(rod, prepend=rod[0]).tolist():
        way = step / reversal
        sense = min(max(sense + way - abs(way) * sense, -1.0), 1.0)
        senses.append(sense)
    return np.array(senses)
