"""What is watched of the spherical joint while it moves, and what is a fault."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import Quadruple
from controllers.spherical_joint.poses import Vector, tilt_of
from controllers.spherical_joint.types import CameraSample, JointState
from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.base import Margin
from rig.mechanisms.joint_columns import CHANNELS
from rig.mechanisms.joint_diagnosis import explain_disagreement, explain_residual
from rig.mechanisms.joint_settings import JointSettings

_SPEED_WINDOW = 0.01
"""Speeds are judged over this time, s: over one cycle, an encoder step would look fast."""
_POSE_EVERY = 4
"""The pose is worked out for the checks every so many cycles: faults last longer."""


class _Pose(NamedTuple):
    """What the checks know of the joint: its axis and how well the wires agree."""

    axis: Vector
    residual: float


class JointWatch:
    """Checks each state of the joint: speed of the rods, agreement of wires and camera, tilt.

    Parameters
    ----------
    settings : JointSettings
        Geometry and limits.
    encoders : sequence of str
        Names of the encoders of ch1 … ch4, for messages.
    camera : str, optional
        Name of the camera, for messages.
    """

    def __init__(
        self, settings: JointSettings, encoders: Sequence[str], camera: str | None
    ) -> None:
        self._settings = settings
        self._limits = settings.limits
        self._encoders = tuple(encoders)
        self._camera = camera
        self._kinematics = ForwardKinematics(settings.geometry)
        self._diagnosis = ForwardKinematics(settings.geometry)
        self._give = settings.area / settings.wire_stiffness
        self._pose = _Pose((0.0, 0.0, 1.0), 0.0)
        self._cycle = 0
        self._speed_from: tuple[float, Quadruple] | None = None
        self._agreed: Quadruple = (0.0,) * 4
        self._agreed_at = self._seen_alike_at = -math.inf

    def restart(self) -> None:
        """Forget where the rods were: a new motion starts."""
        self._speed_from = None

    def axis_of(self, state: JointState) -> Vector:
        """Return the axis that the rods show; the last one known if they fit no pose."""
        try:
            return self._kinematics.update(self._unstretched(state)).axis
        except ValueError:
            return self._pose.axis

    def check(self, state: JointState, now: float) -> None:
        """Raise if the state is not safe.

        Raises
        ------
        SafetyError
            A reading is not a number.
        LimitExceeded
            A rod is too fast, the tilt too great, or wires and camera disagree for longer than
            the grace; with the likeliest cause.
        """
        if not math.isfinite(sum(state.rods) + sum(state.pressures)):
            raise SafetyError(f"a reading is not a number: {state}")
        self._check_speed(state.rods, now)
        self._cycle += 1
        if self._cycle % _POSE_EVERY == 0:
            self._check_pose(state, now)
            if state.camera is not None:
                self._check_camera(state.camera, now)

    def margins(self) -> tuple[Margin, ...]:
        """Return how far each quantity that is watched is from its limit."""
        limits = self._limits
        tilt = tilt_of(self._pose.axis)
        return (
            Margin("tilt", 1.0 - tilt / (limits.tilt + limits.tilt_excess)),
            Margin("wire agreement", 1.0 - self._pose.residual / limits.residual),
        )

    def _check_speed(self, rods: Quadruple, now: float) -> None:
        if self._speed_from is None:
            self._speed_from = (now, rods)
            return
        then, before = self._speed_from
        if now - then < _SPEED_WINDOW:
            return
        bound = self._limits.speed
        for name, rod, was in zip(CHANNELS, rods, before, strict=True):
            speed = (rod - was) / (now - then)
            if abs(speed) > bound:
                raise LimitExceeded(f"speed of the rod of {name}", speed, -bound, bound, "m/s")
        self._speed_from = (now, rods)

    def _check_pose(self, state: JointState, now: float) -> None:
        rods = self._unstretched(state)
        limits = self._limits
        try:
            found = self._kinematics.update(rods)
            self._pose = _Pose(found.axis, found.residual)
        except ValueError:
            self._pose = _Pose(self._pose.axis, math.inf)
        if self._pose.residual <= limits.residual:
            if self._pose.residual <= 0.5 * limits.residual:
                self._agreed = rods
            self._agreed_at = now
        elif now - self._agreed_at > limits.grace:
            moved = tuple([rod - was for rod, was in zip(rods, self._agreed, strict=True)])
            cause = explain_residual(self._diagnosis, rods, moved, self._encoders)  # type: ignore[arg-type]
            raise LimitExceeded(
                f"disagreement of the four wires about the pose ({cause})",
                self._pose.residual, 0.0, limits.residual, "m",
            )  # fmt: skip
        tilt, bound = tilt_of(self._pose.axis), limits.tilt + limits.tilt_excess
        if tilt > bound:
            raise LimitExceeded("tilt of the ring", tilt, 0.0, bound, "rad")

    def _check_camera(self, sample: CameraSample, now: float) -> None:
        """Compare the camera with the encoders, which have moved on since its exposure."""
        marker = self._settings.geometry.marker(self._pose.axis)
        bound = self._limits.disagreement + (now - sample.t) * self._marker_speed()
        if math.dist(marker, sample.marker) <= bound:
            self._seen_alike_at = now
        elif now - max(self._seen_alike_at, self._agreed_at - 1.0) > self._limits.grace:
            cause = explain_disagreement(marker, sample.marker, bound)
            raise LimitExceeded(
                f"{self._camera}: distance of the marker from where the encoders put it ({cause})",
                math.dist(marker, sample.marker), 0.0, bound, "m",
            )  # fmt: skip

    def _marker_speed(self) -> float:
        """Return a bound on how fast the marker moves, m/s: as fast as the limit of the rods."""
        geometry = self._settings.geometry
        return self._limits.speed * geometry.marker_height / geometry.ball_radius

    def _unstretched(self, state: JointState) -> Quadruple:
        """Return the rods less what the wires stretch under the measured pressures."""
        give = self._give
        first, second, third, fourth = (
            rod - give * pressure for rod, pressure in zip(state.rods, state.pressures, strict=True)
        )
        return first, second, third, fourth
