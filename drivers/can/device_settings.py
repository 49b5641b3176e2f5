"""What the settings of a device say of the frames that it puts on a CAN bus."""

from rig.hal import DriverSettings


class CanDeviceSettings(DriverSettings):
    """Base of the settings of a driver on a CAN bus."""

    __slots__ = ()

    def cyclic_frames(self) -> tuple[tuple[str, int], ...]:
        """Return the frames of every cycle, there and back: names and bytes."""
        return ()

    def timed_frames(self, heartbeat: float) -> tuple[tuple[str, int, float], ...]:
        """Return what comes besides: names, bytes and rates, Hz.

        Parameters
        ----------
        heartbeat : float
            The bus's period of heartbeats, s.
        """
        return ()
