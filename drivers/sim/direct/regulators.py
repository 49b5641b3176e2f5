"""Devices of `--on sim`: the capabilities straight on a plant, without a bus.

They behave as the production drivers do on their bus: a reading is quantised and one cycle old
(it was sampled when the cycle before it ended), a setpoint acts in its own cycle. The loop calls
`check` once a cycle after it has taken its readings; that is when the next ones are sampled.
"""

from collections.abc import Sequence
from math import inf

from drivers.sim.breakable import Breakable
from drivers.sim.regulator_port import RegulatorPort
from rig.hal import (
    Clock,
    Device,
    DeviceFault,
    EmergencyStopInput,
    PressureRegulator,
    Reading,
    Vector,
)

_new = tuple.__new__  # makes a named tuple in half the time that its class takes


class SimulatedDevice(Breakable, Device):
    """Base of the devices: faults by name, and silence."""

    def __init__(self, name: str, clock: Clock) -> None:
        super().__init__()
        self.name = name
        self._clock = clock
        self._silent_until = 0.0
        self.add_fault("silent", self._fall_silent, self._end_silence)

    def close(self) -> None:
        """Release nothing: there is no bus."""

    def _is_silent(self) -> bool:
        return self._clock.now() < self._silent_until

    def _until(self, fault: str, duration: float | None) -> float:
        return self._clock.now() + self.lasting_time(fault, duration)

    def _fall_silent(self, duration: float | None) -> None:
        self._silent_until = self._until("silent", duration)

    def _end_silence(self) -> None:
        self._silent_until = 0.0


