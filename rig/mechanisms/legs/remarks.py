"""What is said of a walk before it is done: rates its law does not keep, feet without room."""

import numpy as np

from controllers.gait.correction_settings import SagSettings
from controllers.gait.geometry import AXIS_NAMES
from controllers.gait.landings import landings
from controllers.gait.plan import GaitPlan
from controllers.rounding import floor
from rig.hal.motion import Note

_JUMP = 0.5
"""Share of the greatest joint rate by which one may change within a period."""
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


def remarks_on_jumps(plan: GaitPlan) -> tuple[Note, ...]:
    """Return the joint whose rate would jump, if a law asks for what no servo can do.

    Parameters
    ----------
    plan : GaitPlan
        At the loop's period.

    Notes
    -----
    Such walks are within all rates and in balance on paper; in simulation the robot falls.
    """
    changes = np.abs(np.diff(plan.q_dot, axis=0))
    sample, joint = np.unravel_index(int(np.argmax(changes)), changes.shape)
    jump, limit = float(changes[sample, joint]), plan.geometry.max_rate
    if jump <= _JUMP * limit:
        return ()
    return (
        Note(
            "jumps",
            f"after {plan.t[sample]:.3f} s {AXIS_NAMES[joint]} would change its rate by "
            f"{jump:.3g} rad/s within a period of {plan.period * 1e3:g} ms, and its greatest rate "
            f"is {limit:g} rad/s: {plan.law} does not bound accelerations, and the robot may fall; "
            f"sc-smooth does",
        ),
    )


def remarks_on_edges(plan: GaitPlan, sag: SagSettings | None) -> tuple[Note, ...]:
    """Return the first foot that may come down on the edge of higher ground, and tip the robot.

    Parameters
    ----------
    plan : GaitPlan
        Of the walk.
    sag : SagSettings, optional
        How the servos' yielding is compensated; None: it is not, and feet come down off their
        prints.
    """
    if sag is not None or np.ptp(plan.feet[:, :, 2]) == 0.0:
        return ()
    stiffness = SagSettings().stiffness
    off = 0.0
    for landing in landings(plan, stiffness):
        off = max(off, landing.off)
        if off > 0.5 * landing.room:  # where the edge is between the two, the plan does not say
            return (
                Note(
                    "has little room",
                    f"{landing.phase} comes down {landing.room * 1e3:.1f} mm beside a print that "
                    f"is {landing.higher * 1e3:.3g} mm higher, and by then feet are "
                    f"{off * 1e3:.1f} mm off their prints, as servos of {stiffness:g} N m/rad "
                    f"yield to the robot's weight: a foot on the edge between tips the robot over. "
                    f"With legs.sag={{}} what they yield is commanded beforehand; longer treads "
                    f"leave more room",
                ),
            )
    return ()
