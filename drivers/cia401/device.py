"""Electro-pneumatic regulators behind a CiA 401 analogue module."""

from drivers.canopen.bus import CanopenBus
from drivers.cia401.module import AnalogueModule
from drivers.cia401.settings import Cia401Settings
from drivers.cia401.stuck import StuckWatch
from rig.hal import PressureRegulator, Vector


class Cia401Regulators(AnalogueModule, PressureRegulator):
    """Regulators, emergency-stop contact and supply valve on one CiA 401 node.

    Channels with a lock valve follow `lock`; the others refuse it.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.
    """

    Settings = Cia401Settings

    def __init__(
        self, name: str, settings: Cia401Settings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        self.settings = settings
        self.pressure_range = low, high = settings.pressure_range
        channels = settings.channels.values()
        super().__init__(
            name,
            settings,
            bus,
            serial,
            span=self.pressure_range,
            unit="Pa",
            safe=(min(max(settings.vented, low), high),) * len(channels),
            held=tuple(channel.safe == "hold" for channel in channels),
        )
        self.lockable = tuple(channel.lock_bit is not None for channel in channels)
        lock_bits = (channel.lock_bit for channel in channels)
        self._lock_bits = tuple(0 if bit is None else 1 << bit for bit in lock_bits)
        self._following = tuple(
            StuckWatch(name, settings.node, channel, settings.following)
            for channel in self.channels
        )

    def arm(self) -> None:
        """Start the module and take first readings; see `AnalogueModule.arm`."""
        super().arm()
        now = self._bus.clock.now()
        for watch, pressure in zip(self._following, self._pressure, strict=True):
            watch.reset(pressure, now)

    def doubt(self, now: float) -> str | None:
        """Return which channel is furthest off its setpoint, if one is; see `Device.doubt`."""
        doubts = [found for watch in self._following if (found := watch.doubt()) is not None]
        return f"{self.name}: {max(doubts)[1]}" if doubts else None

    def set_pressure(self, pressure: Vector) -> None:
        """Take setpoints for this cycle, Pa gauge, shape (n,); ignored unless armed.

        Raises
        ------
        LimitExceeded
            A setpoint is outside the range or not a number. The setpoints stay as they were.
        ValueError
            There is not one setpoint per channel.
        """
        self._give(pressure)

    def lock(self, shut: tuple[bool, ...]) -> None:
        """Shut or open the lock valves from the next setpoints on; see `PressureRegulator.lock`.

        Raises
        ------
        ValueError
            A channel is to be shut that has no valve.
        """
        closed = 0
        for name, bit, wanted in zip(self.channels, self._lock_bits, shut, strict=True):
            if wanted and not bit:
                raise ValueError(f"{self.name}: no valve locks {name}; it has no lock_bit")
            closed |= bit if wanted else 0
        self._open_valves(closed)

    def check(self, now: float) -> None:
        """Raise if the module or a regulator is not well.

        Raises
        ------
        DeviceFault
            As `AnalogueModule.check` says, or a regulator does not follow.
        """
        super().check(now)
        if self._armed:
            setpoint, pressure = self._setpoint, self._pressure
            for k, watch in enumerate(self._following):
                watch.check(setpoint[k], pressure[k], now)

    def unsafe(self, now: float) -> str:
        """Return which chambers are not known to be vented; see `Device.unsafe`."""
        self._ask_monitors()
        return self._wires.explain(super().unsafe(now))

    def safe_pressure(self) -> Vector:
        """Return the setpoints of the safe state, Pa gauge, shape (n,); see `PressureRegulator`."""
        return self._safe_setpoint()
