"""What a log says in its last second of a mechanism that pneumatic cylinders move."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.mechanisms.pneumatic.alarms.bounds import LOOP, STATIC
from rig.mechanisms.pneumatic.settings import PneumaticSettings, RegulatorModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SPAN: Final = 1.0
"""That is judged, s …"""
_LEAD: Final = 0.3
"""… and what is looked at before, s: a model that starts anywhere has come to the pressure then."""
_LEAST: Final = 0.1
"""A shorter log tells no cause, s."""
_STEP: Final = 2e-3
"""Cycles within this time are taken together, s."""


class Signals(NamedTuple):
    """Signals of a log, cycle by cycle.

    Parameters
    ----------
    t : ndarray, shape (n,)
        s.
    setpoints, pressures : ndarray, shape (n, k)
        As sent and as measured, Pa gauge.
    extensions : ndarray, shape (n, k)
        Of the rods, m.
    loads : ndarray, shape (n, p)
        Friction of each pair beside that of its seals, N.
    falls : ndarray, shape (n, p)
        What pulls each pair on as it leans, N.
    """

    t: "Array"
    setpoints: "Array"
    pressures: "Array"
    extensions: "Array"
    loads: "Array"
    falls: "Array"


class LastSecond(NamedTuple):
    """The signals of the last second, and what the profile says.

    Parameters
    ----------
    signals : Signals
        Thinned.
    first : int
        The sample from which on they are compared.
    names : tuple of str
        Of the channels.
    pairs : tuple of tuple of int
        Agonist and antagonist of each pair.
    settings : PneumaticSettings
        Of the mechanism.
    period : float
        Of the cycles that were logged, s.
    """

    signals: Signals
    first: int
    names: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    settings: PneumaticSettings
    period: float

    @property
    def t(self) -> "Array":
        """s, shape (n,)."""
        return self.signals.t

    @property
    def response(self) -> RegulatorModel:
        """Of the regulators, as the profile says."""
        return self.settings.regulator_response

    @property
    def static(self) -> float:
        """By how much a healthy regulator may be off throughout, Pa."""
        return STATIC * self._range

    @property
    def noise(self) -> float:
        """By how much a healthy regulator scatters, Pa."""
        return LOOP * self._range

    @property
    def lasts(self) -> float:
        """For how long it is judged, s."""
        return float(self.t[-1] - self.t[self.first])

    @property
    def independent(self) -> float:
        """How many samples of a channel tell something of their own: one in a time constant."""
        return max(self.lasts * self.response.bandwidth, 1.0)

    @property
    def _range(self) -> float:
        return self.settings.full_scale


def gather(
    signals: Signals,
    names: Sequence[str],
    pairs: tuple[tuple[int, int], ...],
    settings: PneumaticSettings,
) -> LastSecond | None:
    """Return the evidence of a log that ends with a fault; None if it is too short.

    Parameters
    ----------
    signals : Signals
        Of every cycle.
    names : sequence of str
        Of the channels.
    pairs : tuple of tuple of int
        Agonist and antagonist of each pair.
    settings : PneumaticSettings
        Of the mechanism.
    """
    t = signals.t
    if len(t) < 2 or t[-1] - t[0] < _LEAST:
        return None
    begin = int(np.searchsorted(t, t[-1] - SPAN - _LEAD))
    period = float(np.median(np.diff(t)))
    together = max(1, round(_STEP / period))
    thin = Signals(*(_thinned(signal[begin:], together) for signal in signals))
    first = int(np.searchsorted(thin.t, thin.t[-1] - SPAN))
    return LastSecond(thin, first, tuple(names), pairs, settings, period)


def _thinned(values: "Array", together: int) -> "Array":
    """Return means of so many neighbouring rows; the last one ends with the last row."""
    whole = values[len(values) % together :]
    found: Array = whole.reshape(-1, together, *values.shape[1:]).mean(axis=1)
    return found
