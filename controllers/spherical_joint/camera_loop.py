"""The outer loop: the reference gives way to what the camera sees, slowly and smoothly."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.spherical_joint.marker_estimate import MarkerEstimate
from controllers.spherical_joint.poses import Vector

_ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class CameraLoopSettings:
    """Gain and limits of the correction of the reference.

    Parameters
    ----------
    gain : float
        Share of the difference between encoders and camera that is made up for; 0 leaves the
        camera out.
    bandwidth : float
        With which the correction follows that difference, rad/s. The pairs feel every step of
        it: a correction that jumps with each frame costs more in friction than it gains.
    limit : float
        Greatest correction at the marker, m: a camera that disagrees by more is not followed.
    """

    gain: Annotated[float, Ge(0), Le(1)] = 0.0
    bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(200)] = 8.0
    limit: Annotated[float, Unit("m"), Gt(0)] = 2e-3


class CameraLoop:
    """Follows the bias between encoders and camera by a critically damped filter.

    Parameters
    ----------
    settings : CameraLoopSettings
        Gain, bandwidth and limit.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: CameraLoopSettings, period: float) -> None:
        bandwidth = settings.bandwidth
        decay = math.exp(-bandwidth * period)
        # The exact step of g'' + 2 w g' + w² g = 0 for the gap g to where it goes.
        self._gg = decay * (1.0 + bandwidth * period)
        self._gr = decay * period
        self._rg = -decay * bandwidth * bandwidth * period
        self._rr = decay * (1.0 - bandwidth * period)
        self._gain = settings.gain
        self._limit = settings.limit
        self.reset()

    def reset(self) -> None:
        """Forget the past: no correction."""
        self.offset: Vector = _ZERO
        """By which the marker's reference is moved, m."""
        self.rate: Vector = _ZERO
        """Its rate, m/s."""

    def update(self, marker: MarkerEstimate) -> None:
        """Step by one period towards what an estimate says."""
        if self._gain == 0.0 or marker.camera_age == math.inf:
            return
        size = self._gain * math.hypot(*marker.bias)
        share = self._gain if size <= self._limit else self._gain * self._limit / size
        gg, gr, rg, rr = self._gg, self._gr, self._rg, self._rr
        offsets, rates = [], []
        for offset, rate, bias in zip(self.offset, self.rate, marker.bias, strict=True):
            end = share * bias
            gap = offset - end
            offsets.append(end + gg * gap + gr * rate)
            rates.append(rg * gap + rr * rate)
        self.offset = (offsets[0], offsets[1], offsets[2])
        self.rate = (rates[0], rates[1], rates[2])
