"""Simulated electro-pneumatic regulators; see `drivers.sim.direct.device`."""

from collections.abc import Sequence
from math import inf

from drivers.sim.direct.chambers import SimulatedChambers
from drivers.sim.regulator_port import RegulatorPort
from rig.hal import Clock, DeviceFault, PressureRegulator, Vector


class SimulatedRegulators(SimulatedChambers, PressureRegulator):
    """Regulators, e-stop contact and supply valve; faults as `SimulatedChambers` has them.

    Parameters
    ----------
    name, channels, clock, resolution
        See `SimulatedChambers`.
    plant : RegulatorPort
        The physics.
    pressure_range : tuple of float
        Of the setpoints, Pa gauge.
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
        super().__init__(name, channels, plant, clock, resolution)
        self.pressure_range = pressure_range
        self._plant = plant
        self._deviation = deviation
        self._deviation_time = deviation_time
        count = len(self.channels)
        self._vented = (max(pressure_range[0], 0.0),) * count
        self._safe = tuple(safe) or ("vent",) * count
        self.lockable = tuple(lockable) or tuple(kind == "lock" for kind in self._safe)
        self._setpoints: Vector = self._vented
        self._followed_at = [0.0] * count
        self._holding = False

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
        if self._armed and self._deviation < inf and not self._broken:
            self._check_deviation(now)
        super().check(now)

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
        super()._write(setpoints)

    def _put_out(self, channel: int, setpoint: float) -> None:
        self._plant.set_pressure_setpoint(channel, setpoint)

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
