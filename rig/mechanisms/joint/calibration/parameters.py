"""The parameters of a joint and its camera, and their priors.

Every dimension is in the drawing and has a tolerance in the profile: that is its prior. So the
drawing stays where motion shows less than it. Two directions show in no motion:

- turning all anchors and the camera together about the vertical: angles count from their mean;
- making marker and camera farther away in proportion: the marker's height is read off a gauge.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from controllers.spherical_joint.geometry import SphericalJointGeometry
from rig.config import Profile

Values = Mapping[str, float]

WIRES = (1, 2, 3, 4)
PARTS = ("turned", "raised", "shift_x", "shift_y", "shift_z")
"""How far an anchor is off its place along and across its circle, an adjust point in x, y, z."""

LENGTHS = ("ball_radius", "ring_radius", "adjust_radius", "adjust_depth", "marker_height")
ANGLES = tuple(f"anchor_angle_{k}" for k in WIRES)
CAMERA = tuple(f"camera_{axis}" for axis in "xyz")
CAMERA_ANGLES = tuple(f"camera_angle_{axis}" for axis in "xyz")

_FLAT = 1.0 / math.sqrt(3.0)
"""Standard deviation over the bound of what lies anywhere within a tolerance."""

_MOUNTED = 20e-3
_TURNED = 0.15
_LATE = 20e-3
"""How well a camera is known that nobody has measured: place, orientation, latency; m, rad, s."""

_HOMED = 5e-3
"""How well it is known where the wires are taut, m."""

_LOADED = 0.03
"""What friction of the seals may grow with the chamber's pull, as a share of it. E."""

_LEAST_FRICTION = 0.1
"""Of a pair: a belief that there is none is none of which a share could be taken, N and N s/m."""

_REVERSED = 0.5
"""Natural logarithm of how far the way over which friction turns round is known. E."""


class Prior(NamedTuple):
    """Prior knowledge of a parameter.

    Parameters
    ----------
    name, unit : str
        SI.
    mean, std : float
        In `unit`.
    even : bool
        Whether it lies anywhere within a tolerance, rather than near the mean.
    considered : bool
        Whether it stays what it is believed to be, whatever the data say, since they would
        take it for what the model leaves out; its error is passed on to the others.
    """

    name: str
    unit: str
    mean: float
    std: float
    even: bool = False
    considered: bool = False


def drawing_of(profile: Profile) -> SphericalJointGeometry:
    """Return the geometry that the profile has without any calibration."""
    geometry: SphericalJointGeometry = profile.nominal_settings.geometry
    return geometry


def made_of(profile: Profile) -> tuple[list[Prior], list[Prior]]:
    """Return what the drawing and its tolerances say of dimensions, and of the single parts."""
    drawing, tolerance = drawing_of(profile), profile.mechanism_settings.tolerance
    part, length = _FLAT * tolerance.part, _FLAT * tolerance.length
    sizes = [(name, getattr(drawing, name)) for name in LENGTHS]
    dimensions = [Prior(name, "m", size, length * size, True) for name, size in sizes]
    dimensions += _each(ANGLES, "rad", drawing.anchor_angles, _FLAT * tolerance.angle, even=True)
    names = [f"{name}_{k}" for k in WIRES for name in PARTS] + ["marker_x", "marker_y"]
    return dimensions, _each(names, "m", (0.0,) * len(names), part, even=True)


def priors_of(profile: Profile, height: float | None = None) -> tuple[Prior, ...]:
    """Return every parameter with what drawing, tolerances and the friction's model say.

    Parameters
    ----------
    profile : Profile
        The rig.
    height : float, optional
        How well the marker's height is known if the geometry was calibrated, m; else it is the
        drawing's.
    """
    settings, drawing = profile.mechanism_settings, drawing_of(profile)
    tolerance = settings.tolerance
    camera = profile.devices[settings.camera].nominal
    rows, parts = made_of(profile)
    if height is not None and settings.geometry != drawing:
        marker = Prior("marker_height", "m", settings.geometry.marker_height, height)
        rows = [marker if row.name == marker.name else row for row in rows]
    rows += _each(CAMERA, "m", camera.position_camera_in_base, _MOUNTED)
    rows += _each(CAMERA_ANGLES, "rad", (0.0,) * 3, _TURNED)
    rows += [Prior("lateness", "s", 0.0, _LATE), Prior("home", "m", settings.home, _HOMED)]
    rows += _each((f"offset_{k}" for k in WIRES), "m", (0.0,) * 4, tolerance.zero)
    compliance = 1.0 / settings.wire_stiffness
    rows += [Prior("compliance", "m/N", compliance, tolerance.stiffness * compliance)]
    # A pair has two seals.
    seal = 0.5 * max(settings.friction.coulomb, _LEAST_FRICTION)
    damping = 0.5 * max(settings.friction.viscous, _LEAST_FRICTION)
    rows += _each((f"friction_{k}" for k in WIRES), "N", (seal,) * 4, 0.5 * seal)
    rows += [Prior("viscous", "N s/m", damping, _FLAT * tolerance.friction * damping, True)]
    rows += [Prior("excess", "1", 0.0, _FLAT * tolerance.friction, True, True)]
    rows += [Prior("load", "1", 0.0, _LOADED), Prior("reversal", "1", 0.0, _REVERSED)]
    return (*rows, *parts)


def _each(
    names: Iterable[str], unit: str, means: Sequence[float], std: float, *, even: bool = False
) -> list[Prior]:
    return [Prior(name, unit, mean, std, even) for name, mean in zip(names, means, strict=True)]
