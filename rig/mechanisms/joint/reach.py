"""What is known of a pose of the spherical joint before it is taken, and of all its poses."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.feasibility import FeasibilityCheck, JointBounds, antipode_tilt
from controllers.spherical_joint.paper_wire import PaperWires
from controllers.spherical_joint.poses import (
    Vector,
    axis_from_tilt,
    azimuth_of,
    natural_rotation,
    paper_rotation,
    twist_of,
)
from controllers.spherical_joint.tension import TensionDistribution
from rig.hal.motion import Fact, facts_of
from rig.mechanisms.joint.fact_kinds import JOINT_FACTS, TOLD
from rig.mechanisms.joint.settings import JointSettings

_SECTORS = 48
"""Directions in which the greatest tilt is looked for, once round."""
_HALVINGS = 10
"""Of the range in which it must be."""


class PoseFacts(NamedTuple):
    """A pose as it is planned.

    Parameters
    ----------
    least_tension : float
        Of the four wires, while they hold the pose at base pressure and nothing rubs, N.
    reach : float
        Tilt that is possible and permitted in this direction but for the limit on tilts, rad.
    paper_error : float
        Greatest error of the paper's wire in the paper's pose, m.
    """

    least_tension: float
    reach: float
    paper_error: float


class JointReach:
    """Reach of the joint, load of its wires there, and how wrong the paper's wires are."""

    def __init__(self, settings: JointSettings) -> None:
        geometry = settings.geometry
        self._exact = ExactWires(geometry)
        self._paper = PaperWires(geometry)
        self._distribution = TensionDistribution(geometry)
        self._bounds = bounds = bounds_of(settings)
        self._highest = min(antipode_tilt(geometry), 0.5 * math.pi)
        self._check = FeasibilityCheck(geometry, replace(bounds, max_tilt=0.99 * math.pi))
        self._reaches: dict[int, float] = {}

    def at(self, axis: Vector) -> PoseFacts:
        """Return what is known of a pose."""
        tensions = self._distribution.hold(
            natural_rotation(axis), self._bounds.least_tension, self._bounds.total_tension
        )
        return PoseFacts(min(tensions), self._reach(azimuth_of(axis)), self.paper_error(axis))

    def paper_error(self, axis: Vector) -> float:
        """Return how far the paper's path of a wire is from the shortest one, m; the worst wire."""
        rotation = paper_rotation(axis)
        return max(
            abs(paper - exact)
            for paper, exact in zip(
                self._paper.lengths(rotation), self._exact.lengths(rotation), strict=True
            )
        )

    def pose_gap(self, axis: Vector) -> float:
        """Return by how much a wire differs between the paper's pose and the natural one, m."""
        paper, natural = paper_rotation(axis), natural_rotation(axis)
        return max(
            abs(one - other)
            for one, other in zip(
                self._exact.lengths(paper), self._exact.lengths(natural), strict=True
            )
        )

    def facts(self) -> Mapping[str, Fact]:
        """Return the numbers that metrics may name."""
        round_about = [math.tau * k / _SECTORS for k in range(_SECTORS)]
        reaches = [self._reach(azimuth) for azimuth in round_about]
        facts = {
            "reachable_tilt": min(reaches),
            "reachable_tilt_best": max(reaches),
        }
        for degrees in TOLD:
            tilt = math.radians(degrees)
            if tilt >= self._highest:
                continue
            circle = [axis_from_tilt(tilt, azimuth) for azimuth in round_about]
            facts[f"paper_wire_error_{degrees:g}deg"] = max(
                self.paper_error(axis) for axis in circle
            )
            facts[f"paper_pose_gap_{degrees:g}deg"] = max(self.pose_gap(axis) for axis in circle)
            facts[f"paper_twist_{degrees:g}deg"] = max(
                abs(twist_of(paper_rotation(axis))) for axis in circle
            )
        return facts_of(JOINT_FACTS, facts)

    def _reach(self, azimuth: float) -> float:
        sector = round(azimuth / math.tau * _SECTORS) % _SECTORS
        if sector not in self._reaches:
            lower, upper = 0.0, self._highest
            for _ in range(_HALVINGS):
                middle = 0.5 * (lower + upper)
                axis = axis_from_tilt(middle, math.tau * sector / _SECTORS)
                if self._check.check_pose(axis):
                    upper = middle
                else:
                    lower = middle
            self._reaches[sector] = lower
        return self._reaches[sector]


def bounds_of(settings: JointSettings) -> JointBounds:
    """Return what a profile allows the joint."""
    limits = settings.limits
    return JointBounds(
        max_tilt=limits.tilt,
        extension=(0.0, settings.stroke),
        home_extension=settings.home,
        least_tension=limits.tension[0],
        most_tension=limits.tension[1],
        total_tension=4.0 * settings.area * settings.base_pressure,
        seat_margin=limits.seat_margin,
        free_wires=limits.free_wires,
    )
