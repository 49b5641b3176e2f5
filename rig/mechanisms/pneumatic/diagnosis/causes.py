"""What a cause is that was fitted to the last second, and how well it explains it."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.mechanisms.pneumatic.diagnosis.answers import healthy
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_AGO: Final = np.geomspace(6e-3, 0.9, 24)
"""How long before the end something may have happened, s; it may as well have been before."""
_CLOSER: Final = 7
"""So many instants are tried between two of them, once one of the two is the best."""


class Explanation(NamedTuple):
    """One cause with its best figure.

    Parameters
    ----------
    cause : str
        One of those that `rig.mechanisms.pneumatic.diagnosis.words` has words for.
    channel : int or None
        Whose; None: of all.
    figure : float
        What it comes to, SI.
    gain : float
        Twice the logarithm of its likelihood over that of healthy regulators, less what its
        parameters cost (G. Schwarz, "Estimating the dimension of a model", Annals of Statistics
        6(2), 1978).
    """

    cause: str
    channel: int | None
    figure: float
    gain: float


class Scales(NamedTuple):
    """The measure of fits: what healthy regulators leave of the measured pressures.

    Parameters
    ----------
    evidence : LastSecond
        Of the last second.
    expected : ndarray, shape (n, k)
        Pressures of healthy regulators, Pa gauge.
    left : ndarray, shape (k,)
        What they leave, mean square, Pa².
    """

    evidence: LastSecond
    expected: "Array"
    left: "Array"

    def misfit(self, channel: "NDArray[np.intp] | int", pressures: "Array") -> "Array":
        """Return what pressures leave of the measured ones, mean square, Pa², shape (m,).

        A constant distance that a healthy regulator may have counts as none.

        Parameters
        ----------
        channel : ndarray of int, shape (m,), or int
            Whose pressures each is, or all are.
        pressures : ndarray, shape (n, m)
            Pa gauge.
        """
        evidence = self.evidence
        measured = evidence.signals.pressures[evidence.first :, channel]
        off = (measured.T - pressures[evidence.first :].T).T
        mean = np.clip(off.mean(axis=0), -evidence.static, evidence.static)
        off -= mean
        found: Array = np.einsum("ij,ij->j", off, off) / len(off)
        return found

    def gain(self, channel: int, left: "Array") -> "Array":
        """Return how much likelier than health fits of one channel are, twice its logarithm."""
        noise = self.evidence.noise**2
        ratio = np.log((self.left[channel] + noise) / (left + noise))
        return np.asarray(self.evidence.independent * ratio)

    def price(self, parameters: int) -> float:
        """Return what parameters cost."""
        return parameters * math.log(self.evidence.independent * len(self.left))


def scales_of(evidence: LastSecond) -> Scales:
    """Return what health explains."""
    count = len(evidence.names)
    scales = Scales(evidence, healthy(evidence), np.zeros(count))
    return scales._replace(left=scales.misfit(np.arange(count), scales.expected))


def best_of_scan(axis: "Array", gains: "Array") -> tuple[float, float]:
    """Return where along an axis the gain is greatest, as a parabola has it, and that gain."""
    best = int(np.argmax(gains))
    if not 0 < best < len(axis) - 1:
        return float(axis[best]), float(gains[best])
    before, here, after = (float(gains[best + k]) for k in (-1, 0, 1))
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    beside = axis[best + (1 if shift > 0.0 else -1)]
    return float(axis[best] + abs(shift) * (beside - axis[best])), here


def best_since(evidence: LastSecond, trial_at: Callable[[float, int], Explanation]) -> Explanation:
    """Return the best trial of something that has been so throughout, or began at some time.

    Parameters
    ----------
    evidence : LastSecond
        Of the last second.
    trial_at : callable
        ``trial_at(since, parameters)``: since when, s, and how many parameters it takes to say so.
    """
    first, end = float(evidence.t[0]), float(evidence.t[-1])
    begins = [end - ago for ago in _AGO.tolist() if end - ago > first]
    always, trials = trial_at(first, 0), [trial_at(since, 1) for since in begins]
    if trials:
        k = max(range(len(trials)), key=lambda k: trials[k].gain)
        between = np.linspace(
            begins[min(k + 1, len(begins) - 1)], begins[max(k - 1, 0)], _CLOSER + 2
        )[1:-1]
        trials = [trials[k], *(trial_at(since, 1) for since in between.tolist())]
    return max(always, *trials, key=lambda trial: trial.gain)


def share_gone(evidence: LastSecond, since: float, time: float) -> "Array":
    """Return which share of its way something has gone that began at `since`, shape (n,)."""
    found: Array = -np.expm1(-np.maximum(evidence.t - since, 0.0) / time)
    return found
