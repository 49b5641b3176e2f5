"""From a camera driver's settings to the simulated camera on its other side.

Only the camera that is asked for is imported: the one with images needs a compiler and OpenCV.
"""

import zlib
from typing import TYPE_CHECKING

from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.sim.camera.mounting import built, mounted
from drivers.sim.camera.ports import CameraBuild, MarkerPort
from drivers.sim.wiring import Installed, LinkWiring
from rig.hal import Clock

if TYPE_CHECKING:
    from drivers.sim.camera.emulated import EmulatedCamera
    from drivers.sim.camera.imageless import SimulatedMarkerCamera
    from drivers.sim.camera.remote_camera import ServedCamera
    from drivers.sim.camera.remote_link import ReachedCamera

Camera = Installed[MarkerCameraSettings, MarkerPort]


def emulate_marker_camera(of: Camera) -> "EmulatedCamera":
    """Return a camera for `--on virtual`: the link of the production driver."""
    from drivers.sim.camera.emulated import EmulatedCamera

    return EmulatedCamera(true_camera(of), of.plant)


def serve_marker_camera(of: Camera, channel: str) -> "ServedCamera":
    """Return a camera of `rig simulate`, for a program in another process.

    Raises
    ------
    ConnectionFailed
        Another process serves it there already.
    """
    from drivers.sim.camera.remote_camera import ServedCamera
    from drivers.sim.camera.remote_link import camera_address

    return ServedCamera(true_camera(of), of.plant, camera_address(channel, of.name))


def reach_marker_camera(name: str, channel: str) -> "ReachedCamera":
    """Return the link of the production driver to a camera that another process serves."""
    from drivers.sim.camera.remote_link import ReachedCamera, camera_address

    return ReachedCamera(camera_address(channel, name))


def simulate_marker_camera(of: Camera, clock: Clock) -> "SimulatedMarkerCamera":
    """Return a camera for `--on sim`: positions straight from the plant."""
    from drivers.sim.camera.imageless import SimulatedMarkerCamera

    return SimulatedMarkerCamera(true_camera(of), of.plant, clock, required_serial=of.serial)


def true_camera(of: Camera) -> CameraBuild:
    """Return what is true of a camera, whatever its driver believes."""
    serial = of.settings.calibrated_serial if of.serial is None else str(of.serial)
    return CameraBuild(
        of.name,
        of.settings,
        built(of.built, of.bounds, of.seed) if of.bounds else of.built,
        mounted(of.plant.camera, of.bounds, of.seed) if of.bounds else of.plant.camera,
        # Each camera draws its own from the simulation's seed and its name.
        zlib.crc32(f"{of.seed}/{of.name}".encode()),
        serial,
    )


WIRING = LinkWiring(
    emulate_marker_camera, simulate_marker_camera, serve_marker_camera, reach_marker_camera
)
