"""Whether the rods go where the controller has them go, or stay where nothing pushes them."""

from collections.abc import Callable

from controllers.spherical_joint.geometry import Quadruple
from controllers.spherical_joint.types import JointEstimate
from rig.mechanisms.joint.alarms.unpushed import UnpushedWatch
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.alarms.tracking import TrackingWatch


class RodsFollow:
    """Watches the rods of a joint by what its controller does with them.

    Parameters
    ----------
    settings : JointSettings
        Limits and alarms.
    """

    def __init__(self, settings: JointSettings) -> None:
        limits = settings.limits
        rods = [f"the rod of {name}" for name in CHANNELS]
        self._sway = settings.sway
        self._tracking = TrackingWatch(
            rods,
            limits.following,
            settings.alarms.oscillation,
            settings.start,
            limits.most_run_off,
        )
        self._unpushed = UnpushedWatch(min(limits.following, self._sway))
        self.suspicion = self._tracking.suspicion
        self.remarks = self._tracking.remarks

    def restart(self) -> None:
        """Forget the past: nothing was controlled."""
        self._tracking.restart()
        self._unpushed.restart()

    def check(
        self,
        estimate: JointEstimate | None,
        rods: Quadruple,
        now: float,
        held: Callable[[], str | None],
        driven: Callable[[int, float], bool],
    ) -> None:
        """Take a cycle's rods, m, and raise if one is not where it should be.

        Parameters
        ----------
        estimate : JointEstimate or None
            Of the controller; None: there is none.
        rods, now, held, driven
            See `TrackingWatch.check`.
        """
        push = None if estimate is None else estimate.push
        if estimate is None or push is not None:  # nothing is controlled
            self._tracking.restart()
        else:
            self._tracking.check(estimate.rods, rods, now, held, driven)
        if push is None:
            self._unpushed.restart()
        else:
            self._unpushed.check(push, rods, now)

    def check_still(self, stood: Quadruple, rods: Quadruple, now: float) -> None:
        """Raise if a rod moves from where it stood, m, while the chambers fill."""
        self._tracking.check_still(stood, rods, now, self._sway)
