"""What simulated regulators and valves have in common: pressures, an e-stop contact, a supply."""

from abc import abstractmethod
from collections.abc import Sequence
from math import inf
from typing import Protocol

from drivers.sim.direct.device import SimulatedDevice
from rig.hal import Clock, DeviceFault, EmergencyStopInput, Reading, Vector

_new = tuple.__new__  # makes a named tuple in half the time that its class takes


class ChamberPort(Protocol):
    """The plant as the chambers need it, whatever feeds them."""

    def pressure(self, channel: int) -> float:
        """Return what a chamber's monitor shows, Pa gauge."""

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""


class SimulatedChambers(SimulatedDevice, EmergencyStopInput):
    """Chambers with monitors, an e-stop contact and a supply valve.

    Faults: ``silent`` (value: s), ``wire_break`` and ``output_stuck`` (value: channel),
    ``emergency_stop`` (value: 1 pressed, 0 released), ``repair``.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    channels : sequence of str
        In the order of the plant's channels.
    chambers : ChamberPort
        The physics.
    clock : Clock
        The rig's.
    resolution : float
        Of the monitor's converter, Pa.
    """

    def __init__(
        self,
        name: str,
        channels: Sequence[str],
        chambers: ChamberPort,
        clock: Clock,
        resolution: float,
    ) -> None:
        super().__init__(name, clock)
        self.channels = tuple(channels)
        self._chambers = chambers
        self.resolution = resolution
        """Of its monitors, Pa."""
        count = len(self.channels)
        self._numbers = range(count)
        self._armed = False
        self._stopped = self._was_stopped = False
        self._broken: set[int] = set()
        self._stuck: set[int] = set()
        self._pressure: Reading[Vector] = Reading((0.0,) * count, -inf)
        self._stop: Reading[bool] = Reading(True, -inf)
        broken, stuck = self._broken, self._stuck
        self.add_fault("wire_break", lambda k: broken.add(self._channel(k)), broken.clear)
        self.add_fault("output_stuck", lambda k: stuck.add(self._channel(k)), stuck.clear)
        self.add_fault("emergency_stop", self._press_stop, lambda: self._press_stop(0.0))

    def pressure(self) -> Reading[Vector]:
        """Return the monitored pressures of the cycle before, Pa gauge, shape (n,)."""
        return self._pressure

    def emergency_stop(self) -> Reading[bool]:
        """Return whether the stop was pressed in the cycle before."""
        return self._stop

    def look(self) -> None:
        """Look at the contact while no loop does."""
        now = self._clock.now()
        if now >= self._silent_until:
            self._stop = _new(Reading, (self._stopped, now))

    def was_pressed(self) -> bool:
        """Return whether the stop was pressed since `connect`."""
        return self._was_stopped

    def check(self, now: float) -> None:
        """Raise if something is not well, then sample the next readings.

        Raises
        ------
        DeviceFault
            A monitor's wire is broken.
        """
        for channel in self._broken:
            raise DeviceFault(
                self.name, f"the pressure monitor of {self.channels[channel]} has a broken wire"
            )
        self._sample()

    @abstractmethod
    def _put_out(self, channel: int, setpoint: float) -> None:
        """Give the plant a setpoint of one channel."""

    def _write(self, setpoints: Vector) -> None:
        stuck, put_out = self._stuck, self._put_out
        for channel, setpoint in enumerate(setpoints):
            if channel not in stuck:
                put_out(channel, setpoint)

    def _sample(self) -> None:
        now, step, pressure = self._clock.now(), self.resolution, self._chambers.pressure
        if now < self._silent_until:
            return
        values = tuple([round(pressure(k) / step) * step for k in self._numbers])
        self._pressure = _new(Reading, (values, now))
        self._stop = _new(Reading, (self._stopped, now))

    def _channel(self, value: float | None) -> int:
        number = 0.0 if value is None else value
        if number not in range(len(self.channels)):
            raise ValueError(
                f"{self.name}: no channel {number:g}; there are {len(self.channels)}, from 0"
            )
        return int(number)

    def _press_stop(self, value: float | None) -> None:
        if value not in (None, 0.0, 1.0):
            raise ValueError(f"{self.name}: emergency_stop takes 0 or 1, not {value}")
        self._stopped = value != 0.0
        self._was_stopped |= self._stopped
