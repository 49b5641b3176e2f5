"""What an experiment asks of the spherical joint, as a motion that is possible and permitted."""

from typing import Any

from controllers.spherical_joint.feasibility import FeasibilityCheck, JointBounds, refuse
from controllers.spherical_joint.types import JointReference, Lap
from rig.mechanisms.joint_settings import JointSettings
from rig.runtime.motion import Motion, Segment

_PLAN_STEP = 0.01
"""Poses of a motion are checked at this distance, s."""


class LapMotion:
    """A motion whose references say where in a lap they are."""

    def __init__(self, motion: Any, period: float) -> None:
        self._motion = motion
        self._period = period
        self._repetitions = [
            (start, laps, round(lap / period))
            for start, lap, laps in getattr(motion, "repetitions", ())
            if laps > 1
        ]

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self._motion.duration)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Those of the motion."""
        segments: tuple[Segment, ...] = self._motion.segments
        return segments

    def at(self, t: float) -> JointReference:
        """Return the reference at `t`, with its lap if it is in one."""
        reference: JointReference = self._motion.at(t)
        for start, laps, ticks in self._repetitions:
            tick = round((t - start) / self._period)
            if 0 <= tick < laps * ticks:
                return reference._replace(lap=Lap(tick // ticks, tick % ticks, ticks))
        return reference


def plan_motion(
    settings: JointSettings, reference: Any, controller: Any, period: float
) -> Motion[JointReference]:
    """Return the motion, if every pose of it is possible and permitted.

    Parameters
    ----------
    settings : JointSettings
        Geometry and limits.
    reference : object
        The settings of the experiment's reference.
    controller : object
        The one that will follow: its settings say which wires and poses it believes in.
    period : float
        The loop's period, s.

    Raises
    ------
    ValueError
        A pose is out of reach of wires or rods, slackens a wire or unseats the ring; with the
        instant, the number and the pose.
    """
    motion = LapMotion(reference, period)
    if not isinstance(motion.at(0.0), JointReference):
        raise ValueError("the reference is not one for the spherical joint")
    limits = settings.limits
    check = FeasibilityCheck(
        settings.geometry,
        JointBounds(
            max_tilt=limits.tilt,
            extension=(0.0, settings.stroke),
            home_extension=settings.home,
            least_tension=limits.tension[0],
            most_tension=limits.tension[1],
            total_tension=4.0 * settings.area * settings.base_pressure,
            seat_margin=limits.seat_margin,
            free_wires=limits.free_wires,
        ),
        controller.settings.wire,
        controller.settings.pose,
    )
    refuse(check.check_geometry())
    for number in range(int(motion.duration / _PLAN_STEP) + 1):
        t = number * _PLAN_STEP
        try:
            refuse(check.check_pose(motion.at(t).axis))
        except ValueError as error:
            raise ValueError(f"after {t:.2f} s: {error}") from error
    return motion
