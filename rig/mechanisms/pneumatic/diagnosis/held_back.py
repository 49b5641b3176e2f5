"""Setpoints that a limit of the profile held back before the end: nothing need be broken then."""

from typing import TYPE_CHECKING, Final

import numpy as np

from rig.hal.hindsight import Suspect
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond

if TYPE_CHECKING:
    from numpy.typing import NDArray

CAUSE: Final = "held_back"
_NEAR: Final = 0.02
"""Share of the permitted range within which a setpoint stands at its end: what laws foresee of
their regulators takes off as much."""
_LONG: Final = 0.2
"""It has stood there for so long without a break, s: a loop that swings comes back sooner."""
_LATE: Final = 0.1
"""And has not left it for longer than so before the end, s."""


def held_back(evidence: LastSecond) -> list[Suspect]:
    """Return each chamber whose setpoint stood at the upper end of ``limits.pressure``.

    Where two did, one beside the other, the loop asked both to pull: neither is told, as it is not
    for want of a force that nothing moves.
    """
    low, high = evidence.settings.limits.pressure
    t, stood = evidence.t, evidence.signals.setpoints >= high - _NEAR * (high - low)
    found = []
    for pair in evidence.pairs:
        lasting = [(k, _lasts(t, stood[:, k])) for k in pair]
        long = [(k, time) for k, time in lasting if time >= _LONG]
        if len(long) == 1:
            ((k, time),) = long
            sentence = (
                f"setpoint of {evidence.names[k]}: it stood at the end of limits.pressure, "
                f"{high * 1e-3:.4g} kPa, for {time:.2g} s: the law may not pull harder, and "
                "nothing need be broken"
            )
            found.append(Suspect(CAUSE, evidence.names[k], high, "Pa", 0.0, sentence))
    return found


def _lasts(t: "NDArray[np.float64]", stood: "NDArray[np.bool_]") -> float:
    """Return for how long something stood, until shortly before the end, s; 0: it did not."""
    at = np.flatnonzero(stood)
    if not len(at) or t[-1] - t[at[-1]] > _LATE:
        return 0.0
    last = at[-1]
    left = np.flatnonzero(~stood[:last])
    return float(t[last] - t[left[-1] + 1 if len(left) else 0])
