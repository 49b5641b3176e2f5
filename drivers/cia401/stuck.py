"""Tell a regulator that is stuck from one that is on its way."""

from drivers.cia401.settings import FollowingSettings
from rig.hal import DeviceFault


class StuckWatch:
    """Compare a monitored pressure with what a healthy regulator would have reached.

    A healthy one is a first-order lag behind its setpoint. It may be off by `deviation` for
    `time`; dead band, a small supply and a moving piston stay within that, a stuck valve
    does not.

    Parameters
    ----------
    device, channel : str
        For messages.
    node : int
        Likewise.
    settings : FollowingSettings
        See there.
    """

    __slots__ = (
        "_channel",
        "_deviation",
        "_device",
        "_good_at",
        "_node",
        "_off",
        "_response",
        "_then",
        "_time",
        "expected",
    )

    def __init__(self, device: str, node: int, channel: str, settings: FollowingSettings) -> None:
        self._device = device
        self._node = node
        self._channel = channel
        self._deviation = settings.deviation
        self._time = settings.time
        self._response = settings.response
        self.expected = 0.0
        self._then = 0.0
        self._good_at = 0.0
        self._off = 0.0

    def reset(self, pressure: float, now: float) -> None:
        """Start from a measured pressure (Pa)."""
        self.expected = pressure
        self._then = self._good_at = now
        self._off = 0.0

    def check(self, setpoint: float, pressure: float, now: float) -> None:
        """Raise if the pressure has been off for too long.

        Parameters
        ----------
        setpoint, pressure : float
            Sent and monitored, Pa gauge.
        now : float
            s.

        Raises
        ------
        DeviceFault
            It has.
        """
        step = now - self._then
        self._then = now
        if step > 0.0:
            self.expected += (setpoint - self.expected) * step / (self._response + step)
        off = self._off = pressure - self.expected
        if -self._deviation <= off <= self._deviation:
            self._good_at = now
        elif now - self._good_at > self._time:
            raise DeviceFault(
                self._device,
                f"the pressure of {self._channel} does not follow its setpoint "
                f"({setpoint:.0f} Pa); regulator stuck, or supply missing",
                node=self._node,
                value=f"{off:+.0f} Pa for {now - self._good_at:.2f} s",
                bound=f"{self._deviation:.0f} Pa for {self._time:g} s",
            )

    def doubt(self) -> tuple[float, str] | None:
        """Return by how much the pressure is off (Pa) and a sentence; None if it is healthy.

        Half of what would in time be a fault is enough for a doubt.
        """
        if abs(self._off) <= 0.5 * self._deviation:
            return None
        return abs(self._off), (
            f"the pressure of {self._channel} is {self._off * 1e-3:+.0f} kPa off what its "
            "setpoint asks for: its regulator may be stuck"
        )
