"""A U-R-S arm of six joints on servo drives."""

import math
from collections.abc import Mapping
from typing import Any, get_args

import numpy as np

from controllers.arm.geometry import JOINT_NAMES, ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward, link_points
from controllers.arm.paths import ArmPathSettings
from controllers.arm.plan import ArmPlan
from controllers.arm.types import ArmCommand, ArmReference, ArmState
from rig.mechanisms.arm_settings import ArmSettings
from rig.mechanisms.servo_joints import JointLimits, Kinds, ServoJoints, servo_columns
from rig.runtime.columns import Column
from rig.runtime.motion import Fact, Segment

_INDICES = (("shoulder", "m"), ("elbow", ""), ("wrist", ""))
"""Singularity indices c, S3 and S5: names and units."""


class PlannedArmMotion:
    """A plan of a law as the loop follows it, with what is known of it beforehand."""

    waits = True
    """A late cycle holds the motion: what a law has not commanded must not be left out."""

    def __init__(self, plan: ArmPlan, geometry: ArmGeometry) -> None:
        self.plan = plan
        arm = dimensions_of(geometry)
        points = [link_points(arm, tuple(q)) for q in plan.positions.tolist()]
        self._rows: list[tuple[float, ...]] = [
            tuple(row)
            for row in np.column_stack(
                [
                    plan.hand,
                    np.array([point[2] for point in points]),
                    np.array([point[3] for point in points]),
                    np.linalg.norm(plan.twist[:, :3], axis=1),
                    np.linalg.norm(plan.twist[:, 3:], axis=1),
                    np.linalg.norm(plan.command[:, :3], axis=1),
                    np.linalg.norm(plan.command[:, 3:], axis=1),
                    plan.indices,
                    plan.scale,
                    plan.inside,
                    plan.deviation,
                ]
            ).tolist()
        ]
        self.facts: Mapping[str, Fact] = _facts(plan)

    @property
    def duration(self) -> float:
        """How long it takes, s: whole periods, and one to come to rest in."""
        return float(self.plan.t[-1]) + self.plan.period

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The whole motion, and the singular region if the law has one."""
        whole = Segment("all", 0.0, self.duration)
        region = self.plan.marks.get("region", ())
        if len(region) < 2:
            return (whole,)
        return (whole, Segment("region", region[0], min(region[1], self.duration)))

    def at(self, t: float) -> ArmReference:
        """Return what the arm should do at `t`."""
        plan = self.plan
        if t > plan.t[-1] + 0.5 * plan.period:
            return plan.at(float(plan.t[-1]))._replace(velocities=(0.0,) * 6)
        return plan.at(t)

    def sample(self, number: int) -> tuple[float, ...]:
        """Return the plan's columns of a cycle."""
        return self._rows[min(max(number, 0), len(self._rows) - 1)]


def _facts(plan: ArmPlan) -> dict[str, Fact]:
    rates, accelerations = plan.peak_rates, plan.peak_accelerations
    crossings = plan.crossings
    facts = {
        "time_end": Fact(plan.duration, "s", "duration of the motion"),
        "path_deviation": Fact(plan.path_deviation, "m", "greatest distance from the path"),
        "twist_residual": Fact(plan.twist_residual, "", "greatest entry of J q' - (b v, b² w)"),
        "elbow_sign_changes": Fact(float(len(crossings)), "", "passes through the elbow's"),
        "completes": Fact(float(plan.outcome == "done"), "", "1 if the law gets to the path's end"),
        "peak_rate_arm": Fact(float(rates[:3].max()), "rad/s", "greatest rate of q1 to q3"),
        "peak_rate_wrist": Fact(float(rates[3:].max()), "rad/s", "greatest rate of q4 to q6"),
        "peak_acceleration": Fact(float(accelerations.max()), "rad/s^2", "of any joint"),
    }
    for name, rate in zip(JOINT_NAMES, rates, strict=True):
        facts[f"peak_rate_{name}"] = Fact(float(rate), "rad/s", f"greatest rate of {name}")
    for (name, unit), values in zip(_INDICES, plan.indices.T, strict=True):
        closest = float(np.abs(values).min())
        facts[f"closest_{name}"] = Fact(closest, unit, f"least index of the {name}")
        facts[f"crosses_{name}"] = Fact(
            float(np.any(values[:-1] * values[1:] < 0.0)), "", f"1 if it crosses the {name}'s"
        )
    facts["time_crossing"] = Fact(
        crossings[0] if crossings else math.inf, "s", "first pass through the elbow's"
    )
    region = plan.marks.get("region", ())
    dwell = region[1] - region[0] if len(region) > 1 else math.inf
    facts["dwell_time"] = Fact(dwell, "s", "time in the singular region")
    return facts


