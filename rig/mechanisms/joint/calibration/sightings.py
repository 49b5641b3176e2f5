"""From the log of a joint to frames: where the camera saw the marker, and the rods just then."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from rig.calibration.arrays import Array, between_rows
from rig.calibration.recording import CalibrationRefused, Recording, Stretch
from rig.config import Profile
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.joint.calibration.sighting_model import Sightings, rotation

_HALF: Final = 2e-3
"""A rod's speed is its way from so long before to so long after, s."""

_REVERSAL: Final = 30e-6
"""Way over which friction turns round with a rod, m: seals and wire give that far. E."""

_STEP: Final = 1.3
"""Factor on it over which a slope is taken."""

_SEEN: Final = 0.5
"""Of the frames of a stretch that have to show the marker."""

_FRESH: Final = 0.25
"""A stamp is another frame's if it is later by this share of the frames' interval."""

_LEAST_FORCE: Final = 0.1
"""Keeps a belief without friction defined, N."""

_LEAST_TRAVEL: Final = 10e-3
"""Every rod has to move so far, m."""


class Track(NamedTuple):
    """Signals of the rods over the whole recording; n rows, a column for each rod.

    Parameters
    ----------
    t : ndarray, shape (n,)
        When that was, s.
    rods, pulls : ndarray, shape (n, 4)
        Extension of each rod, m, and pull of its chamber, N.
    senses, turns, falls, loads : ndarray, shape (n, 4)
        See `Sightings`.
    """

    t: Array
    rods: Array
    pulls: Array
    senses: Array
    turns: Array
    falls: Array
    loads: Array

    def at(self, t: Array, column: Array) -> Array:
        """Return some columns at other times, shape (m, 4)."""
        return between_rows(column, self.t, t)


def track_of(profile: Profile, recording: Recording, names: Sequence[str]) -> Track:
    """Return what the rods did over stretches that follow each other.

    As a whole: how friction acts on a rod that rests is known from how it came there.
    """
    settings = profile.mechanism_settings
    parts = [recording[name] for name in names]

    def column(name: str) -> Array:
        return np.concatenate([part[name] for part in parts])

    t = column("t") - column("reading.age")
    base = settings.area * settings.base_pressure
    columns = []
    for channel in JointPneumatics(profile).channels:
        rod = column(f"reading.rod_{channel}")  # its shortening from home
        limit = limits_of(rod, t, settings.friction)
        raised = 1.0 + _STEP * (limit - 1.0)
        slow, quick, more = (
            senses_of(rod, most, _REVERSAL * by)
            for most, by in ((limit, _STEP), (limit, 1.0 / _STEP), (raised, 1.0))
        )
        turn = (slow - quick) / (2.0 * np.log(_STEP))
        sense, plain = (senses_of(rod, most, _REVERSAL) for most in (limit, np.ones_like(rod)))
        fall = (more - sense) / (_STEP - 1.0)
        pull = settings.area * column(f"reading.pressure_{channel}")
        load = (pull - base) * plain
        columns.append((settings.home - rod, pull, sense, turn, fall, load))
    return Track(t, *(np.column_stack(each) for each in zip(*columns, strict=True)))


def sightings_of(
    profile: Profile, recording: Recording, names: Sequence[str], track: Track, late: float = 0.0
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
    track : Track
        What the rods did.
    late : float
        By how much later than its stamp says a frame came than it was exposed, s, as far as that
        is known: the rods are taken so much earlier.

    Raises
    ------
    CalibrationRefused
        The marker was out of sight for too long.
    """
    frames = [_frames(profile, recording[name], name) for name in names]
    rays, stamps = (np.concatenate(each) for each in zip(*frames, strict=True))
    blocks = np.repeat(np.arange(len(names)), [len(stamp) for _, stamp in frames])
    at = stamps - late
    known = (at > track.t[0] + _HALF) & (at < track.t[-1] - _HALF)
    rays, at, blocks = rays[known], at[known], blocks[known]
    rods, pulls, senses, turns, falls, loads = (track.at(at, column) for column in track[1:])
    before, after = (track.at(at + step, track.rods) for step in (-_HALF, _HALF))
    speeds = (before - after) / (2.0 * _HALF)
    return Sightings(rays, rods, speeds, pulls, senses, turns, falls, loads, blocks, at, late)


def check_travel(profile: Profile, seen: Sightings) -> None:
    """Refuse what moved too little to tell anything.

    Raises
    ------
    CalibrationRefused
        A rod hardly moved; which one, and by how much.
    """
    channels = JointPneumatics(profile).channels
    for channel, travel in zip(channels, np.ptp(seen.rods, axis=0), strict=True):
        if travel < _LEAST_TRAVEL:
            raise CalibrationRefused(
                f"the rod of {channel} moved by {1e3 * travel:.3g} mm, at least "
                f"{1e3 * _LEAST_TRAVEL:g} mm are needed: is it stuck, or its encoder frozen?"
            )


def _frames(profile: Profile, rows: Stretch, name: str) -> tuple[Array, Array]:
    """Return ray and stamp of each frame of a stretch."""
    camera = profile.devices[profile.mechanism_settings.camera].settings
    t, age = rows["t"], rows["reading.marker_age"]
    stamp = t - age
    fresh = np.diff(stamp, prepend=stamp[0]) > _FRESH / camera.frame_rate
    fresh &= age >= 0.0
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
    return rays / rays[:, 2:], stamp[fresh]


def limits_of(rod: Array, t: Array, friction: Any) -> Array:
    """Return how much friction a seal can hold at each instant, over what it holds when quick.

    Parameters
    ----------
    rod : ndarray, shape (n,)
        Its shortening, m.
    t : ndarray, shape (n,)
        When, s.
    friction : object
        What is believed: breakaway, coulomb, stribeck_velocity.
    """
    speed = np.gradient(rod, t)
    excess = max(friction.breakaway - friction.coulomb, 0.0) / max(friction.coulomb, _LEAST_FORCE)
    return np.asarray(1.0 + excess * np.exp(-((speed / friction.stribeck_velocity) ** 2)))


def senses_of(rod: Array, limit: Array, reversal: float) -> Array:
    """Return friction on a rod over its Coulomb friction, for its way over time; 1: it pulls in.

    Parameters
    ----------
    rod : ndarray, shape (n,)
        Its shortening, m.
    limit : ndarray, shape (n,)
        See `limits_of`.
    reversal : float
        Way over which friction turns round, m.

    Notes
    -----
    Dahl's model with a limit that falls with the speed, solved for each step as if its speed
    were even: friction turns round over a short way, not at once.
    """
    step = np.diff(rod, prepend=rod[0])
    keep = np.exp(-np.abs(step) / (reversal * limit))
    gain = np.sign(step) * limit * (1.0 - keep)
    sense, senses = 0.0, []
    for share, more in zip(keep.tolist(), gain.tolist(), strict=True):
        sense = share * sense + more
        senses.append(sense)
    return np.array(senses)
