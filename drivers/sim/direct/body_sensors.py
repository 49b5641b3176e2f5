"""Load cells and inertial sensors of `--on sim`: straight on a plant, without a bus."""

from collections.abc import Sequence

from drivers.sim.direct.device import SimulatedDevice
from rig.hal import Clock, DeviceFault, InertialSensor, LoadCells, MeasuredPlant, Reading, Vector


class SimulatedInputs(SimulatedDevice):
    """Inputs that are sampled once a cycle, in whole counts.

    Faults: ``silent`` (value: s), ``repair``. Readings that are frozen in every count are a fault,
    as they are on a bus.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    plant : MeasuredPlant
        The physics.
    channels : sequence of int
        The plant's, in the order of the device's own.
    steps : sequence of float
        What one count of each is, SI.
    frozen_timeout : float or None
        For how long nothing may change, s.
    clock : Clock
        The rig's.
    """

    def __init__(
        self,
        name: str,
        plant: MeasuredPlant,
        channels: Sequence[int],
        steps: Sequence[float],
        frozen_timeout: float | None,
        clock: Clock,
    ) -> None:
        super().__init__(name, clock)
        self._plant = plant
        self._inputs = tuple(zip(channels, steps, strict=True))
        self._frozen_timeout = frozen_timeout
        self._values: Vector = ()
        self._sampled_at = 0.0
        self._changed_at = [0.0] * len(self._inputs)

    def connect(self) -> None:
        """Take the first readings."""
        self._sample()

    def arm(self) -> None:
        """Take readings from now on."""
        self._sample()

    def make_safe(self) -> None:
        """Do nothing: a sensor moves nothing."""

    def check(self, now: float) -> None:
        """Raise if nothing changes any more, then sample the next readings.

        Raises
        ------
        DeviceFault
            With for how long.
        """
        timeout = self._frozen_timeout
        longest = self._sampled_at - self._last_change()
        if timeout is not None and longest > timeout:
            raise DeviceFault(
                self.name,
                self._frozen_words(self._sampled_at - 0.5 * timeout),
                value=f"{longest:.3g} s",
                bound=f"{timeout:g} s",
            )
        self._sample()

    def _last_change(self) -> float:
        return max(self._changed_at)

    def _frozen_words(self, since: float) -> str:
        return "its readings are frozen: no count has changed"

    def _sample(self) -> None:
        if self._is_silent():
            return
        self._sampled_at = self._clock.now()
        read = self._plant.channel_value
        values = tuple([round(read(channel) / step) * step for channel, step in self._inputs])
        before = self._values or (None,) * len(values)
        for k, (value, then) in enumerate(zip(values, before, strict=True)):
            if value != then:
                self._changed_at[k] = self._sampled_at
        self._values = values


class SimulatedLoadCells(SimulatedInputs, LoadCells):
    """Load cells; satisfies `rig.hal.LoadCells`. Parameters are those of `SimulatedInputs`.

    A single cell that is frozen is a fault, too.
    """

    channels: tuple[str, ...] = ()

    def _last_change(self) -> float:
        return min(self._changed_at)

    def _frozen_words(self, since: float) -> str:
        pairs = zip(self.channels, self._changed_at, strict=True)
        still = [channel for channel, changed_at in pairs if changed_at < since]
        if len(still) == len(self.channels):
            return super()._frozen_words(since)
        return f"frozen: no count has changed of {', '.join(still)}"

    def forces(self) -> Reading[Vector]:
        """Return what each cell bears, N, shape (n,)."""
        return Reading(self._values, self._sampled_at)


class SimulatedInertialSensor(SimulatedInputs, InertialSensor):
    """An inertial sensor; satisfies `rig.hal.InertialSensor`. Parameters as of its base."""

    def lean(self) -> Reading[Vector]:
        """Return roll and pitch, rad."""
        return Reading(self._values[:2], self._sampled_at)

    def turning(self) -> Reading[Vector]:
        """Return the rates about x and y, rad/s."""
        return Reading(self._values[2:], self._sampled_at)
