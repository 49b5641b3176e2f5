"""Codec of one drive: its position and velocity units to the joint's angle and velocity."""

from drivers.cia402.settings import DriveSettings


class DriveCodec:
    """Units of a drive to SI and back, one straight line each.

    Parameters
    ----------
    drive : DriveSettings
        Counts per turn, gear, direction, offset.

    Attributes
    ----------
    step : float
        The angle of one count, rad, with its sign.
    """

    __slots__ = ("_gain", "_offset", "_velocity_gain", "step")

    def __init__(self, drive: DriveSettings) -> None:
        self._gain = drive.counts_per_radian
        self._offset = drive.offset
        self._velocity_gain = drive.velocity_per_radian
        self.step = 1.0 / drive.counts_per_radian

    def decode_position(self, counts: int) -> float:
        """Return the joint's angle, rad."""
        return counts * self.step + self._offset

    def encode_position(self, position: float) -> int:
        """Return the counts of a joint's angle (rad)."""
        return round((position - self._offset) * self._gain)

    def decode_velocity(self, units: int) -> float:
        """Return the joint's velocity, rad/s."""
        return units / self._velocity_gain

    def encode_velocity(self, velocity: float) -> int:
        """Return the drive's units of a joint's velocity (rad/s)."""
        return round(velocity * self._velocity_gain)
