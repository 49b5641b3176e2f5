"""What a profile says of a marker camera.

Pixel coordinates are OpenCV's: the centre of the top left pixel is (0, 0), x runs to the
right and y down. The camera's frame has the same x and y, and z along the view.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Interval, Le, MinLen, Unit

from rig.hal import DriverSettings
from rig.hal.rules import Rules

DictionaryName = Literal[
    "4x4_50", "4x4_100", "4x4_250", "5x5_50", "5x5_100", "5x5_250", "6x6_50", "6x6_250"
]
"""ArUco dictionaries, by the size of their markers and their number."""


@dataclass(frozen=True, slots=True)
class SourceSettings:
    """The source of the frames.

    Parameters
    ----------
    kind : str
        ``uvc``: a camera of the operating system. ``video``: a recorded file. ``images``: a
        folder of image files, taken in the order of their names.
    path : Path
        The device (``/dev/video0`` or ``"0"``), file or folder.
    paced : bool
        Play a recording at the frame rate; False: as fast as its frames are detected.
    repeat : bool
        Start a recording again at its end.
    pixel_format : str
        What a camera is asked to send, a four-character code: ``GREY``, ``YUYV``, ``MJPG``.
    """

    kind: Literal["uvc", "video", "images"] = "uvc"
    path: Path = Path("/dev/video0")
    paced: bool = True
    repeat: bool = False
    pixel_format: Annotated[str, MinLen(4)] = "GREY"


@dataclass(frozen=True, slots=True)
class IntrinsicsSettings:
    """The lens: a pinhole with distortion after Brown and Conrady.

    Parameters
    ----------
    fx, fy : float
        Focal length, pixels.
    cx, cy : float
        Principal point, pixels.
    k1, k2, k3 : float
        Radial distortion.
    p1, p2 : float
        Tangential distortion.
    """

    fx: Annotated[float, Gt(0)] = 3333.0
    fy: Annotated[float, Gt(0)] = 3333.0
    cx: Annotated[float, Interval(ge=-1e5, le=1e5)] = 639.5
    cy: Annotated[float, Interval(ge=-1e5, le=1e5)] = 511.5
    k1: Annotated[float, Interval(ge=-2, le=2)] = 0.0
    k2: Annotated[float, Interval(ge=-10, le=10)] = 0.0
    p1: Annotated[float, Interval(ge=-0.1, le=0.1)] = 0.0
    p2: Annotated[float, Interval(ge=-0.1, le=0.1)] = 0.0
    k3: Annotated[float, Interval(ge=-50, le=50)] = 0.0


@dataclass(frozen=True, slots=True)
class MarkerSettings:
    """The marker: it lies on a sphere round the joint's centre, square to the radius.

    Parameters
    ----------
    kind : str
        ``blob``: a disc. ``aruco``: a square with a number, which also shows the twist.
    sphere_radius : float
        Distance of the marker from the joint's centre, m.
    diameter : float
        Of the disc, m.
    polarity : str
        Whether the disc is brighter or darker than what surrounds it.
    area_tolerance : float
        How far the disc's area in the image may be off what its place asks for, relative.
    dictionary : str
        Of ArUco markers.
    ids : tuple of int
        The markers that belong to this rig; the disc bears the first.
    side : float
        Side of an ArUco marker's black square, m.
    """

    kind: Literal["blob", "aruco"] = "blob"
    sphere_radius: Annotated[float, Unit("m"), Gt(0)] = 52.628e-3
    diameter: Annotated[float, Unit("m"), Gt(0)] = 6e-3
    polarity: Literal["bright", "dark"] = "bright"
    area_tolerance: Annotated[float, Gt(0), Le(0.9)] = 0.3
    dictionary: DictionaryName = "4x4_50"
    ids: Annotated[tuple[Annotated[int, Interval(ge=0, le=249)], ...], MinLen(1)] = (0,)
    side: Annotated[float, Unit("m"), Gt(0)] = 8e-3


@dataclass(frozen=True, slots=True)
class MarkerCameraSettings(DriverSettings):
    """A camera that watches the marker of a joint.

    Parameters
    ----------
    source : SourceSettings
        Where the frames come from.
    width, height : int
        Of the image, pixels.
    frame_rate : float
        Frames per second.
    exposure : float
        Exposure time, s; fixed, since an automatic one moves the exposure's middle.
    latency : float
        From the middle of the exposure to the time stamp that the source gives a frame, s.
    intrinsics : IntrinsicsSettings
        The lens, from calibration.
    rotation_base_from_camera : tuple of float
        The camera's orientation in the joint's base frame, a rotation vector, rad.
    position_camera_in_base : tuple of float
        The camera's place in the joint's base frame, m.
    calibrated_serial : str, optional
        Serial number of the camera that intrinsics and pose were measured with.
    marker : MarkerSettings
        What it looks for.
    roi : int
        Side of the region that is searched round the expected place, pixels.
    min_contrast : float
        Least difference between marker and surroundings, counts of 255.
    dark_level : float
        An image whose mean is below is dark: the lens is covered or the lamp off, counts.
    max_age : float
        Greatest age of the newest frame, s.
    max_absence : float
        How long the marker may be out of sight, s.
    max_identical : int
        So many equal images in a row mean that the stream is frozen: noise is never equal.
    connect_timeout : float
        How long the first frame and the first sight of the marker may take, s.
    """

    scaling = (
        "width", "height", "exposure", "latency", "intrinsics", "rotation_base_from_camera",
        "position_camera_in_base", "marker.kind", "marker.sphere_radius", "marker.ids",
        "marker.side",
    )  # fmt: skip

    source: SourceSettings = field(default_factory=SourceSettings)
    width: Annotated[int, Interval(ge=64, le=8192)] = 1280
    height: Annotated[int, Interval(ge=64, le=8192)] = 1024
    frame_rate: Annotated[float, Unit("Hz"), Gt(0), Le(1000)] = 60.0
    exposure: Annotated[float, Unit("s"), Gt(0), Le(1)] = 5e-3
    latency: Annotated[float, Unit("s"), Ge(0), Le(1)] = 40e-3
    intrinsics: IntrinsicsSettings = field(default_factory=IntrinsicsSettings)
    rotation_base_from_camera: Annotated[tuple[float, float, float], Unit("rad")] = (
        3.141592653589793,
        0.0,
        0.0,
    )
    position_camera_in_base: Annotated[tuple[float, float, float], Unit("m")] = (0.0, 0.0, 0.4)
    calibrated_serial: str | None = None
    marker: MarkerSettings = field(default_factory=MarkerSettings)
    roi: Annotated[int, Interval(ge=32, le=1024)] = 192
    min_contrast: Annotated[float, Interval(ge=1, le=255)] = 30.0
    dark_level: Annotated[float, Interval(ge=0, le=255)] = 8.0
    max_age: Annotated[float, Unit("s"), Gt(0)] = 0.15
    max_absence: Annotated[float, Unit("s"), Gt(0)] = 0.25
    max_identical: Annotated[int, Interval(ge=2, le=1000)] = 5
    connect_timeout: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 5.0

    def __post_init__(self) -> None:
        with Rules() as rule:
            if self.exposure > 1.0 / self.frame_rate:
                rule.broken(
                    f"exposure ({self.exposure:g} s) is longer than one frame "
                    f"({1.0 / self.frame_rate:g} s) at {self.frame_rate:g} Hz."
                )
            if self.max_age <= self.latency + 1.0 / self.frame_rate:
                rule.broken(
                    f"max_age ({self.max_age:g} s) is not above the latency ({self.latency:g} s) "
                    f"and one frame ({1.0 / self.frame_rate:g} s): every reading would be too old."
                )
            distance = sum(x * x for x in self.position_camera_in_base) ** 0.5
            if distance <= self.marker.sphere_radius:
                rule.broken(
                    f"position_camera_in_base is {distance:g} m from the joint's centre, inside "
                    f"the marker's sphere of {self.marker.sphere_radius:g} m."
                )
            largest = self.marker_size * self.intrinsics.fx / (distance - self.marker.sphere_radius)
            if self.roi < 1.5 * largest:
                rule.broken(
                    f"roi ({self.roi} pixels) is too small for a marker of up to {largest:.0f} "
                    f"pixels: it takes at least {1.5 * largest:.0f}."
                )

    def device_path(self) -> str | None:
        """Return the camera of the operating system, if that is what is looked through."""
        if self.source.kind != "uvc":
            return None
        path = str(self.source.path)
        return f"/dev/video{path}" if path.isdecimal() else path

    @property
    def marker_size(self) -> float:
        """Return the marker's greatest extent, m: a diameter or a diagonal."""
        marker = self.marker
        return marker.diameter if marker.kind == "blob" else 2.0**0.5 * marker.side
