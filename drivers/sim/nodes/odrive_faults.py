"""What an emulated ODrive axis may do wrong, by name."""

from abc import ABC, abstractmethod
from functools import partial

from drivers.sim.nodes.faults import FaultInjection, whole_number
from drivers.sim.servo_encoder import ServoEncoder

_CLOSED_LOOP = 8
_OVER_VOLTAGE = 0x100


class OdriveFaults(FaultInjection, ABC):
    """Faults of an axis.

    ``silent`` (value: s, default for ever)
        Off the bus: sends and hears nothing, and so its watchdog takes the torque away.
    ``heartbeat_silent``, ``estimates_silent``, ``sdo_silent`` (value: s, default for ever)
        Works, but does not send these.
    ``reboot``
        Power cycle: idle, and all that was set by CAN and not saved is lost.
    ``axis_error``, or as on other drives ``drive_fault`` (value: flags, default DC over-voltage)
        Disarms with this error.
    ``disarm``
        Goes idle although nobody asked for it.
    ``stuck``
        The motor does not follow any more.
    ``encoder_jump``, ``encoder_frozen``, ``encoder_mirrored``, ``encoder_drift``, ``encoder_scale``
        The encoder of its position loop lies, see `ServoEncoder`.
    ``repair``
        Ends what lasts; errors must be cleared all the same.
    """

    # Provided by the axis.
    axis_state: int
    _port: ServoEncoder
    _channel: int
    _turns: float

    def __init__(self) -> None:
        super().__init__()
        self._stuck = False
        self._add_faults()

    @abstractmethod
    def disarm(self, error: int) -> None:
        """Go idle because of an error."""

    @abstractmethod
    def reboot(self) -> None:
        """Begin as after power-on."""

    @abstractmethod
    def _go_idle(self) -> None: ...

    @abstractmethod
    def _shaft(self) -> float: ...

    @abstractmethod
    def _angle(self, turns: float) -> float: ...

    def _add_faults(self) -> None:
        for fault in ("silent", "heartbeat_silent", "estimates_silent", "sdo_silent"):
            self.add_lasting_fault(fault)
        self.add_fault("reboot", lambda _: self.reboot())
        for fault in ("axis_error", "drive_fault"):
            self.add_fault(fault, self._inject_error)
        self.add_fault("disarm", lambda _: self._go_idle())
        self.add_fault("stuck", lambda _: self._set_stuck(True))
        for lie in ServoEncoder.lies:
            self.add_fault(lie, partial(self._inject_lie, lie))

    def repair(self) -> None:
        """End all faults that last."""
        super().repair()
        self._stuck = False
        self._port.repair()

    def _inject_error(self, value: float | None) -> None:
        self.disarm(whole_number(self.name, "axis_error", value, _OVER_VOLTAGE, 0xFFFF_FFFF))

    def _inject_lie(self, how: str, value: float | None) -> None:
        self._port.lie(self._channel, how, value)

    def _set_stuck(self, stuck: bool) -> None:
        if stuck and self.axis_state == _CLOSED_LOOP:
            angle = self._angle(self._shaft())
            self._port.command_joint(self._channel, angle, 0.0, True)
        self._stuck = stuck
