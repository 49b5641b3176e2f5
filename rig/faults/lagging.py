"""When a regulator that takes longer than others has lagged by more than any of them is off."""

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


def lags(sizes: Sizes, times: Samples, pressures: Samples) -> float | None:
    """Return when a slow regulator shows, s; None: it never does. See `Shows`.

    It lags by what it takes longer, times how fast its pressure moves. Nobody can tell it from a
    healthy one as long as that is less, rms over a second, than a healthy one may be off.
    """
    if len(times) < 2:
        return None
    lag = ((sizes.magnitude or 1.0) - 1.0) * _ANSWERS * np.gradient(pressures, times)
    power = np.concatenate([[0.0], np.cumsum(lag[1:] ** 2 * np.diff(times))])
    before = np.searchsorted(times, times - _OVER)
    shown = np.flatnonzero(power - power[before] > AT_REST_OFF**2 * _OVER)
    return float(times[shown[0]]) if shown.size else None
