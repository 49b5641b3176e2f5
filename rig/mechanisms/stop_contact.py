"""The emergency-stop contact, as every mechanism watches it."""

from rig.hal import EmergencyStop, EmergencyStopInput, StaleReading


class StopContact:
    """Watches the device that reads the emergency-stop contact.

    Parameters
    ----------
    device : EmergencyStopInput or None
        None: the rig has no contact that the program can read.
    oldest : float
        Age above which its reading is not to be relied on, s.

    Attributes
    ----------
    device : EmergencyStopInput or None
        As given.
    """

    def __init__(self, device: EmergencyStopInput | None, oldest: float) -> None:
        self.device = device
        self._oldest = oldest

    def check(self, now: float) -> None:
        """Raise if the stop is pressed, its circuit open, or its reading too old.

        Raises
        ------
        EmergencyStop, StaleReading
        """
        if self.device is None:
            return
        pressed, t = self.device.emergency_stop()
        if pressed or self.device.was_pressed():
            raise EmergencyStop.open_at(self.device.stop_place())
        if now - t > self._oldest:
            place = f"the emergency stop that {self.device.stop_place()} reads"
            raise StaleReading(place, now - t, self._oldest)

    def ignore(self) -> None:
        """Do not watch it from now on: there is no contact where a log is replayed."""
        self.device = None
