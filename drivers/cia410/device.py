"""Inclinometers with gyroscopes after CiA 410.

References
----------
CiA 410 V1.2: 0x6000 resolution, 0x6010 slope long16, 0x6020 slope lateral16.
"""

from math import inf

from drivers.canopen.bus import CanopenBus
from drivers.canopen.sensor import CyclicSensor
from drivers.cia410.codec import RESOLUTION, decode_lean, lean_codec
from drivers.cia410.settings import PROFILE, Cia410Settings
from rig.hal import ConnectionFailed, InertialSensor, Reading, Vector

_SAME = 1e-3
"""Relative difference of two resolutions that is rounding."""


class Cia410Sensor(CyclicSensor, InertialSensor):
    """One inclinometer; satisfies `rig.hal.InertialSensor`.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.
    """

    Settings = Cia410Settings

    def __init__(
        self, name: str, settings: Cia410Settings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        super().__init__(name, settings, bus, self._take, profile=PROFILE, serial=serial)
        self.settings = settings
        self._codec = lean_codec(settings)
        self._values = (0.0, 0.0, 0.0, 0.0)
        self._sampled_at = -inf

    def _take(self, values: tuple[float, ...], t: float) -> None:
        """Decode a sample. Hot path."""
        self._frozen.see(values, t)
        self._values = decode_lean(self._codec, values)
        self._sampled_at = t

    def compare(self) -> None:
        """Raise `ConnectionFailed` if it counts other steps than the profile says."""
        settings = self.settings
        counted = self._node.read_if_present(0x6000, 0, "u16")
        if counted is not None:
            step = RESOLUTION * float(counted)
            if abs(step - settings.step) > _SAME * settings.step:
                raise ConnectionFailed(
                    self.name,
                    "its slopes have another step than the profile says",
                    node=settings.node,
                    object="0x6000:00",
                    value=f"{step:.4g} rad",
                    bound=f"{settings.step:.4g} rad",
                )

    # The cycle ------------------------------------------------------------------------

    def lean(self) -> Reading[Vector]:
        """Return roll and pitch, rad."""
        return Reading(self._values[:2], self._sampled_at)

    def turning(self) -> Reading[Vector]:
        """Return the rates about x and y, rad/s."""
        return Reading(self._values[2:], self._sampled_at)
