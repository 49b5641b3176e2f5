"""When the truth of a pneumatic rig shows what nobody could tell before.

A regulator that takes longer than others, once it has lagged by more than any of them is off; a
chamber that leaks behind its monitor, once a rod of its pair has moved.
"""

from typing import Final

import numpy as np

from rig.faults.kind import Samples, Sizes

AT_REST_OFF: Final = 12e3
"""Pa: so much a regulator at rest and its monitor are off by catalogue, 2.4 % of 0.5 MPa."""
_ANSWERS: Final = 50e-3
"""s: by so much a healthy regulator lags behind a setpoint that moves on, twice its damping (1)
over its bandwidth (40 rad/s)."""
_OVER: Final = 1.0
"""s: what was longer ago is the past."""
_MOVED: Final = 1e-3
"""m: what stands gives by less when a pull of 40 N is gone, by wires and bristles."""


def lags(sizes: Sizes, times: Samples, truth: Samples) -> float | None:
    """Return when a slow regulator shows, s; None: it never does. See `Shows`.

    It lags by what it takes longer, times how fast its pressure moves. Nobody can tell it from a
    healthy one as long as that is less, rms over a second, than a healthy one may be off.
    """
    if len(times) < 2:
        return None
    lag = ((sizes.magnitude or 1.0) - 1.0) * _ANSWERS * np.gradient(truth[:, 0], times)
    power = np.concatenate([[0.0], np.cumsum(lag[1:] ** 2 * np.diff(times))])
    before = np.searchsorted(times, times - _OVER)
    shown = np.flatnonzero(power - power[before] > AT_REST_OFF**2 * _OVER)
    return float(times[shown[0]]) if shown.size else None


def moves(sizes: Sizes, times: Samples, truth: Samples) -> float | None:
    """Return when a rod has first moved, s; None: all stand where they did. See `Shows`.

    While seals hold a pair, one of its chambers may be empty, and the monitor at the other end of
    the tube shows nothing of it; another pair may go on as if nothing had happened.
    """
    if not len(times):
        return None
    moved = np.flatnonzero(np.max(np.abs(truth - truth[0]), axis=1) > _MOVED)
    return float(times[moved[0]]) if moved.size else None
