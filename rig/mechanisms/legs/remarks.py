"""What is said of a walk before it is done: what its law does not keep."""

import numpy as np

from controllers.gait.geometry import AXIS_NAMES
from controllers.gait.plan import GaitPlan
from controllers.rounding import floor
from rig.hal.motion import Note

_KEPT = 1.001
"""Share of the greatest joint rate that counts as kept."""


def remarks_of_plan(fine: GaitPlan) -> tuple[Note, ...]:
    """Return the joint that would have to be faster than it can be, if the law asks it.

    Parameters
    ----------
    fine : GaitPlan
        Sampled so that no peak is missed.

    Notes
    -----
    Laws that bound rates refuse such a walk; the others are rivals that are shown as they are.
    """
    joint = int(np.argmax(fine.peak_rates))
    peak, limit = fine.peak_rates[joint], fine.geometry.max_rate
    if peak <= _KEPT * limit:
        return ()
    at = fine.t[int(np.argmax(np.abs(fine.q_dot[:, joint])))]
    return (
        Note(
            "too fast",
            f"after {at:.3f} s {AXIS_NAMES[joint]} would need {peak:.4g} rad/s, beyond its limit "
            f"of {limit:g} rad/s: {fine.law} does not bound the joints' rates; at "
            f"{floor(limit / peak):g} times the speed it would keep them; sc and sc-smooth do",
        ),
    )
