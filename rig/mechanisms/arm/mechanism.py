"""A U-R-S arm of six joints on servo drives."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, get_args

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import (
    dimensions_of,
    forward,
    hand_twist,
    singularity_indices,
)
from controllers.arm.law import AnyArmLaw
from controllers.arm.online.commands import ArmTwists
from controllers.arm.pose_path import PosePath
from controllers.arm.trajectories import ArmPathSettings
from controllers.arm.types import AT_REST, ArmCommand, ArmReference, ArmState
from controllers.slowed_law import SlowedLaw
from rig.hal import Device
from rig.hal.columns import Column
from rig.hal.motion import Motion
from rig.mechanisms.arm.dimensions import described
from rig.mechanisms.arm.fact_kinds import INDICES
from rig.mechanisms.arm.live_row import commanded_row
from rig.mechanisms.arm.planned_motion import SETTLING, PlannedArmMotion
from rig.mechanisms.arm.settings import ArmSettings
from rig.mechanisms.arm.simulated import differences
from rig.mechanisms.arm.twists import HeardTwists, KnownTwists
from rig.mechanisms.servo.axes import AxisLimits, Kinds
from rig.mechanisms.servo.columns import servo_columns
from rig.mechanisms.servo.planned import PlannedAxes
from rig.mechanisms.servo.settings import ServoLimits
from rig.mechanisms.servo.targets import AxisTargets

_TWIST = (
    *((f"v{axis}", "m/s") for axis in "xyz"),
    *((f"w{axis}", "rad/s") for axis in "xyz"),
)
"""The hand's velocity and angular velocity, base axes: names and units."""


