"""A law's plan of the arm as the loop follows it."""

import numpy as np

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, link_points
from controllers.arm.plan import ArmPlan
from controllers.arm.types import ArmReference
from rig.hal.motion import Fact, Segment
from rig.mechanisms.arm.facts import facts_of_plan
from rig.mechanisms.arm.remarks import remarks_of_plan
from rig.mechanisms.servo.planned import PlannedMotion

SETTLING = 0.25
"""For how long the end of the motion is held before the run ends, s: the arm gets there later."""


class PlannedArmMotion(PlannedMotion[ArmReference]):
    """A plan of a law as the loop follows it, with what is known of it beforehand."""

    def __init__(self, plan: ArmPlan, geometry: ArmGeometry, path: object) -> None:
        self.plan = plan
        arm = dimensions_of(geometry)
        points = np.array([link_points(arm, tuple(q))[2:4] for q in plan.positions.tolist()])
        columns = [
            plan.hand,
            points[:, 0],
            points[:, 1],
            plan.twist,
            plan.command,
            plan.indices,
            plan.scale,
            plan.inside,
            plan.path,
        ]
        super().__init__(np.column_stack(columns))
        self.facts = self.facts_from(plan, geometry, path)
        self.remarks = remarks_of_plan(plan, arm, geometry)

    @classmethod
    def facts_from(cls, plan: ArmPlan, geometry: ArmGeometry, asked: object) -> dict[str, Fact]:
        """Return what is known of it beforehand.

        Parameters
        ----------
        plan, geometry
            Of the law and of the arm.
        asked : object
            The settings of the experiment's reference.
        """
        return facts_of_plan(plan, geometry, asked)

    @property
    def duration(self) -> float:
        """How long it takes, s: whole periods, and `SETTLING`."""
        return float(self.plan.t[-1]) + SETTLING

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The whole motion, the path without the settling, and the law's region if it has one."""
        # A law that halts where it starts has one cycle.
        end = max(min(self.plan.duration, float(self.plan.t[-1])), self.plan.period)
        whole = (Segment("all", 0.0, self.duration), Segment("path", 0.0, end))
        region = self.plan.marks.get("region", ())
        if len(region) < 2:
            return whole
        return (*whole, Segment("region", region[0], min(region[1], self.duration)))

    def at(self, t: float) -> ArmReference:
        """Return what the arm should do at `t`."""
        plan = self.plan
        if t > plan.t[-1] + 0.5 * plan.period:
            return plan.at(float(plan.t[-1]))._replace(velocities=(0.0,) * 6)
        return plan.at(t)