class SimulatedRegulators(SimulatedDevice, PressureRegulator, EmergencyStopInput):
    """Regulators, e-stop contact and supply valve of a plant.

    Faults: ``silent`` (value: s), ``wire_break`` and ``output_stuck`` (value: channel),
    ``emergency_stop`` (value: 1 pressed, 0 released), ``repair``.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    channels : sequence of str
        In the order of the plant's channels.
    plant : RegulatorPort
        The physics.
    clock : Clock
        The rig's.
    pressure_range : tuple of float
        Of the setpoints, Pa gauge.
    resolution : float
        Of the monitor's converter, Pa.
    deviation, deviation_time : float
        How far (Pa) and for how long (s) a monitored pressure may be off its setpoint.
    safe : sequence of str
        Of each channel: ``vent``, ``hold`` or ``lock``; empty: all vent.
    lockable : sequence of bool
        Which channels have a valve between regulator and chamber; empty: those that lock.
    """

    def __init__(
        self,
        name: str,
        channels: Sequence[str],
        plant: RegulatorPort,
        clock: Clock,
        *,
        pressure_range: tuple[float, float] = (0.0, 0.5e6),
        resolution: float = 0.5e6 / 0x7FFF,
        deviation: float = inf,
        deviation_time: float = 0.5,
        safe: Sequence[str] = (),
        lockable: Sequence[bool] = (),
    ) -> None:
        super().__init__(name, clock)
        self.channels = tuple(channels)
        self.pressure_range = pressure_range
        self._plant = plant
        self.resolution = resolution
        """Of its monitors, Pa."""
        self._deviation = deviation
        self._deviation_time = deviation_time
        count = len(self.channels)
        self._numbers = range(count)
        self._vented = (max(pressure_range[0], 0.0),) * count
        self._safe = tuple(safe) or ("vent",) * count
        self.lockable = tuple(lockable) or tuple(kind == "lock" for kind in self._safe)
        self._setpoints: Vector = self._vented
        self._followed_at = [0.0] * count
        self._armed = self._holding = False
        self._stopped = self._was_stopped = False
        self._broken: set[int] = set()
        self._stuck: set[int] = set()
        self._pressure: Reading[Vector] = Reading((0.0,) * count, -inf)
        self._stop: Reading[bool] = Reading(True, -inf)
        broken, stuck = self._broken, self._stuck
        self.add_fault("wire_break", lambda k: broken.add(self._channel(k)), broken.clear)
        self.add_fault("output_stuck", lambda k: stuck.add(self._channel(k)), stuck.clear)
        self.add_fault("emergency_stop", self._press_stop, lambda: self._press_stop(0.0))

    def connect(self) -> None:
        """Vent, with the supply closed, and take the first readings."""
        self._armed = self._holding = False
        self._was_stopped = self._stopped
        self._plant.set_supply(False)
        self._lock(True)
        self._write(self._vented)
        self._sample()

    def arm(self) -> None:
        """Open the supply and follow setpoints from now on."""
        self._armed = True
        self._lock(False)
        self._followed_at = [self._clock.now()] * len(self.channels)
        self._plant.set_supply(True)
        self._sample()

    def pressure(self) -> Reading[Vector]:
        """Return the monitored pressures of the cycle before, Pa gauge, shape (n,)."""
        return self._pressure

    def emergency_stop(self) -> Reading[bool]:
        """Return whether the stop was pressed in the cycle before."""
        return self._stop

    def was_pressed(self) -> bool:
        """Return whether the stop was pressed since `connect`."""
        return self._was_stopped

    def set_pressure(self, pressure: Vector) -> None:
        """Take setpoints for this cycle, Pa gauge, shape (n,); ignored unless armed."""
        if self._armed and not self._is_silent():
            self._write(pressure)

    def check(self, now: float) -> None:
        """Raise if a regulator is not well, then sample the next readings.

        Raises
        ------
        DeviceFault
            A monitor's wire is broken, or a pressure is off its setpoint for too long.
        """
        for channel in self._broken:
            raise DeviceFault(
                self.name, f"the pressure monitor of {self.channels[channel]} has a broken wire"
            )
        if self._armed and self._deviation < inf:
            self._check_deviation(now)
        self._sample()

    def make_safe(self) -> None:
        """Vent, hold or lock each chamber; the supply stays open only for what is held."""
        self._holding = "hold" in self._safe and (self._armed or self._holding)
        self._armed = False
        if not self._holding:
            self._plant.set_supply(False)
        self._lock(True)
        self._write(self.safe_pressure())

    def unsafe(self, now: float) -> str:
        """Return which chambers still hold more than they should, as they are measured now."""
        self._sample()
        return super().unsafe(now)

    def safe_pressure(self) -> Vector:
        """Return the setpoints of the safe state, Pa gauge, shape (n,)."""
        return tuple(
            setpoint if safe == "hold" else vented
            for safe, setpoint, vented in zip(
                self._safe, self._setpoints, self._vented, strict=True
            )
        )

    def lock(self, shut: tuple[bool, ...]) -> None:
        """Shut or open the lock valves; see `rig.hal.PressureRegulator`.

        Raises
        ------
        ValueError
            A channel is to be shut that has no valve.
        """
        for channel, (wanted, lockable) in enumerate(zip(shut, self.lockable, strict=True)):
            if wanted and not lockable:
                raise ValueError(f"{self.name}: no valve locks {self.channels[channel]}")
            if lockable and self._armed:
                self._plant.set_lock(channel, wanted)

    def _lock(self, locked: bool) -> None:
        for channel, (safe, lockable) in enumerate(zip(self._safe, self.lockable, strict=True)):
            if lockable:
                self._plant.set_lock(channel, locked and safe == "lock")

    def _write(self, setpoints: Vector) -> None:
        self._setpoints = setpoints
        stuck, give = self._stuck, self._plant.set_pressure_setpoint
        for channel, pressure in enumerate(setpoints):
            if channel not in stuck:
                give(channel, pressure)

    def _sample(self) -> None:
        now, step, pressure = self._clock.now(), self.resolution, self._plant.pressure
        if now < self._silent_until:
            return
        values = tuple([round(pressure(k) / step) * step for k in self._numbers])
        self._pressure = _new(Reading, (values, now))
        self._stop = _new(Reading, (self._stopped, now))

    def _check_deviation(self, now: float) -> None:
        setpoints, followed_at, deviation = self._setpoints, self._followed_at, self._deviation
        for channel, pressure in enumerate(self._pressure[0]):
            off = pressure - setpoints[channel]
            if -deviation <= off <= deviation:
                followed_at[channel] = now
            elif now - followed_at[channel] > self._deviation_time:
                raise DeviceFault(
                    self.name,
                    f"the pressure of {self.channels[channel]} does not follow its setpoint",
                    value=f"{abs(off):.6g} Pa for {now - followed_at[channel]:.3g} s",
                    bound=f"{self._deviation:.6g} Pa for {self._deviation_time:.3g} s",
                )

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
