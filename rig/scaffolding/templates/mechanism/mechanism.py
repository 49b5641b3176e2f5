"""The loop's view of the mechanism: what it measures, what it may do, when it has to stop."""

from collections.abc import Mapping

from rig.hal import Controller, Device
from rig.mechanisms.servo.axes import AxisLimits, Kinds, ServoAxes
from rig.mechanisms.servo.columns import servo_columns
from rig.mechanisms.servo.targets import AxisTargets
from rig.scaffolding.templates.mechanism.references import MyRigTurns, Turning
from rig.scaffolding.templates.mechanism.settings import MyRigSettings
from rig.scaffolding.templates.mechanism.types import (
    AXES,
    MyRigCommand,
    MyRigModel,
    MyRigReference,
    MyRigState,
)


class MyRig(ServoAxes[MyRigSettings, MyRigState, MyRigReference, MyRigCommand]):
    """An axis on a servo drive: limits, alarms and the safe stop are those of all servo axes.

    An alarm of its own is a `check` that calls the inherited one and raises
    `rig.hal.LimitExceeded`; a column of its own is one more in `columns` and in `row`.

    Parameters
    ----------
    settings : MyRigSettings
        Which devices, and which limits.
    devices : mapping
        The rig's devices by name.
    period : float
        The loop's period, s.
    """

    columns = servo_columns(AXES)

    def __init__(
        self, settings: MyRigSettings, devices: Mapping[str, Device], period: float
    ) -> None:
        super().__init__(
            self.axis_limits(settings),
            settings.limits,
            *self.pick("my-rig", settings, devices),
            Kinds(MyRigState, MyRigReference, MyRigCommand),
            period,
        )
        self.settings = settings

    @classmethod
    def assemble(
        cls, settings: MyRigSettings, devices: Mapping[str, Device], period: float
    ) -> "MyRig":
        """Pick the devices that the settings name."""
        return cls(settings, devices, period)

    @classmethod
    def axis_limits(cls, settings: MyRigSettings) -> AxisLimits:
        """Return the axes and what they may do."""
        count, reach, speed = len(AXES), settings.reach, settings.max_speed
        return AxisLimits(AXES, (-reach,) * count, (reach,) * count, (speed,) * count)

    @classmethod
    def targets(cls, settings: MyRigSettings, controller: object) -> AxisTargets[MyRigReference]:
        """Return where a plan in Python may send the axis."""
        return AxisTargets(cls.axis_limits(settings), MyRigReference)

    @classmethod
    def model_of(cls, settings: MyRigSettings) -> MyRigModel:
        """Return what the laws are told."""
        return MyRigModel()

    @classmethod
    def plan(
        cls,
        settings: MyRigSettings,
        reference: object,
        controller: Controller[MyRigReference, MyRigState, MyRigCommand],
        period: float,
    ) -> Turning:
        """Return the motion that is asked for; refuse one that the axis may not do."""
        if not isinstance(reference, MyRigTurns):
            raise ValueError("the reference is not one for my-rig")
        if reference.angle > settings.reach:
            raise ValueError(
                f"angle is {reference.angle:g} rad, the axis may turn {settings.reach:g} rad"
            )
        motion = Turning(reference)
        if motion.fastest > settings.max_speed:
            raise ValueError(
                f"the axis would turn at {motion.fastest:.3g} rad/s, more than max_speed, "
                f"{settings.max_speed:g} rad/s; a longer rise is slower"
            )
        return motion

    @classmethod
    def approach(
        cls, start: MyRigReference, end: MyRigReference, duration: float, t: float
    ) -> MyRigReference:
        """Return the smoothest way from rest to rest at `t`."""
        reference: MyRigReference = cls.approach_joints(MyRigReference, start, end, duration, t)
        return reference

    def row(
        self,
        state: MyRigState,
        reference: MyRigReference,
        command: MyRigCommand,
        applied: MyRigCommand,
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        return self.joint_row(state, reference, command, applied)