class Arm(ServoJoints):
    """The loop's view of the arm.

    Parameters
    ----------
    settings : ArmSettings
        Geometry and limits.
    devices : mapping
        The rig's devices by name.
    period : float
        The loop's period, s.

    Raises
    ------
    ConfigurationError
        The devices do not have each of the six joints exactly once.
    """

    Settings = ArmSettings

    columns = (
        *servo_columns(JOINT_NAMES),
        *(Column(f"reading.hand_{axis}", "m", "hand by the measured joints") for axis in "xyz"),
        *(Column(f"reference.hand_{axis}", "m", "planned hand") for axis in "xyz"),
        *(Column(f"plan.elbow_{axis}", "m", "planned elbow") for axis in "xyz"),
        *(Column(f"plan.wrist_{axis}", "m", "planned wrist centre") for axis in "xyz"),
        Column("plan.speed", "m/s", "of the hand"),
        Column("plan.turn_rate", "rad/s", "of the hand"),
        Column("plan.commanded_speed", "m/s", "what the path asks for"),
        Column("plan.commanded_turn_rate", "rad/s", "what the path asks for"),
        *(
            Column(f"plan.index_{name}", unit or "1", "singularity index")
            for name, unit in _INDICES
        ),
        Column("plan.scale", "1", "b, of the hand's velocity"),
        Column("plan.scale_turn", "1", "b², of the hand's angular velocity"),
        Column("plan.inside", "m", "wrist centre inside the boundary of the workspace"),
        Column("plan.deviation", "m", "planned hand off the path"),
    )

    def __init__(self, settings: ArmSettings, devices: Mapping[str, Any], period: float) -> None:
        geometry = settings.geometry
        super().__init__(
            JointLimits(
                JOINT_NAMES, geometry.position_min, geometry.position_max, geometry.rate_limits
            ),
            settings.limits,
            *self.pick("arm", settings, devices),
            Kinds(ArmState, ArmReference, ArmCommand),
            period,
        )
        self.settings = settings
        self.controller: Any = None
        self.motion: PlannedArmMotion | None = None
        self._arm = dimensions_of(geometry)
        self._followed = 0

    @classmethod
    def assemble(cls, settings: ArmSettings, devices: Mapping[str, Any], period: float) -> "Arm":
        """Pick the devices that the settings name."""
        return cls(settings, devices, period)

    @classmethod
    def model_of(cls, settings: ArmSettings) -> ArmGeometry:
        """Return what the laws are told of the arm."""
        return settings.geometry

    @classmethod
    def plan(
        cls, settings: ArmSettings, reference: Any, controller: Any, period: float
    ) -> PlannedArmMotion:
        """Have the law work out the whole motion; see `Mechanism.plan`."""
        if not isinstance(reference, get_args(ArmPathSettings)):
            raise ValueError("the reference is not one for an arm")
        return PlannedArmMotion(controller.prepare(reference), settings.geometry)

    @classmethod
    def approach(
        cls, start: ArmReference, end: ArmReference, duration: float, t: float
    ) -> ArmReference:
        """Return the minimum-jerk way between two postures at `t`."""
        reference: ArmReference = cls.approach_joints(ArmReference, start, end, duration, t)
        return reference

    def start_limiting(self, state: Any) -> None:
        """See `ServoJoints.start_limiting`."""
        super().start_limiting(state)
        self._followed = 0

    def row(
        self, state: ArmState, reference: ArmReference, command: ArmCommand, applied: ArmCommand
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        planned = self.motion.sample(self._followed) if self.motion is not None else (0.0,) * 20
        if reference.following:
            self._followed += 1
        return (
            *self.joint_row(state, reference, command, applied),
            *forward(self._arm, state.positions).position,
            *planned,
        )
