"""Where the marker is: encoders at the loop's rate, a camera that is late but sees the ring.

Encoders know nothing of the wires' stretch, of friction on the ball and of dimensions that are a
little off; together that is a slow error, up to some 0.1 mm. A camera sees the marker itself,
but 20 to 50 ms ago. So a sample is compared with what the encoders said in the middle of *its*
exposure, and the difference, a slow bias per axis, is taken off what they say now: nothing has
to be rolled back, and a late frame costs nothing but its age.
"""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from annotated_types import Gt, Le, Unit

from controllers.estimators import bias_gains
from controllers.named_tuples import new_tuple
from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Vector
from controllers.spherical_joint.types import CameraSample

_ZERO = (0.0, 0.0, 0.0)
_GAP = 0.5
"""After so long without a sample the bias starts anew, s."""


@dataclass(frozen=True, slots=True)
class MarkerEstimateSettings:
    """Trust in the camera, and bounds beyond which something is wrong.

    Parameters
    ----------
    frame_period : float
        Usual time between two samples, s.
    camera_noise : float
        Of a sample, standard deviation per axis, m.
    bias_acceleration : float
        How fast the bias may change its rate, standard deviation, m/s²: with friction that turns
        round 1.4e-3 to 4.5e-3 suit 0.1 Hz, 14e-3 to 45e-3 suit 0.5 Hz.
    max_age : float
        Samples older than this are not used, s.
    max_bias : float
        Alarm: encoders and camera differ by more, m.
    max_residual : float
        Alarm: the four wires differ by more from one pose, m. Half a degree of twist shows as
        1 µm at 20 degrees of tilt, a wire that is slack by 1 mm as 0.5 mm.
    """

    frame_period: Annotated[float, Unit("s"), Gt(0)] = 1.0 / 60.0
    camera_noise: Annotated[float, Unit("m"), Gt(0)] = 15e-6
    bias_acceleration: Annotated[float, Unit("m/s^2"), Gt(0)] = 5e-3
    max_age: Annotated[float, Unit("s"), Gt(0), Le(1)] = 0.2
    max_bias: Annotated[float, Unit("m"), Gt(0)] = 2e-3
    max_residual: Annotated[float, Unit("m"), Gt(0)] = 0.5e-3


class MarkerEstimate(NamedTuple):
    """The estimated place of the marker, and what speaks against it.

    Parameters
    ----------
    marker : tuple of float
        Encoders corrected by the camera, m.
    encoder_marker : tuple of float
        Encoders alone, m.
    bias, bias_rate : tuple of float
        Encoders less camera, m, and its rate, m/s.
    residual : float
        How far the wires are from agreeing on a pose, m.
    camera_age : float
        Of the newest sample that was used, s; infinite before the first.
    alarms : tuple of str
        ``residual`` (a wire is slack or an anchor has slipped), ``bias`` (camera and encoders
        disagree), ``late`` (a sample was older than `max_age`); usually empty.
    """

    marker: Vector
    encoder_marker: Vector
    bias: Vector
    bias_rate: Vector
    residual: float
    camera_age: float
    alarms: tuple[str, ...]


