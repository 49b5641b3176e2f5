"""Servo joints of `--on sim` with the contact of an emergency stop."""

from drivers.sim.direct.servos import SimulatedServos
from rig.hal import EmergencyStopInput, Reading


class StoppableServos(SimulatedServos, EmergencyStopInput):
    """Joints of which one drive reads an emergency stop.

    Faults are those of `SimulatedServos`, and ``emergency_stop`` (value: 1 pressed, 0 released;
    1 if there is none).
    """

    _pressed = _was_pressed = False

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return (*super().known_faults, "emergency_stop")

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; errors as `AxisFaults.inject`."""
        if fault == "emergency_stop":
            if value not in (None, 0.0, 1.0):
                raise ValueError(f"{self.name}: emergency_stop takes 0 or 1, not {value}")
            self._pressed = value != 0.0
            self._was_pressed |= self._pressed
            return
        if fault == "repair":
            self._pressed = False
        super().inject(fault, value)

    def connect(self) -> None:
        """Take the first readings, without torque; what was pressed before is forgotten."""
        self._was_pressed = self._pressed
        super().connect()

    def emergency_stop(self) -> Reading[bool]:
        """Return whether the stop is pressed."""
        return Reading(self._pressed, self._clock.now())

    def was_pressed(self) -> bool:
        """Return whether the stop was pressed since `connect`."""
        return self._was_pressed
