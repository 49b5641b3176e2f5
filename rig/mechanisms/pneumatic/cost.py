"""What a motion costs: the air that it takes, and what it asks of the regulators' valves.

Air is told for all chambers together, as one compressor fills them; what wears a valve is told for
the channel that has most of it, as the first valve that fails stops the rig. Where windows overlap,
each instant counts once.
"""

from collections.abc import Callable, Iterator
from itertools import chain
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.experiment.measure import Measure, Window, Windows, apart, columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_ATMOSPHERE: Final = 101_325.0
"""Of normal conditions, and around the rig, Pa."""
_ADIABATIC: Final = 1.4
"""Air fills a chamber faster than its walls take the heat. A chamber that fills in seconds takes up
to 1.4 times the air that is told here."""
_SMOOTHED: Final = 5e-3
"""Half of the time over which a pressure is smoothed, s: 60 Hz pass by 0.9."""
_SEEN: Final = 1e3
"""Pressure that has to come or go, at the mean volume, before it is air and not the monitor, Pa."""
_AT_ONCE: Final = 1 << 16
"""Cycles that are looked at together: what they take of memory does not grow with the run."""
_SWING: Final = 25e3
"""A setpoint has turned round once it came back by this, Pa: less moves no valve far."""


def turning_points(values: "Array", swing: float) -> Iterator[float]:
    """Yield the extremes between which a signal goes to and fro by more than `swing`.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The signal.
    swing : float
        Of its unit: what comes back by less has not turned round.

    Yields
    ------
    float
        The first and the last one are where it began and how far it got; none if it never went far.
    """
    steps = np.sign(np.diff(values))
    turns = np.flatnonzero(steps[1:] != steps[:-1]) + 1
    low = high = float(values[0])
    rises: bool | None = None
    for value in chain(_each(values[turns]), _each(values[-1:])):
        if rises is not True and value - low > swing:
            yield low
            rises, high = True, value
        elif rises is not False and high - value > swing:
            yield high
            rises, low = False, value
        low, high = min(low, value), max(high, value)
    if rises is not None:
        yield high if rises else low


def _each(values: "Array") -> Iterator[float]:
    for start in range(0, len(values), _AT_ONCE):
        yield from values[start : start + _AT_ONCE].tolist()


def reversals_of(setpoint: "Array") -> int:
    """Return how often a setpoint (Pa) turns round by 25 kPa."""
    return max(sum(1 for _ in turning_points(setpoint, _SWING)) - 2, 0)


def valve_reversals(windows: Windows) -> float:
    """Return how often a second the setpoint of the busiest channel turns round by 25 kPa, 1/s."""
    parts = apart(windows)
    turns = [[reversals_of(setpoint) for setpoint in _setpoints(part).T] for part in parts]
    return max(map(sum, zip(*turns, strict=True))) / _duration(parts)


def setpoint_rate(windows: Windows) -> float:
    """Return the mean absolute rate of the setpoint that moves most, Pa/s."""
    parts = apart(windows)
    ways = sum(np.abs(np.diff(_setpoints(part), axis=0)).sum(axis=0) for part in parts)
    return float(np.max(ways)) / _duration(parts)


def setpoint_range(windows: Windows) -> float:
    """Return the range of the setpoint that goes farthest, Pa."""
    setpoints = np.concatenate([_setpoints(window) for window in windows])
    return float(np.ptp(setpoints, axis=0).max())


def air_used(rods: str, sense: float) -> Callable[[Windows], float]:
    """Return what computes the air that goes into the chambers, m³/s at 1 atm and 20 °C.

    Parameters
    ----------
    rods : str
        Columns of the rods' readings, without the channel.
    sense : float
        1 if a chamber grows with the reading of its rod, -1 if it shrinks.
    """

    def compute(windows: Windows) -> float:
        parts = apart(windows)
        prefix = "reading.pressure_"
        names = [name.removeprefix(prefix) for name in parts[0].samples.names(prefix)]
        filled = sum(_filled(part, name, rods + name, sense) for part in parts for name in names)
        return filled / (_ADIABATIC * _ATMOSPHERE * _duration(parts))

    return compute


def _filled(window: Window, channel: str, rod: str, sense: float) -> float:
    """Return the air that has filled a chamber as 1.4 p V of its normal volume, J.

    ``V dp + 1.4 p dV`` is ``1.4 R T dm`` of what comes in, whether the piston stands or moves.
    """
    samples = window.samples
    drawn_out = sense * samples.constant("area") * window.column(rod)
    volume = samples.constant(f"volume_{channel}") + drawn_out
    half = round(_SMOOTHED / samples.period) if samples.period > 0.0 else 0
    pressure = _ATMOSPHERE + _smoothed(window.column(f"reading.pressure_{channel}"), half)
    mean_pressure, mean_volume = (0.5 * (x[1:] + x[:-1]) for x in (pressure, volume))
    steps = mean_volume * np.diff(pressure) + _ADIABATIC * mean_pressure * np.diff(volume)
    gained = np.concatenate([[0.0], np.cumsum(steps)])
    extremes = np.fromiter(turning_points(gained, _SEEN * float(volume.mean())), float)
    return float(np.maximum(np.diff(extremes), 0.0).sum())


def _smoothed(values: "Array", half: int) -> "Array":
    """Return parabolas fitted to `half` samples before and after each, shape (n,).

    References
    ----------
    A. Savitzky, M. J. E. Golay, Anal. Chem. 36(8), 1964 (second order).
    """
    half = min(half, (len(values) - 1) // 2)
    if half < 2:
        return values
    k = np.arange(-half, half + 1)
    weights = 3.0 * (3.0 * half * (half + 1) - 1.0 - 5.0 * k * k)
    weights /= (2 * half - 1) * (2 * half + 1) * (2 * half + 3)
    around = np.concatenate([[values[0]] * half, values, [values[-1]] * half])
    smooth = np.empty_like(values)
    for start in range(0, len(values), _AT_ONCE):
        piece = around[start : start + _AT_ONCE + 2 * half]
        smooth[start : start + _AT_ONCE] = np.convolve(piece, weights, "valid")
    return smooth


def _setpoints(window: Window) -> "Array":
    return columns("applied.")(window)


def _duration(parts: Windows) -> float:
    """Return how long windows last in all, s; ValueError if that is no time."""
    duration = float(sum(part.t[-1] - part.t[0] for part in parts))
    if duration <= 0.0:
        raise ValueError("a single instant has no rates")
    return duration


def _costs(rods: str, sense: float) -> dict[str, Measure]:
    return {
        "air_used": Measure(
            air_used(rods, sense), "m^3/s", "air into all chambers, at 1 atm and 20 °C"
        ),
        "valve_reversals": Measure(
            valve_reversals, "1/s", "turns of the busiest setpoint by more than 25 kPa"
        ),
        "setpoint_rate": Measure(
            setpoint_rate, "Pa/s", "mean absolute rate of the setpoint that moves most"
        ),
        "setpoint_range": Measure(setpoint_range, "Pa", "range of the setpoint that goes farthest"),
    }


PAIR_COSTS = _costs("reading.position_", -1.0)
JOINT_COSTS = _costs("reading.rod_", 1.0)