class MarkerEstimator:
    """Fuses encoders and camera.

    Parameters
    ----------
    settings : MarkerEstimateSettings
        Trust and alarms.
    geometry : SphericalJointGeometry
        Dimensions.
    period : float
        The loop's period, s.
    """

    def __init__(
        self, settings: MarkerEstimateSettings, geometry: SphericalJointGeometry, period: float
    ) -> None:
        self._settings = settings
        self._height = geometry.marker_height
        self._forward = ForwardKinematics(geometry)
        self._size = math.ceil(settings.max_age / period) + 2
        self.reset()

    def compile(self) -> None:
        """Compile the search for the pose and design the filter, before the first cycle."""
        self._forward.compile()
        self._gains()

    def reset(self) -> None:
        """Forget the past."""
        self._forward.reset()
        self._history: list[tuple[float, Vector]] = [(-math.inf, _ZERO)] * self._size
        self._newest = 0
        self._bias: Vector = _ZERO
        self._rate: Vector = _ZERO
        self._bias_t = -math.inf
        self._seen = -math.inf
        self._late = False

    def update(
        self, t: float, shortening: Quadruple, camera: CameraSample | None = None
    ) -> MarkerEstimate:
        """Take this cycle's readings.

        Parameters
        ----------
        t : float
            Of the encoders' readings, s.
        shortening : tuple of float
            Of the four wires, m.
        camera : CameraSample, optional
            The newest one, whether it is new or not.

        Raises
        ------
        ValueError
            No pose of the ring explains the wires.
        """
        pose = self._forward.update(shortening)
        return self.take(t, pose.axis, pose.residual, camera)

    def take(
        self, t: float, axis: Vector, residual: float, camera: CameraSample | None = None
    ) -> MarkerEstimate:
        """Take what this cycle's readings say.

        Parameters
        ----------
        t : float
            Of the encoders' readings, s.
        axis : tuple of float
            Of the ring, as they say.
        residual : float
            How far they are from agreeing on it, m.
        camera : CameraSample, optional
            The newest one, whether it is new or not.
        """
        height = self._height
        marker = (height * axis[0], height * axis[1], height * axis[2])
        self._newest = newest = (self._newest + 1) % self._size
        self._history[newest] = (t, marker)
        if camera is not None and camera.t > self._seen:
            self._seen = camera.t
            self._take(camera)
        settings = self._settings
        rate = self._rate
        x, y, z = bias = self._bias
        age = t - self._bias_t
        if age > 0.0:
            ahead = age if age < settings.max_age else settings.max_age
            x, y, z = bias = (x + ahead * rate[0], y + ahead * rate[1], z + ahead * rate[2])
        alarms: tuple[str, ...] = ()
        if residual > settings.max_residual:
            alarms += ("residual",)
        if math.hypot(x, y, z) > settings.max_bias:
            alarms += ("bias",)
        if self._late:
            alarms += ("late",)
        fused = (marker[0] - x, marker[1] - y, marker[2] - z)
        return new_tuple(MarkerEstimate, (fused, marker, bias, rate, residual, age, alarms))

    def _gains(self) -> tuple[float, float]:
        """Return the gains on bias and rate; worked out once, which takes a second."""
        settings = self._settings
        return bias_gains(settings.frame_period, settings.camera_noise, settings.bias_acceleration)

    def _take(self, camera: CameraSample) -> None:
        then = self._at(camera.t)
        self._late = then is None
        if then is None:
            return
        seen = camera.marker
        step = camera.t - self._bias_t
        if step > _GAP:
            self._rate = _ZERO
            self._bias = (then[0] - seen[0], then[1] - seen[1], then[2] - seen[2])
            self._bias_t = camera.t
            return
        gain, rate_gain = self._gains()
        biases, rates = [], []
        for bias, rate, one, other in zip(self._bias, self._rate, then, seen, strict=True):
            predicted = bias + step * rate
            error = one - other - predicted
            biases.append(predicted + gain * error)
            rates.append(rate + rate_gain * error)
        self._bias = (biases[0], biases[1], biases[2])
        self._rate = (rates[0], rates[1], rates[2])
        self._bias_t = camera.t

    def _at(self, t: float) -> Vector | None:
        """Return what the encoders said of the marker at a time, m; None if that is too old."""
        history, size = self._history, self._size
        later, after = history[self._newest]
        if t >= later:
            return after
        for back in range(1, size):
            earlier, before = history[self._newest - back]
            if earlier <= t:
                if earlier == -math.inf:
                    return None
                share = (t - earlier) / (later - earlier)
                return (
                    before[0] + share * (after[0] - before[0]),
                    before[1] + share * (after[1] - before[1]),
                    before[2] + share * (after[2] - before[2]),
                )
            later, after = earlier, before
        return None
