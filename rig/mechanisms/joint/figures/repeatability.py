"""How well the joint reaches a pose again."""

import re
from typing import TYPE_CHECKING

import numpy as np

from rig.report.data import RunData
from rig.report.figure import FigureKind
from rig.report.repeatability import Visit, draw_repeatability, places_of, visits_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_UPRIGHT = 1e-9
"""A marker that is no further off the axis, as a share of its distance, has no azimuth."""


def draw_joint_repeatability(run: RunData) -> "Figure | None":
    """Draw where the marker ended at poses that were gone to several times."""
    if not run.has("reference.marker_x", "estimate.marker_x"):
        return None
    source = "truth" if run.has("truth.marker_x") else "estimate"
    visits = visits_of(run, run.track("reference.marker"), run.track(f"{source}.marker"))
    places = places_of(visits, _off, _name)
    return draw_repeatability(places, ("along the azimuth", "along the tilt"))


def _off(visit: Visit) -> "NDArray[np.float64]":
    """Return how far the marker ended off its target along azimuth and tilt, m."""
    out = visit.target / np.linalg.norm(visit.target)
    sideways = np.array([-out[1], out[0], 0.0])
    size = float(np.linalg.norm(sideways))
    sideways = np.array([0.0, 1.0, 0.0]) if size < _UPRIGHT else sideways / size
    outwards = np.cross(sideways, out)
    error = visit.end - visit.target
    return np.array([sideways @ error, outwards @ error])


def _name(visit: Visit) -> str:
    return re.sub(r"^hold (\S+) deg at (\S+) deg.*$", r"\1°, \2°", visit.name)


REPEATABILITY_FIGURES = {
    "repeatability": FigureKind(
        draw_joint_repeatability,
        "Where the marker ended at each visit of a pose, about their mean (the true marker in "
        "simulation, else camera and encoders); dashed, where 95 % of further visits end. AP and "
        "RP: pose accuracy and repeatability of ISO 9283.",
    ),
}
