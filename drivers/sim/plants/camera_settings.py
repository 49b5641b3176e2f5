"""What a simulated camera is like, beside what its driver knows of it."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Lt, Unit


@dataclass(frozen=True, slots=True)
class CameraSimulationSettings:
    """Optics, sensor and link of a simulated camera.

    Parameters
    ----------
    latency : float, optional
        From the middle of the exposure to the sample at the driver, s. None: what the driver's
        settings say; another value makes the driver's calibration of it wrong.
    latency_jitter : float
        Spread (rms) of the latency, s; a time stamp is off by as much.
    drop_rate : float
        Probability that a frame is lost.
    sub_exposures : int
        Instants over which an exposure is averaged.
    blur : float
        Point spread of lens and sensor, rms, pixels.
    read_noise : float
        Of a pixel in the dark, rms, counts.
    shot_noise : float
        Variance of a pixel over its level, counts: 0.025 is a full well of 10,000 electrons.
    background, marker : float
        Levels of the scene and of the bright parts of the marker, counts.
    vignetting : float
        How much darker the scene is in the corners, relative.
    texture : float
        Unevenness of the scene, counts.
    rotation_error : tuple of float
        True orientation of the camera over the nominal one, a rotation vector, rad.
    position_error : tuple of float
        True place of the camera less the nominal one, base frame, m.
    noise : float
        Of each coordinate of a marker where no image is made, rms, m. E: 0.1 pixels.
    """

    latency: Annotated[float, Unit("s"), Gt(0), Le(1)] | None = None
    latency_jitter: Annotated[float, Unit("s"), Ge(0), Le(0.1)] = 0.0
    drop_rate: Annotated[float, Ge(0), Lt(1)] = 0.0
    sub_exposures: Annotated[int, Interval(ge=1, le=64)] = 4
    blur: Annotated[float, Interval(ge=0.1, le=10)] = 0.9
    read_noise: Annotated[float, Interval(ge=0, le=50)] = 1.5
    shot_noise: Annotated[float, Interval(ge=0, le=5)] = 0.025
    background: Annotated[float, Interval(ge=0, le=255)] = 35.0
    marker: Annotated[float, Interval(ge=0, le=255)] = 200.0
    vignetting: Annotated[float, Interval(ge=0, le=1)] = 0.2
    texture: Annotated[float, Interval(ge=0, le=50)] = 3.0
    rotation_error: Annotated[tuple[float, float, float], Unit("rad")] = (0.0, 0.0, 0.0)
    position_error: Annotated[tuple[float, float, float], Unit("m")] = (0.0, 0.0, 0.0)
    noise: Annotated[float, Unit("m"), Ge(0)] = 10e-6
