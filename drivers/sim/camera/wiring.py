"""From a driver's settings to the simulated camera on its other side.

Only the camera that is asked for is imported: the one with images needs a compiler and OpenCV.
"""

import zlib
from typing import TYPE_CHECKING, Any

from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.sim.camera.mounting import built, mounted
from drivers.sim.camera.ports import MarkerPort
from drivers.sim.camera.settings import CameraSimulationSettings
from drivers.sim.perturbation import Bounds
from rig.hal import Clock

if TYPE_CHECKING:
    from drivers.sim.camera.emulated import EmulatedCamera
    from drivers.sim.camera.imageless import SimulatedMarkerCamera
    from drivers.sim.camera.remote_camera import ServedCamera
    from drivers.sim.camera.remote_link import ReachedCamera


def emulate_marker_camera(
    name: str,
    settings: MarkerCameraSettings,
    plant: MarkerPort,
    seed: int,
    *,
    serial: int | None = None,
    scene: MarkerCameraSettings | None = None,
    optics: CameraSimulationSettings | None = None,
) -> "EmulatedCamera":
    """Return a camera for `--on virtual`: the link of the production driver.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : MarkerCameraSettings
        The driver's.
    plant : MarkerPort
        The physics.
    seed : int
        Of the simulation; each camera draws its own from it and its name.
    serial : int, optional
        The serial number of the profile, which the camera then has.
    scene : MarkerCameraSettings, optional
        As the camera was built and mounted; default: as its driver believes.
    optics : CameraSimulationSettings, optional
        What the camera is really like beside that; default: what the plant's settings say.
    """
    from drivers.sim.camera.emulated import EmulatedCamera

    return EmulatedCamera(
        name,
        settings,
        scene or settings,
        optics or _optics_of(plant),
        plant,
        _own_seed(name, seed),
        serial=settings.calibrated_serial if serial is None else str(serial),
    )


def serve_marker_camera(
    name: str,
    settings: MarkerCameraSettings,
    plant: MarkerPort,
    seed: int,
    channel: str,
    *,
    serial: int | None = None,
    scene: MarkerCameraSettings | None = None,
    optics: CameraSimulationSettings | None = None,
) -> "ServedCamera":
    """Return a camera of `rig simulate`, for a program in another process.

    Parameters
    ----------
    name, settings, plant, seed, serial, scene, optics
        As for `emulate_marker_camera`.
    channel : str
        The rig's first CAN interface.

    Raises
    ------
    ConnectionFailed
        Another process serves it there already.
    """
    from drivers.sim.camera.remote_camera import ServedCamera
    from drivers.sim.camera.remote_link import camera_address

    return ServedCamera(
        name,
        settings,
        scene or settings,
        optics or _optics_of(plant),
        plant,
        _own_seed(name, seed),
        camera_address(channel, name),
        serial=settings.calibrated_serial if serial is None else str(serial),
    )


def reach_marker_camera(name: str, channel: str) -> "ReachedCamera":
    """Return the link of the production driver to a camera that another process serves.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    channel : str
        The rig's first CAN interface.
    """
    from drivers.sim.camera.remote_link import ReachedCamera, camera_address

    return ReachedCamera(camera_address(channel, name))


def simulate_marker_camera(
    name: str,
    settings: MarkerCameraSettings,
    plant: MarkerPort,
    clock: Clock,
    seed: int,
    *,
    serial: int | None = None,
    scene: MarkerCameraSettings | None = None,
    optics: CameraSimulationSettings | None = None,
) -> "SimulatedMarkerCamera":
    """Return a camera for `--on sim`: positions straight from the plant.

    Parameters
    ----------
    name, settings, plant, seed, serial, scene, optics
        As for `emulate_marker_camera`.
    clock : Clock
        The rig's.
    """
    from drivers.sim.camera.imageless import SimulatedMarkerCamera

    return SimulatedMarkerCamera(
        name,
        settings,
        scene or settings,
        optics or _optics_of(plant),
        plant,
        clock,
        _own_seed(name, seed),
        serial=serial,
    )


def true_camera(
    nominal: MarkerCameraSettings, plant: MarkerPort, bounds: Bounds, seed: int
) -> dict[str, Any]:
    """Return what is true of a camera, by the keyword of the functions above.

    Parameters
    ----------
    nominal : MarkerCameraSettings
        Its settings before any calibration, which is its driver's knowledge alone.
    plant : MarkerPort
        The physics, whose settings say what else the camera is like.
    bounds : Bounds
        By how much lens, latency and pose may differ.
    seed : int
        Of the simulation.
    """
    return {
        "scene": built(nominal, bounds, seed),
        "optics": mounted(_optics_of(plant), bounds, seed),
    }


def _optics_of(plant: object) -> CameraSimulationSettings:
    """Return what the plant's settings say of the camera that watches it."""
    settings = getattr(plant, "settings", None)
    return getattr(settings, "camera", None) or CameraSimulationSettings()


def _own_seed(name: str, seed: int) -> int:
    return zlib.crc32(f"{seed}/{name}".encode())
