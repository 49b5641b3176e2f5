"""What else keeps hardware from running, told before anybody is asked whether it may move."""

from collections.abc import Callable

from rig.experiment.frozen import refuse_slow_devices
from rig.experiment.loop_margins import refuse_small_margin
from rig.experiment.plan import Plan


def refuse_unfit(plan: Plan, say: Callable[[str], None]) -> None:
    """Refuse devices that act too late by themselves, and a loop that is near to instability.

    Parameters
    ----------
    plan : Plan
        Checked.
    say : callable
        Is told what the profile accepts.

    Raises
    ------
    DeviceError
        One of them.
    """
    refuse_slow_devices(plan, say)
    refuse_small_margin(plan, say)
