"""What a simulated camera is like: given with the plant that it watches."""

from drivers.sim.plants.camera_settings import CameraSimulationSettings

__all__ = ["CameraSimulationSettings"]
