"""Load cells on the analogue inputs of a CiA 401 module.

References
----------
CiA 401 V3.0: 0x6401 analogue inputs of 16 bits.
"""

from math import inf

from drivers.canopen.bus import CanopenBus
from drivers.canopen.frozen import FrozenChannels
from drivers.canopen.sensor import CyclicSensor
from drivers.load_cells.codec import cell_codec, decode_force
from drivers.load_cells.settings import PROFILE, LoadCellSettings
from rig.hal import DeviceFault, LoadCells, Reading, Vector


class CanopenLoadCells(CyclicSensor, LoadCells):
    """Load cells; satisfies `rig.hal.LoadCells`.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.
    """

    Settings = LoadCellSettings

    def __init__(
        self, name: str, settings: LoadCellSettings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        super().__init__(name, settings, bus, self._take, profile=PROFILE, serial=serial)
        self.settings = settings
        self.channels = tuple(settings.cells)
        self._frozen = FrozenChannels(name, settings.frozen_timeout, self.channels)
        self._codecs = tuple(cell_codec(cell) for cell in settings.cells.values())
        self._counts: tuple[float, ...] = ()
        self._forces: Reading[Vector] = Reading((0.0,) * len(self.channels), -inf)
        self._overload_after = settings.overload_after
        self._overloads = [0] * len(self.channels)

    def _take(self, values: tuple[float, ...], t: float) -> None:
        """Decode a sample. Hot path."""
        self._counts = values
        self._frozen.see(values, t)
        forces = [decode_force(*pair) for pair in zip(self._codecs, values, strict=True)]
        self._forces = Reading(tuple(forces), t)
        for k, (codec, counts) in enumerate(zip(self._codecs, values, strict=True)):
            self._overloads[k] = 0 if codec.low < counts < codec.high else self._overloads[k] + 1

    def arm(self) -> None:
        """Start the module and take a first reading; see `CyclicSensor.arm`."""
        self._overloads = [0] * len(self.channels)
        super().arm()

    # The cycle ------------------------------------------------------------------------

    def forces(self) -> Reading[Vector]:
        """Return what each cell bears, N, shape (n,)."""
        return self._forces

    def check(self, now: float) -> None:
        """Raise if the module is silent, a reading is frozen, or a cell is at its end.

        Raises
        ------
        DeviceFault
            With the cell, its counts and their bounds.
        """
        super().check(now)
        if not self._armed:
            return
        for channel, codec, counts, overloads in zip(
            self.channels, self._codecs, self._counts, self._overloads, strict=True
        ):
            if overloads >= self._overload_after:
                raise DeviceFault(
                    self.name,
                    f"{channel} is at the end of its range: overloaded, or its wire is off",
                    value=f"{counts:g} counts in {overloads} samples",
                    bound=f"{codec.low:g} … {codec.high:g} counts",
                )
