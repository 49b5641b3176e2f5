"""Everything that the driver of marker cameras offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.marker_camera.settings:MarkerCameraSettings",
    device="drivers.marker_camera.device:MarkerCameraDriver",
    on_bus=False,
    simulation="drivers.sim.camera.wiring:WIRING",
)
