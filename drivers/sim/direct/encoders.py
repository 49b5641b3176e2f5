"""Rod encoders of `--on sim`: straight on a plant, without a bus."""

from functools import partial
from math import inf
from typing import Protocol

from drivers.sim.direct.device import SimulatedDevice
from drivers.sim.rod_faults import ROD_FAULTS, RodFaults
from rig.hal import Clock, DeviceFault, LinearEncoder, Reading, Vector

_new = tuple.__new__  # makes a named tuple in half the time that its class takes


class RodPort(Protocol):
    """Rods of a plant, as encoders need them."""

    def position(self, channel: int) -> float:
        """Return the true extension of a rod, m."""

    def speed(self, channel: int) -> float:
        """Return the true speed of a rod's extension, m/s."""


class SimulatedEncoder(SimulatedDevice, LinearEncoder):
    """A linear encoder on one rod of a plant.

    Faults: ``silent`` and ``frozen`` (value: s), ``jump`` (value: m, default 5 mm), ``alarm``,
    ``other_rod`` (value: the plant's channel whose rod it is mounted on), those of `RodFaults`,
    ``repair``.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    channel : int
        The plant's channel that it measures.
    plant : RodPort
        The physics.
    clock : Clock
        The rig's.
    stroke : float
        Measuring range, m.
    resolution, speed_resolution : float
        Of position and speed, m and m/s.
    max_speed : float
        A faster change from one reading to the next is a fault, m/s.
    """

    def __init__(
        self,
        name: str,
        channel: int,
        plant: RodPort,
        clock: Clock,
        *,
        stroke: float = 60e-3,
        resolution: float = 1e-6,
        speed_resolution: float = 1e-5,
        max_speed: float = inf,
    ) -> None:
        super().__init__(name, clock)
        self.channels = (name,)
        self.stroke = stroke
        self._channel = self._own_channel = channel
        self._plant = plant
        self.resolution = resolution
        """Of its position, m."""
        self._speed_resolution = speed_resolution
        self._max_speed = max_speed
        self._frozen_until = 0.0
        self._offset = 0.0
        self._alarmed = False
        self._position: Reading[Vector] = Reading((0.0,), -inf)
        self._speed = 0.0
        self._before: Reading[Vector] = self._position
        self.add_fault("frozen", self._freeze)
        self.add_fault("jump", self._jump)
        self.add_fault("alarm", self._raise_alarm)
        self.add_fault("other_rod", self._mount_elsewhere)
        self._errors = RodFaults(name)
        for fault in ROD_FAULTS:
            self.add_fault(fault, partial(self._measure_wrongly, fault), self._errors.clear)

    def connect(self) -> None:
        """Take the first reading."""
        self._sample()

    def arm(self) -> None:
        """Take a fresh reading; an encoder has nothing to energise."""
        self._sample()

    def position(self) -> Reading[Vector]:
        """Return the rod's extension of the cycle before, m, shape (1,)."""
        return self._position

    def velocity(self) -> Reading[Vector]:
        """Return the rod's velocity of the cycle before, m/s, shape (1,)."""
        step = self._speed_resolution
        return Reading((round(self._speed / step) * step,), self._position.t)

    def check(self, now: float) -> None:
        """Raise if the encoder is not well, then sample the next reading.

        Raises
        ------
        DeviceFault
            It reports an alarm, or the position jumped.
        """
        if self._alarmed:
            raise DeviceFault(self.name, "it reports a position error")
        position = self._position
        ((here,), t), ((before,), then) = position, self._before
        moved = here - before
        bound = self._max_speed * (t - then) + self.resolution
        if moved > bound or -moved > bound:
            raise DeviceFault(
                self.name,
                "its position jumped, or the rod was pushed",
                value=f"{abs(moved):.6g} m",
                bound=f"{bound:.6g} m",
            )
        self._before = position
        self._sample()

    def make_safe(self) -> None:
        """Do nothing: an encoder moves nothing."""

    def _sample(self) -> None:
        now, step = self._clock.now(), self.resolution
        if now < self._silent_until:
            return
        if now < self._frozen_until:
            self._position = Reading(self._position.value, now)
            self._speed = 0.0
            return
        plant, channel = self._plant, self._channel
        extension = self._errors.measured(plant.position(channel), now) + self._offset
        self._position = _new(Reading, ((round(extension / step) * step,), now))
        self._speed = plant.speed(channel)

    def _freeze(self, duration: float | None) -> None:
        self._frozen_until = self._until("frozen", duration)

    def _jump(self, value: float | None) -> None:
        self._offset += 5e-3 if value is None else value

    def _measure_wrongly(self, fault: str, value: float | None) -> None:
        extension = self._plant.position(self._channel)
        self._errors.inject(fault, value, extension, self._clock.now())

    def _raise_alarm(self, _: float | None) -> None:
        self._alarmed = True

    def _mount_elsewhere(self, value: float | None) -> None:
        if value is None or not 0 <= value == int(value):
            raise ValueError(f"{self.name}: other_rod takes a channel's number, not {value}")
        self._channel = int(value)

    def repair(self) -> None:
        """End all faults that last."""
        super().repair()
        self._channel = self._own_channel
        self._frozen_until = 0.0
        self._offset = 0.0
        self._alarmed = False
