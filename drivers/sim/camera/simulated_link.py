"""The driver's link to a simulated camera, up to what it sees."""

from math import inf
from pathlib import Path
from typing import Final

from drivers.marker_camera.link import Failure, Ready
from drivers.sim.camera.faults import CameraFaults
from drivers.sim.camera.ports import CameraBuild, Delivery, MarkerPort

_UNPLUGGED: Final = Failure("the camera stopped sending frames; it was unplugged or lost its power")


class SimulatedLink(CameraFaults):
    """Opened, closed, and ended by a pulled plug; a camera adds what its frames show.

    Parameters
    ----------
    build : CameraBuild
        The camera.
    plant : MarkerPort
        The physics.
    """

    def __init__(self, build: CameraBuild, plant: MarkerPort) -> None:
        super().__init__(build.name)
        self._settings = build.settings
        self._plant = plant
        self._serial = build.serial
        self._delivery = Delivery(build)
        self._start = inf
        self._frame = 0
        """Number of the next frame."""

    def show_in(self, picture: Path) -> None:
        """Put pictures into this file, if it has any; a camera without images has none."""

    def open(self, now: float) -> None:
        """Begin to expose frames."""
        self.close()
        self.now = now
        if not self._is_unplugged():
            self._start = now
            self._delivery.send(Ready(self._serial), now)

    def close(self) -> None:
        """Stop exposing; frames under way are lost. Idempotent."""
        self._start = inf
        self._frame = 0
        self._delivery.lose()

    def _is_unplugged(self) -> bool:
        """Return whether the plug is out; if it is, frames end, and the driver is told so."""
        if not self.has("unplugged"):
            return False
        self.close()
        self._delivery.send(_UNPLUGGED, self.now)
        return True
