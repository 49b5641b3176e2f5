"""The loop's view of the crank."""

from collections.abc import Mapping

from crank_rig.crank.references import CrankTurns, TurningCranks
from crank_rig.crank.settings import CrankSettings
from crank_rig.crank.types import AXES, CrankCommand, CrankModel, CrankReference, CrankState
from rig.hal import Column, Controller, Device, LimitExceeded
from rig.mechanisms.servo.axes import AxisLimits, Kinds, ServoAxes, servo_columns
from rig.mechanisms.servo.targets import AxisTargets


class Crank(ServoAxes[CrankSettings, CrankState, CrankReference, CrankCommand]):
    """Two cranks on servo drives; what is common to all servo axes is inherited.

    Parameters
    ----------
    settings : CrankSettings
        Which devices, and which limits.
    devices : mapping
        The rig's devices by name.
    period : float
        The loop's period, s.
    """

    columns = (
        *servo_columns(AXES),
        Column("reading.twist", "rad", "the right crank's lead over the rod's zero"),
    )

    def __init__(
        self, settings: CrankSettings, devices: Mapping[str, Device], period: float
    ) -> None:
        super().__init__(
            self.axis_limits(settings),
            settings.limits,
            *self.pick("crank", settings, devices),
            Kinds(CrankState, CrankReference, CrankCommand),
            period,
        )
        self.settings = settings

    @classmethod
    def assemble(
        cls, settings: CrankSettings, devices: Mapping[str, Device], period: float
    ) -> "Crank":
        """Pick the devices that the settings name."""
        return cls(settings, devices, period)

    @classmethod
    def axis_limits(cls, settings: CrankSettings) -> AxisLimits:
        """Return the two axes and what they may do."""
        reach, speed = settings.reach, settings.max_speed
        return AxisLimits(AXES, (-reach, -reach), (reach, reach), (speed, speed))

    @classmethod
    def targets(cls, settings: CrankSettings, controller: object) -> AxisTargets[CrankReference]:
        """Return where the cranks may be sent by a plan in Python."""
        return AxisTargets(cls.axis_limits(settings), CrankReference)

    @classmethod
    def model_of(cls, settings: CrankSettings) -> CrankModel:
        """Return what the laws are told of the cranks."""
        return CrankModel(settings.rod_zero)

    @classmethod
    def plan(
        cls,
        settings: CrankSettings,
        reference: object,
        controller: Controller[CrankReference, CrankState, CrankCommand],
        period: float,
    ) -> TurningCranks:
        """Return the motion that is asked for, if the cranks may go so far and so fast."""
        if not isinstance(reference, CrankTurns):
            raise ValueError("the reference is not one for a crank")
        if reference.angle > settings.reach:
            raise ValueError(
                f"angle is {reference.angle:g} rad, the cranks may turn {settings.reach:g} rad"
            )
        if max(reference.speeds) > settings.max_speed:
            raise ValueError(
                f"speeds: {max(reference.speeds):g} rad/s is more than the cranks' "
                f"{settings.max_speed:g} rad/s"
            )
        return TurningCranks(reference, settings.rod_zero)

    @classmethod
    def approach(
        cls, start: CrankReference, end: CrankReference, duration: float, t: float
    ) -> CrankReference:
        """Return the smoothest way from rest to rest at `t`."""
        reference: CrankReference = cls.approach_joints(CrankReference, start, end, duration, t)
        return reference

    def check(self, state: CrankState, now: float) -> None:
        """Raise if an axis is not safe, or the rod is about to be overstrained."""
        super().check(state, now)
        twist, most = self._twist(state), self.settings.max_twist
        if abs(twist) > most:
            raise LimitExceeded("twist of the rod", twist, -most, most, "rad")

    def row(
        self,
        state: CrankState,
        reference: CrankReference,
        command: CrankCommand,
        applied: CrankCommand,
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        return (*self.joint_row(state, reference, command, applied), self._twist(state))

    def _twist(self, state: CrankState) -> float:
        left, right = state.positions
        return right - left - self.settings.rod_zero
