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
    """

    def __init__(self, device: EmergencyStopInput | None, oldest: float) -> None:
        self._device = device
        self._oldest = oldest

    def check(self, now: float) -> None:
        """Raise if the stop is pressed, its circuit open, or its reading too old.

        Raises
        ------
        EmergencyStop, StaleReading
        """
        if self._device is None:
            return
        pressed, t = self._device.emergency_stop()
        if pressed:
            raise EmergencyStop("the emergency stop is pressed or its circuit is open")
        if now - t > self._oldest:
            raise StaleReading("emergency stop", now - t, self._oldest)
