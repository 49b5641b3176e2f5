"""What regulators would have made of the setpoints, healthy ones and others."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class OtherRegulators(NamedTuple):
    """Some regulators of second order with a dead time, which may have changed.

    Parameters
    ----------
    channel : ndarray of int, shape (m,)
        Whose setpoints each gets.
    bandwidth : ndarray, shape (m,)
        Once it has changed, over that of the profile.
    since : ndarray, shape (m,)
        When that was, s.
    late : ndarray, shape (m,)
        Dead time beyond the profile's, s.
    """

    channel: "NDArray[np.intp]"
    bandwidth: "Array"
    since: "Array"
    late: "Array"


def answer(evidence: LastSecond, some: OtherRegulators) -> "Array":
    """Return the pressures that regulators make of the setpoints, Pa gauge, shape (n, m).

    They begin with the measured pressure at rest.
    """
    t, response = evidence.t, evidence.response
    pressure = evidence.signals.pressures[0, some.channel]
    rate = np.zeros_like(pressure)
    found = np.empty((len(t), len(pressure)))
    found[0] = pressure
    inputs = _inputs(evidence, some)
    changed = some.bandwidth * response.bandwidth
    for k, step in enumerate(np.diff(t).tolist()):
        bandwidth = np.where(t[k] >= some.since, changed, response.bandwidth)
        turn = step * bandwidth
        rate = rate + turn * bandwidth * (inputs[k] - pressure)
        rate = rate / (1.0 + 2.0 * response.damping * turn)
        pressure = pressure + step * rate
        found[k + 1] = pressure
    return found


def _inputs(evidence: LastSecond, some: OtherRegulators) -> "Array":
    """Return the setpoints that act in the middle of each step, Pa gauge, shape (n - 1, m)."""
    t, setpoints = evidence.t, evidence.signals.setpoints
    # What a cycle sends acts until the next one does.
    acts = t + 0.5 * evidence.period
    middle = 0.5 * (t[1:] + t[:-1]) - evidence.response.dead_time
    found = np.empty((len(middle), len(some.late)))
    for late in np.unique(some.late):
        for channel in range(setpoints.shape[1]):
            these = (some.late == late) & (some.channel == channel)
            found[:, these] = np.interp(middle - late, acts, setpoints[:, channel])[:, None]
    return found


def healthy(evidence: LastSecond) -> "Array":
    """Return the pressures of regulators that are as the profile says, Pa gauge, shape (n, k)."""
    count = len(evidence.names)
    return answer(
        evidence,
        OtherRegulators(np.arange(count), np.ones(count), np.zeros(count), np.zeros(count)),
    )
