"""A chain of joints on CiA 402 drives, in cyclic synchronous position or velocity mode.

References
----------
IEC 61800-7-201 (CiA 402-2): state machine, modes csp (8) and csv (9). CiA 301: SYNC, PDOs.
"""

from math import inf

from drivers.canopen.bus import CanopenBus
from drivers.cia402.contact import DIGITAL_INPUTS
from drivers.cia402.drive import Cia402Drive
from drivers.cia402.settings import Cia402Settings
from drivers.cia402.setup import encode_interpolation_period, reset_fault
from drivers.servos.axis_chain import ServoChain
from rig.hal import EmergencyStopInput, Reading


class Cia402Servos(ServoChain[Cia402Drive], EmergencyStopInput):
    """Joints on CiA 402 drives; satisfies `rig.hal.ServoBus`.

    The drives enable operation in the cycles after `arm`, one transition a time. The safe
    state is a quick stop: every drive slows its joint down by the profile's deceleration and
    then holds it (or, with ``after_stop: release``, lets its brake do so). Torque is not taken
    away in mid-motion, where gravity would take over. Connecting resets the drives, and that
    does take it away: support what has no brake before.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.

    Raises
    ------
    ValueError
        The bus has no period, or one that drives cannot be told; a serial number for several.
    """

    Settings = Cia402Settings
    looks_alone = True

    def __init__(
        self, name: str, settings: Cia402Settings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        period = bus.period
        if period is None:
            raise ValueError(f"{name}: the bus {bus.name} has no period, which drives must know.")
        encode_interpolation_period(period)
        super().__init__(
            name,
            settings,
            [
                Cia402Drive(name, joint, drive, settings, bus, period)
                for joint, drive in settings.joints.items()
            ],
            period=period,
            sends_velocity=settings.mode == "csv",
            serial=serial,
        )
        self.settings = settings
        self._bus = bus
        # Whose drive reads the emergency stop is connected first: it is watched from then on.
        self._watched_first = sorted(self.drives, key=lambda drive: drive.contact is None)
        self._watched = self._watched_first[0]
        self._contact = self._watched.contact
        self.no_contact = "stop_contact" if self._contact is None else ""
        self._is_spoken_to = False

    def connect(self) -> None:
        """Find, identify and configure every drive; leave them without torque.

        Raises
        ------
        ConnectionFailed
            A drive does not answer, is another device, is in a fault, or did not take a setting.
        """
        self._armed = self._enabled = False
        if self._contact is not None:
            self._contact.forget()
        for drive in self._watched_first:
            own = drive.settings.serial
            self._is_spoken_to = drive is self._watched
            drive.connect(self._serial if own is None else own)
            self._is_spoken_to = False
            self.look()

    def emergency_stop(self) -> Reading[bool]:
        """Return whether the stop is pressed; without a contact it reads pressed."""
        return Reading(True, -inf) if self._contact is None else self._contact.reading

    def was_pressed(self) -> bool:
        """Return whether the stop was pressed at any look since `connect`."""
        return self._contact is None or self._contact.was_pressed

    def stop_place(self) -> str:
        """Return the drive and its digital input."""
        contact, drive = self.settings.stop_contact, self._watched
        if contact is None:
            return self.name
        return (
            f"{self.name}, the drive of {contact.joint} (node 0x{drive.settings.node:02X}) at bit "
            f"{contact.bit} of its inputs [object {DIGITAL_INPUTS}]"
        )

    def look(self) -> None:
        """Ask for the contact by SDO, unless its drive is being configured by SDO itself."""
        if self._contact is not None and not self._is_spoken_to:
            inputs = DIGITAL_INPUTS
            self._watched.node.asked.ask(inputs.object, inputs.sub, self._contact.take_look)

    def wake(self) -> None:
        """Have the contact's drive answer SDO: a node that was stopped does not."""
        if self._contact is not None:
            self._bus.wake(self._watched.node.node)

    def arm(self) -> None:
        """Start the nodes and take first readings; the cycles from now on enable the drives.

        Raises
        ------
        ConnectionFailed
            A drive does not become OPERATIONAL, sends no readings, is in a fault, or its joint
            stands outside its limits.
        """
        self.listen()
        for drive in self.drives:
            drive.check_start()
        self.set_torque_enabled(True)

    def listen(self) -> None:
        """Start the nodes and take readings in every cycle from now on, without torque.

        Raises
        ------
        ConnectionFailed
            A drive does not become OPERATIONAL, or sends no readings.
        """
        for drive in self.drives:
            drive.start()
        for drive in self.drives:
            drive.inputs.arm()
        bus = self._bus
        bus.synchronise()
        bus.wait_until(
            lambda: all(drive.inputs.is_current() for drive in self.drives),
            bus.settings.sdo_timeout,
        )
        for drive in self.drives:
            if not drive.inputs.is_current():
                drive.inputs.take_first()
        self._armed = True

    def close(self) -> None:
        """Expect nothing of the drives any more; the bus stops the nodes. Idempotent."""
        self.make_safe()
        for drive in self.drives:
            drive.node.disarm()

    def reset_fault(self) -> None:
        """End the faults of all drives whose causes have gone: an operator's act, never ours.

        To be called on a device that is connected or refused to connect, not in the cycle.

        Raises
        ------
        ConnectionFailed
            A drive stays in its fault.
        """
        for drive in self.drives:
            reset_fault(drive.node)
