"""What a pose of the joint withstands while its pressures are held."""

from typing import NamedTuple

import numpy as np

from rig.experiment.measure import Measure, Window, Windows

_LEAST = 1e-7
"""Less motion than this (m) is noise of the encoders."""


class Yielding(NamedTuple):
    """The way in which a pose gave way to a push on the pair (ch1, ch3).

    Parameters
    ----------
    pressure : float
        Mean of the four chambers, Pa gauge.
    force : float
        Amplitude of the pair's force, by the monitored pressures, N.
    rods : float
        Amplitude of the pair's position, m.
    lag : float
        By how much the position comes after the force, rad: what friction takes.
    """

    pressure: float
    force: float
    rods: float
    lag: float

    @property
    def stiffness(self) -> float:
        """Force over motion, N/m."""
        return self.force / self.rods


def yielding(window: Window) -> Yielding:
    """Return how a pose gave way in a window of whole periods.

    Raises
    ------
    ValueError
        Nothing moved, or not with one frequency.
    """
    force = window.column("estimate.tension_ch1") - window.column("estimate.tension_ch3")
    position = 0.5 * (window.column("reading.rod_ch1") - window.column("reading.rod_ch3"))
    force, position = force - force.mean(), position - position.mean()
    spectrum = np.abs(np.fft.rfft(force))
    number = 1 + int(np.argmax(spectrum[1:]))
    push, answer = (np.fft.rfft(signal)[number] * 2.0 / len(force) for signal in (force, position))
    if abs(answer) < _LEAST:
        raise ValueError(f"{window.segment.name}: the rods moved by less than {_LEAST:g} m")
    pressure = np.mean(window.columns("reading.pressure_"))
    return Yielding(
        float(pressure), float(abs(push)), float(abs(answer)), float(np.angle(push / answer))
    )


def pose_stiffness_least(windows: Windows) -> float:
    """Return the least stiffness of the pose at any mean pressure, N/m at the pair's rods."""
    return min(yielding(window).stiffness for window in windows)


def pose_stiffness_gain(windows: Windows) -> float:
    """Return the stiffness at the last mean pressure over that at the first."""
    return yielding(windows[-1]).stiffness / yielding(windows[0]).stiffness


def push_slip(windows: Windows) -> float:
    """Return how far the pair came to rest from where it was before it was pushed, m."""
    return max(
        abs(float(position[-1] - position[0]))
        for position in (
            0.5 * (window.column("reading.rod_ch1") - window.column("reading.rod_ch3"))
            for window in windows
        )
    )


STIFFNESS_MEASURES: dict[str, Measure] = {
    "pose_stiffness_least": Measure(
        pose_stiffness_least, "N/m", "least stiffness of the pose, at the rods of a pair"
    ),
    "pose_stiffness_gain": Measure(
        pose_stiffness_gain, "", "stiffness at the last mean pressure over that at the first"
    ),
    "push_slip": Measure(push_slip, "m", "what the pair has slipped after a push"),
}
