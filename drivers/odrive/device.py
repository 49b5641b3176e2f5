"""A chain of joints on ODrives, by CANSimple.

References
----------
ODrive Robotics, "CAN Protocol" of firmware 0.6: cyclic messages, Set_Input_Pos and _Vel, axis
states; watchdog: ``axis0.config.enable_watchdog``, ``watchdog_timeout``.
"""

from drivers.odrive.axis import OdriveAxis
from drivers.odrive.bus import OdriveBus
from drivers.odrive.codec import Command
from drivers.odrive.settings import OdriveSettings
from drivers.servos.axis_chain import ServoChain


class OdriveServos(ServoChain[OdriveAxis]):
    """Joints on ODrives; satisfies `rig.hal.ServoBus`.

    Setpoints feed the axes' watchdogs and hold their joints before the loops are closed. An
    ODrive knows no quick stop: in the safe state each call moves the setpoints one period
    further along a ramp to standstill, and `close` finishes that ramp before it takes the
    torque away. If the program dies instead, the watchdogs take it away at once. Both leave a
    joint that gravity pulls to its brake.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.

    Raises
    ------
    ValueError
        The bus has no period, or one that the watchdogs or estimates do not fit; a serial
        number for several.
    """

    Settings = OdriveSettings

    def __init__(
        self, name: str, settings: OdriveSettings, bus: OdriveBus, *, serial: int | None = None
    ) -> None:
        period = bus.period
        if period is None:
            raise ValueError(f"{name}: the bus {bus.name} has no period, which axes must fit.")
        if settings.watchdog < 2.0 * period:
            raise ValueError(
                f"{name}: watchdog ({settings.watchdog:g} s) is less than two periods of the "
                f"cycle ({period:g} s); one late cycle would drop the joints."
            )
        if settings.encoder_period > period * (1.0 + 1e-9):
            raise ValueError(
                f"{name}: encoder_period ({settings.encoder_period:g} s) is longer than the "
                f"cycle's ({period:g} s); not every cycle would have a reading."
            )
        super().__init__(
            name,
            settings,
            [
                OdriveAxis(name, joint, axis, settings, bus, period)
                for joint, axis in settings.joints.items()
            ],
            period=period,
            sends_velocity=settings.mode == "velocity",
            serial=serial,
        )
        self.settings = settings
        self._bus = bus

    def connect(self) -> None:
        """Find, identify and configure every axis; leave them idle.

        Raises
        ------
        ConnectionFailed
            An axis is missing, twice there, has the wrong firmware or serial number, reports
            an error, or does not send what the profile says.
        """
        self._armed = self._enabled = False
        for drive in self.drives:
            drive.client.wait_for_heartbeat()
        for drive in self.drives:
            drive.client.serials.clear()
        self.drives[0].client.ask_all(Command.ADDRESS)
        self._bus.wait_until(lambda: False, self._bus.settings.reply_timeout)
        for drive in self.drives:
            drive.connect()
            drive.client.compare_serial(self._serial)

    def arm(self) -> None:
        """Take first readings; the cycles from now on hold the joints and close the loops.

        Raises
        ------
        ConnectionFailed
            An axis sends no estimates, or its joint stands outside its limits.
        """
        for drive in self.drives:
            drive.check_start()
        self._armed = True
        self.set_torque_enabled(True)

    def listen(self) -> None:
        """Take readings from now on, without torque: the axes send them by their own clocks."""
        self._armed = True

    def close(self) -> None:
        """Slow down what still moves, then take the torque away. Idempotent."""
        self.make_safe()
        bus, clock = self._bus, self._bus.clock
        settings = self.settings.joints.values()
        longest = max(joint.max_speed / joint.deceleration for joint in settings)
        deadline = clock.now() + 2.0 * longest
        active = [drive for drive in self.drives if drive.setpoint.active]
        while active and clock.now() < deadline:
            now = clock.now()
            bus.transmit(now)
            clock.sleep_until(now + self._period)
            bus.receive(clock.now())
            if all(drive.is_still for drive in active):
                break
            for drive in active:
                drive.stop()
        for drive in self.drives:
            drive.release()

    def reset_fault(self) -> None:
        """Clear the errors of all axes: an operator's act, never ours.

        Raises
        ------
        ConnectionFailed
            The errors of an axis stay.
        """
        for drive in self.drives:
            drive.client.clear_errors()
