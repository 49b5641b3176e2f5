"""What servos say of themselves: errors, watchdog, voltage, temperature."""

from math import ceil
from typing import Final, NamedTuple

from drivers.dynamixel import registers as table
from drivers.dynamixel.settings import DynamixelSettings
from rig.hal import DeviceFault

_CONFIRMED: Final = 2  # samples in a row; one may have been taken while a setting was on its way


class Health(NamedTuple):
    """The state that one servo reports.

    Attributes
    ----------
    error : int
        Bits of Hardware Error Status.
    watchdog : int
        Bus Watchdog: 0 off, -1 tripped, else its time in steps of 20 ms.
    voltage : float
        At its input, V.
    temperature : float
        Inside, K.
    """

    error: int
    watchdog: int
    voltage: float
    temperature: float


def decode_health(error: int, watchdog: int, voltage: int, temperature: int) -> Health:
    """Return what a servo says of itself, from counts."""
    return Health(error, watchdog, voltage * table.VOLTAGE_STEP, temperature + table.CELSIUS)


class HealthWatch:
    """Finds the first fault in what the servos of a device say.

    Parameters
    ----------
    device : str
        Its name, for messages.
    settings : DynamixelSettings
        Bounds.
    watchdog : int
        What Bus Watchdog holds while it is armed.
    """

    def __init__(
        self,
        device: str,
        settings: DynamixelSettings,
        watchdog: int,
    ) -> None:
        self._device = device
        self._joints = tuple(settings.joints)
        self._ids = tuple(joint.id for joint in settings.joints.values())
        self._watchdog = watchdog
        self._hottest = settings.max_temperature
        self._voltage = settings.voltage
        # Compared as they come, in counts: this is done for every servo in every cycle.
        self._max_temperature = int(settings.max_temperature - table.CELSIUS + 1e-9)
        low, high = settings.voltage
        self._min_voltage = ceil(low / table.VOLTAGE_STEP - 1e-9)
        self._max_voltage = int(high / table.VOLTAGE_STEP + 1e-9)
        self.restart()

    def restart(self) -> None:
        """Forget everything; expect no watchdog yet."""
        self._trouble: DeviceFault | None = None
        self._expected = 0
        self._unguarded = [0] * len(self._ids)
        self._unfit = [0] * len(self._ids)

    def expect_watchdog(self) -> None:
        """Expect an armed watchdog from the next sample on."""
        self._expected = self._watchdog

    def accept(self, k: int, error: int, watchdog: int, voltage: int, temperature: int) -> bool:
        """Take what servo `k` says, in counts; return whether its motion can be trusted."""
        if error:
            self.latch(
                k,
                f"reports a hardware error: {table.describe_hardware_error(error)}",
                table.HARDWARE_ERROR,
                f"0x{error:02X}",
            )
        if watchdog != self._expected:
            return self._miss_watchdog(k, watchdog)
        self._unguarded[k] = 0
        is_hot = temperature > self._max_temperature
        if not is_hot and self._min_voltage <= voltage <= self._max_voltage:
            self._unfit[k] = 0
            return True
        self._unfit[k] += 1
        if self._unfit[k] >= _CONFIRMED:
            self._latch_unfit(k, voltage, temperature, is_hot=is_hot)
        return True

    def accept_alert(self, k: int) -> None:
        """Take that servo `k` has a hardware error of which no more is known."""
        self.latch(k, "reports a hardware error, which its register tells", table.HARDWARE_ERROR)

    def check(self) -> None:
        """Raise the first fault.

        Raises
        ------
        DeviceFault
            Hardware error, watchdog tripped or off, too hot, voltage out of range.
        """
        if self._trouble is not None:
            raise self._trouble

    def describe(
        self,
        k: int,
        what: str,
        register: table.Register,
        value: str | None = None,
        bound: str | None = None,
    ) -> DeviceFault:
        """Return a fault of servo `k`."""
        return DeviceFault(
            self._device,
            f"{self._joints[k]} (id {self._ids[k]}) {what}",
            node=self._ids[k],
            object=str(register),
            value=value,
            bound=bound,
        )

    def latch(
        self,
        k: int,
        what: str,
        register: table.Register,
        value: str | None = None,
        bound: str | None = None,
    ) -> None:
        """Keep a fault of servo `k` for `check`; the first one is the cause and stays."""
        if self._trouble is None:
            self._trouble = self.describe(k, what, register, value, bound)

    def _miss_watchdog(self, k: int, found: int) -> bool:
        if found == table.WATCHDOG_TRIPPED:
            self.latch(
                k,
                "has stopped by itself: its bus watchdog tripped, because nothing reached it "
                "for too long; it takes no setpoints until it is connected and armed again",
                table.BUS_WATCHDOG,
                "-1",
                f"{self._watchdog} (of 20 ms)",
            )
            return False
        self._unguarded[k] += 1
        if self._unguarded[k] >= _CONFIRMED:
            self.latch(
                k,
                "has lost its settings: its bus watchdog is not what was written. It rebooted, "
                "perhaps for want of power",
                table.BUS_WATCHDOG,
                str(found),
                str(self._expected),
            )
        return False

    def _latch_unfit(self, k: int, voltage: int, temperature: int, *, is_hot: bool) -> None:
        if is_hot:
            self.latch(
                k,
                "is too hot",
                table.TEMPERATURE,
                f"{temperature} °C",
                f"{self._hottest - table.CELSIUS:g} °C",
            )
        else:
            self.latch(
                k,
                "has not the voltage that it needs",
                table.INPUT_VOLTAGE,
                f"{voltage * table.VOLTAGE_STEP:.1f} V",
                f"{self._voltage[0]:g} … {self._voltage[1]:g} V",
            )
