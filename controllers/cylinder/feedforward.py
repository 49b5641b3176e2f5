"""The force that a desired motion of a pair takes: inertia and friction."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Unit

from controllers.compiled import PlainNumbers, inlined
from controllers.cylinder.types import PairModel
from controllers.friction import PreslidingFriction, SmoothFriction

_turn_round = inlined(PreslidingFriction.update)
_follow = inlined(SmoothFriction.force)

_LEAST_SPEED = 0.5e-3
"""Below this desired speed (m/s) a pair may stick, and the integral says nothing of sliding."""
_NEAR = 0.5e-3
"""Within this distance of its reference (m) a pair is loaded towards it; from afar, as after a
step, friction that is fed forward would only make it overshoot."""
_LEAST_SCALE, _MOST_SCALE = 0.25, 3.0
"""Bounds of the learnt friction over the model's."""


@dataclass(frozen=True, slots=True)
class FeedforwardSettings:
    """Share of the modelled friction that is fed forward, and the way it turns round.

    Parameters
    ----------
    friction : str
        ``smooth``: Coulomb friction, rounded over `rounding`; ``stribeck``: with the rise to
        breakaway; ``presliding``: with memory, turning over `distance`.
    gain : float
        Share of the model's friction; below 1 where more would overcompensate a weak unit.
    rounding : float
        Velocity over which the sign is rounded, m/s (`smooth`, `stribeck`).
    distance : float
        Motion over which friction turns round, m (`presliding`); somewhat less than the 20 to
        30 µm of the contacts, because the regulators come after it.
    learning_rate : float
        How fast the share of friction that the integral holds is moved into the feedforward
        while the pair slides, 1/s: after a reversal it is then on the right side at once,
        whatever the unit's friction is. 0 keeps the model's friction.
    error_rate : float
        Weight of the position error in the velocity that friction is computed for, rad/s. A pair
        that sticks short of its reference is then loaded towards it within some 10 ms; the
        integral alone takes a second to reverse the friction after a slip past the reference,
        and slips once more while the pair should hold.
    """

    friction: Literal["smooth", "stribeck", "presliding"] = "presliding"
    gain: Annotated[float, Ge(0), Le(2)] = 1.0
    rounding: Annotated[float, Unit("m/s"), Gt(0)] = 1e-3
    distance: Annotated[float, Unit("m"), Gt(0)] = 9e-6
    learning_rate: Annotated[float, Unit("1/s"), Ge(0), Le(50)] = 3.0
    error_rate: Annotated[float, Unit("rad/s"), Ge(0), Le(100)] = 0.0


class Feedforward(PlainNumbers):
    """Inertia and friction of the desired motion.

    Parameters
    ----------
    settings : FeedforwardSettings
        Shares and roundings.
    model : PairModel
        Mass and friction.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: FeedforwardSettings, model: PairModel, period: float) -> None:
        gain = settings.gain
        coulomb = gain * model.coulomb
        self._mass = model.mass
        self._sliding = 0.9 * coulomb
        self._learning_step = settings.learning_rate * period
        self._error_rate = settings.error_rate
        self._remembers = settings.friction == "presliding"
        self._memory = PreslidingFriction(coulomb, settings.distance, model.viscous, period)
        self._curve = SmoothFriction(
            coulomb,
            gain * model.breakaway if settings.friction == "stribeck" else coulomb,
            model.stribeck_velocity,
            model.viscous,
            settings.rounding,
        )
        self._nominal = 0.0
        self._speed = 0.0
        self.scale = 1.0
        """Friction of this unit over the model's, as learnt."""

    def reset(self) -> None:
        """Forget which way the pair was asked to move, and what was learnt."""
        self._nominal = self._speed = 0.0
        self.scale = 1.0
        self._memory.reset()

    def update(self, velocity: float, acceleration: float, error: float) -> float:
        """Return the force (N) for a desired motion (m/s, m/s²), given the position error (m)."""
        self._speed = abs(velocity)
        if -_NEAR < error < _NEAR:
            velocity += self._error_rate * error
        if self._remembers:
            nominal = _turn_round(self._memory, velocity)
        else:
            nominal = _follow(self._curve, velocity)
        self._nominal = nominal
        return self._mass * acceleration + self.scale * nominal

    def learn(self, integral: float) -> float:
        """Take over what an integral (N) holds against friction, and return that share, N.

        Called after `update`. The sum of integral and feedforward does not change, so nothing is
        felt before the next reversal. Only a pair that is asked to slide teaches.
        """
        nominal, before = self._nominal, self.scale
        if self._speed < _LEAST_SPEED or abs(nominal) < self._sliding:
            return 0.0
        scale = before + self._learning_step * integral / nominal
        if scale < _LEAST_SCALE:
            scale = _LEAST_SCALE
        elif scale > _MOST_SCALE:
            scale = _MOST_SCALE
        self.scale = scale
        return (scale - before) * nominal