class Arm(PlannedAxes[ArmSettings, ArmState, ArmReference, ArmCommand]):
    """The loop's view of the arm; parameters are those of `PlannedAxes`."""

    Settings = ArmSettings
    section = "arm"
    kinds = Kinds(ArmState, ArmReference, ArmCommand)
    dimensions = tuple(
        f"geometry.{key}"
        for key in (
            "a1", "a2", "a3", "d6", "base_height", "wrist_sign", "elbow_offset", "shoulder_offset",
            "marker",
        )
    )  # fmt: skip

    columns = (
        *servo_columns(AXIS_NAMES),
        *(Column(f"reading.hand_{axis}", "m", "hand by the measured joints") for axis in "xyz"),
        *(Column(f"reading.twist_{name}", unit, "of the hand, measured") for name, unit in _TWIST),
        *(
            Column(f"reading.index_{name}", unit or "1", "singularity index, measured")
            for name, unit in INDICES
        ),
        *(Column(f"reference.hand_{axis}", "m", "planned hand") for axis in "xyz"),
        *(Column(f"plan.elbow_{axis}", "m", "planned elbow") for axis in "xyz"),
        *(Column(f"plan.wrist_{axis}", "m", "planned wrist centre") for axis in "xyz"),
        *(Column(f"plan.twist_{name}", unit, "planned, of the hand") for name, unit in _TWIST),
        *(Column(f"plan.asked_{name}", unit, "what the path asks for") for name, unit in _TWIST),
        *(Column(f"plan.index_{name}", unit or "1", "singularity index") for name, unit in INDICES),
        Column("plan.scale", "1", "b, of the hand's velocity"),
        Column("plan.scale_turn", "1", "b², of the hand's angular velocity"),
        Column("plan.inside", "m", "wrist centre inside the boundary of the workspace"),
        *(Column(f"plan.path_{axis}", "m", "nearest place of the path") for axis in "xyz"),
    )

    def __init__(self, settings: ArmSettings, devices: Mapping[str, Device], period: float) -> None:
        super().__init__(settings, devices, period)
        geometry = settings.geometry
        self.motion: PlannedArmMotion | None = None
        self._arm = dimensions_of(geometry)
        self.stopping_time = max(geometry.rate_limits) / settings.limits.acceleration + SETTLING

    @classmethod
    def axis_limits(cls, settings: ArmSettings) -> AxisLimits:
        """Return the six joints and what they may do."""
        its = settings.geometry
        return AxisLimits(AXIS_NAMES, its.position_min, its.position_max, its.rate_limits)

    @classmethod
    def geometry_of(cls, settings: ArmSettings) -> ArmGeometry:
        """Return the dimensions that the plant is made with."""
        return settings.geometry

    @classmethod
    def described(cls, settings: ArmSettings) -> tuple[tuple[str, str], ...]:
        """Return what its dimensions come to; see `Mechanism.described`."""
        return described(settings.geometry)

    @classmethod
    def limits_of(cls, settings: ArmSettings) -> ServoLimits:
        """Return the limits; see `Mechanism.limits_of`."""
        return settings.limits

    @classmethod
    def model_of(cls, settings: ArmSettings) -> ArmGeometry:
        """Return what the laws are told of the arm."""
        return settings.geometry

    @classmethod
    def plan(
        cls, settings: ArmSettings, reference: object, controller: Any, period: float
    ) -> Motion[ArmReference]:
        """Have the law work out the whole motion; see `Mechanism.plan`."""
        if isinstance(reference, ArmTwists):
            plan = controller.prepare_twists(reference)
            if plan is None:
                return HeardTwists(reference, settings.geometry, period)
            return KnownTwists(plan, settings.geometry, reference)
        if not isinstance(reference, get_args(ArmPathSettings)):
            raise ValueError("the reference is not one for an arm")
        reference = _in_frames(settings, reference)
        return PlannedArmMotion(controller.prepare(reference), settings.geometry, reference)

    @classmethod
    def plant_unlike(
        cls, settings: ArmSettings, reference: object, plant: object
    ) -> tuple[str, ...]:
        """Say what the simulated arm carries or is made of otherwise; see `Mechanism`."""
        return tuple(differences(settings.geometry, reference, plant))

    @classmethod
    def derated(cls, settings: ArmSettings, effort: float, speed: float) -> ArmSettings:
        """Return the settings with a share of the joints' rates; see `Mechanism.derated`.

        Torque is limited by the drives.
        """
        its = settings.geometry
        q1, q2, q3, q4, q5, q6 = (speed * rate for rate in its.rate_limits)
        return replace(settings, geometry=replace(its, rate_limits=(q1, q2, q3, q4, q5, q6)))

    @classmethod
    def slowed(
        cls,
        settings: ArmSettings,
        reference: object,
        controller: AnyArmLaw,
        period: float,
        share: float,
    ) -> tuple[object, Motion[ArmReference]] | None:
        """Have the law work the motion out for as many more cycles; see `Mechanism.slowed`."""
        if isinstance(reference, ArmTwists):
            raise ValueError("twists are followed as they come, and no more slowly")
        if not isinstance(reference, get_args(ArmPathSettings)):
            return None
        reference = _in_frames(settings, reference)
        law = controller.at_period(share * period)
        plan = law.prepare(reference).stretched(share)
        return SlowedLaw(law, share, ArmCommand), PlannedArmMotion(
            plan, settings.geometry, reference
        )

    @classmethod
    def targets(cls, settings: ArmSettings, controller: object) -> AxisTargets[ArmReference]:
        """Return where the six axes may be sent."""
        return AxisTargets(cls.axis_limits(settings), ArmReference)

    def attach(self, controller: Any, motion: Motion[ArmReference]) -> None:
        """Take the motion if it is one that a law has planned."""
        self.motion = motion if isinstance(motion, PlannedArmMotion) else None

    def row(
        self, state: ArmState, reference: ArmReference, command: ArmCommand, applied: ArmCommand
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        motion, arm, q = self.motion, self._arm, state.positions
        if motion is not None:
            planned = motion.sample(self._followed)
        else:  # twists that are heard: rest on the way to where they begin
            planned = commanded_row(arm, command, reference.twist or AT_REST, self._period)
        if reference.following:
            self._followed += 1
        hand = forward(arm, q).position
        return (
            *self.joint_row(state, reference, command, applied),
            *hand,
            *hand_twist(arm, q, state.velocities, hand),
            *singularity_indices(arm, q),
            *planned,
        )


def _in_frames(settings: ArmSettings, path: ArmPathSettings) -> ArmPathSettings:
    """Return a path that knows the rig's frame which it names."""
    return path.seen_in(settings.frames) if isinstance(path, PosePath) else path
