"""What an experiment asks of the spherical joint, as a motion that is possible and permitted."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from controllers.spherical_joint.feasibility import FeasibilityCheck, refuse
from controllers.spherical_joint.poses import PoseConvention
from controllers.spherical_joint.types import JointReference, Lap
from controllers.spherical_joint.wires import WireKind
from rig.hal.motion import Fact, Motion, Segment
from rig.mechanisms.joint.reach import JointReach, PoseFacts, bounds_of
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.reported import check_measured

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

ALL = "all"
"""Name of the segment that is the whole motion."""
_PLAN_STEP = 0.01
"""Poses of a motion are checked at this distance, s."""
_TELL_EVERY = 5
"""Of these so many are told of in the log: what is told changes slowly."""


class Repetition(NamedTuple):
    """A stretch that a motion repeats.

    Parameters
    ----------
    start : float
        When its first lap begins, s.
    lap : float
        How long a lap takes, s.
    laps : int
        How many there are.
    """

    start: float
    lap: float
    laps: int


class JointDrawing(Motion[JointReference]):
    """Base of the references of the joint."""

    @property
    def repetitions(self) -> Sequence[Repetition]:
        """Laps that are alike, from which a controller may learn; default: none."""
        return ()


class PosedMotion(Motion[JointReference]):
    """A motion of whose poses something is known beforehand."""

    @property
    def pose(self) -> tuple[float, float, float]:
        """What is known of the pose that was asked for last, see `PoseFacts`."""
        raise NotImplementedError


class Beliefs(Protocol):
    """The wires and the pose with which a law of the joint computes its references."""

    wire: WireKind
    pose: PoseConvention


class BelievingController(Protocol):
    """A controller of the joint whose settings say what it believes in."""

    @property
    def settings(self) -> Beliefs:
        """Of the profile."""


class JointMotion(PosedMotion):
    """A motion whose references say where in a lap they are, with what is known of its poses.

    Parameters
    ----------
    motion : JointDrawing
        The settings of the experiment's reference.
    period : float
        The loop's period, s.
    """

    def __init__(self, motion: JointDrawing, period: float) -> None:
        self._motion = motion
        self._period = period
        self._repetitions = [
            (start, laps, round(lap / period))
            for start, lap, laps in motion.repetitions
            if laps > 1
        ]
        self._poses: Sequence[PoseFacts] = ()
        self._place = 0
        self.facts: Mapping[str, Fact] = {}
        """What is known of the joint beforehand."""

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self._motion.duration)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The whole of it, ``"all"``, and those of the motion."""
        return (Segment(ALL, 0.0, self.duration), *self._motion.segments)

    def at(self, t: float) -> JointReference:
        """Return the reference at `t`, with its lap if it is in one."""
        self._place = int(t / (_PLAN_STEP * _TELL_EVERY))
        reference = self._motion.at(t)
        for start, laps, ticks in self._repetitions:
            tick = round((t - start) / self._period)
            if 0 <= tick < laps * ticks:
                axis, velocity, acceleration, _, base, push = reference
                lap = _new(Lap, (tick // ticks, tick % ticks, ticks))
                return _new(JointReference, (axis, velocity, acceleration, lap, base, push))
        return reference

    @property
    def pose(self) -> PoseFacts:
        """What was known beforehand of the pose that was asked for last."""
        return self._poses[min(self._place, len(self._poses) - 1)]

    def plan(self, settings: JointSettings, check: FeasibilityCheck) -> None:
        """Look at every pose, and how fast it is passed.

        Raises
        ------
        ValueError
            One is not possible or not permitted, or a rod would be too fast.
        """
        reach = JointReach(settings)
        poses = []
        # Whichever way the axis turns, a wire that lies within 45° of it follows.
        leverage = settings.geometry.ball_radius / math.sqrt(2.0)
        for number in range(int(self.duration / _PLAN_STEP) + 1):
            t = number * _PLAN_STEP
            axis, velocity, *_ = self.at(t)
            if (speed := leverage * math.hypot(*velocity)) > settings.limits.speed:
                raise ValueError(
                    f"after {t:.2f} s: a rod moves at {speed:.3g} m/s or faster, limits.speed is "
                    f"{settings.limits.speed:g} m/s"
                )
            try:
                refuse(check.check_pose(axis))
            except ValueError as error:
                raise ValueError(f"after {t:.2f} s: {error}") from error
            if number % _TELL_EVERY == 0:
                poses.append(reach.at(axis))
        self._poses = poses
        self._place = 0
        self.facts = reach.facts()


def plan_motion(
    settings: JointSettings, reference: object, controller: BelievingController, period: float
) -> JointMotion:
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
    if not isinstance(reference, JointDrawing):
        raise ValueError("the reference is not one for the spherical joint")
    motion = JointMotion(reference, period)
    check = checker(settings, controller)
    refuse(check.check_geometry())
    motion.plan(settings, check)
    check_measured(motion.segments, period)
    return motion


def checker(settings: JointSettings, controller: BelievingController) -> FeasibilityCheck:
    """Return the check of poses for the wires and poses that a controller believes in."""
    its = controller.settings
    return FeasibilityCheck(settings.geometry, bounds_of(settings), its.wire, its.pose)
