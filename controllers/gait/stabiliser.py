"""Balance by what is felt: the waist is moved until the feet are pressed where the plan has it."""

import math
from typing import Final

from controllers.gait.balance import GRAVITY
from controllers.gait.correction_settings import StabiliserSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.kinematics import hip_from_ankle, inverse, waist_rotation
from controllers.gait.plan import GaitPlan
from controllers.gait.sensing import Sensing, weighed_point
from controllers.gait.suspicion import Suspicion
from controllers.gait.types import BalanceSettings, Joints, LegsState

_RATE_SHARE: Final = 0.999
"""Of the joints' greatest rate that a corrected step takes at most."""

_STRAIGHTEST: Final = math.radians(0.5)
"""rad: no correction bends a knee less, unless the plan has it straighter …"""
_STRAIGHT: Final = math.radians(12.0)
"""… and from here on the waist is lowered: a knee turns the faster, the straighter it is."""
_SOFTLY: Final = 0.8e-3
"""Over so much of the leg's length that begins, m, …"""
_SPARED: Final = 0.5
"""… or over this share of what is left of it."""


class Stabiliser:
    """Corrects the posture of each cycle; a pure function of what it was told since `reset`.

    Parameters
    ----------
    settings : StabiliserSettings
        Gains and bounds.
    geometry : LegGeometry
        The legs.
    balance : BalanceSettings
        The margin that the plan keeps.
    period : float
        The loop's, s.
    """

    def __init__(
        self,
        settings: StabiliserSettings,
        geometry: LegGeometry,
        balance: BalanceSettings,
        period: float,
    ) -> None:
        self._settings = settings
        self._geometry = geometry
        self._least_margin = balance.min_margin
        self._period = period
        self._weight = GRAVITY * geometry.masses.total
        self._longest = geometry.distance(_STRAIGHTEST)
        self._long = geometry.distance(_STRAIGHT)
        self._most = _RATE_SHARE * geometry.max_rate * period
        self._limits = geometry.limits
        self._suspicion = Suspicion(self._weight, period)
        self._shift_bound = settings.shift

    def prepare(self, plan: GaitPlan) -> None:
        """Take the plan that is to be corrected."""
        self._targets: list[tuple[float, float]] = [
            (x, y) for x, y in plan.balance.zero_moment.tolist()
        ]
        self._feet = plan.feet.tolist()
        # Sensors that lie must not carry the centre of mass out of the support by themselves.
        spare = max(plan.static_margin - self._least_margin, 0.0)
        self._shift_bound = min(self._settings.shift, spare)
        self.reset()

    def reset(self) -> None:
        """Forget what was felt."""
        self._error = [0.0, 0.0]
        self._wanted = [0.0, 0.0]
        self._shift = [0.0, 0.0]
        self._share = 0.0
        self._last: tuple[Joints, Joints] | None = None
        self._suspicion.reset()

    @property
    def doubt(self) -> str:
        """Why the sensors are not believed any more; empty: they are."""
        return self._suspicion.why

    def correct(self, sample: int, planned: Joints, state: LegsState) -> Joints:
        """Return the joints' angles for this period, rad.

        Parameters
        ----------
        sample : int
            Of the plan.
        planned : tuple of float
            What the law would command, rad.
        state : LegsState
            With what feet and waist feel; without it corrections fade out.
        """
        sensing = state.sensing
        if sensing is not None:
            self._suspicion.see(sensing)
        believed = sensing is not None and not self._suspicion.why
        change = self._period / self._settings.fade
        self._share = min(self._share + change, 1.0) if believed else max(self._share - change, 0.0)
        if believed and sensing is not None:
            self._feel(sample, sensing)
        return self._within(self._moved(planned), planned)

    def _feel(self, sample: int, sensing: Sensing) -> None:
        """Integrate the pressure's error, and move the waist towards what it asks for."""
        settings, period, bound = self._settings, self._period, self._shift_bound
        point = weighed_point(sensing, self._feet[sample], 0.5 * self._weight)
        is_still = max(map(abs, sensing.turning)) < settings.still
        learns = settings.recovery * period if is_still and point is not None else 0.0
        mix = period / (settings.response + period)
        step = settings.shift_rate * period
        for k in (0, 1):
            error = 0.0 if point is None else point[k] - self._targets[sample][k]
            error = min(max(error, -settings.greatest_error), settings.greatest_error)
            self._error[k] += mix * (error - self._error[k])
            wanted = self._wanted[k] - learns * self._error[k]
            self._wanted[k] = min(max(wanted, -bound), bound)  # which is its anti-windup
            move = self._wanted[k] - self._shift[k]
            self._shift[k] += min(max(move, -step), step)

    def _moved(self, planned: Joints) -> Joints:
        """Return a posture whose waist is moved over the feet, and as low as the legs reach."""
        x, y = self._share * self._shift[0], self._share * self._shift[1]
        if not (x or y):
            return planned
        legs = (planned[:6], planned[6:])
        hips, lower = [], 0.0
        for leg in legs:
            hip = hip_from_ankle(self._geometry, leg)  # type: ignore[arg-type]
            far = (hip[0] + x) ** 2 + (hip[1] + y) ** 2
            reach = max(self._long, math.sqrt(hip[0] ** 2 + hip[1] ** 2 + hip[2] ** 2))
            softly = min(_SOFTLY, _SPARED * max(self._longest - reach, 0.0))
            lower = min(lower, -_softened(hip[2] - math.sqrt(reach**2 - far), softly))
            hips.append(hip)
        joints: tuple[float, ...] = ()
        for leg, hip in zip(legs, hips, strict=True):
            turned = waist_rotation(leg)  # type: ignore[arg-type]
            before = inverse(self._geometry, hip, turned)
            after = inverse(self._geometry, (hip[0] + x, hip[1] + y, hip[2] + lower), turned)
            # The difference, so that nothing but the correction is added to the law's own angles.
            joints += tuple([q + b - a for q, a, b in zip(leg, before, after, strict=True)])
        return joints

    def _within(self, joints: Joints, planned: Joints) -> Joints:
        """Return angles that the joints' ranges and rates permit; a plan's own step always is."""
        before, plan_before = self._last or (planned, planned)
        angles = []
        for wanted, own, last, own_last, (low, high) in zip(
            joints, planned, before, plan_before, self._limits, strict=True
        ):
            inside = min(max(wanted, min(low, own)), max(high, own))
            most = max(self._most, abs(own - own_last))
            angles.append(min(max(inside, last - most), last + most))
        corrected = tuple(angles)
        self._last = (corrected, planned)
        return corrected


def _softened(excess: float, softly: float) -> float:
    """Return how much of an excess is made up for, m: little at first, then all but half of softly.

    Parameters
    ----------
    excess : float
        Of a leg's length, m.
    softly : float
        Excess from which on what is more is made up for as a whole, m.
    """
    if excess <= 0.0:
        return 0.0
    return excess - 0.5 * softly if excess >= softly else 0.5 * excess**2 / softly
