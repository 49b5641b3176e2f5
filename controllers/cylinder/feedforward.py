"""The force that a desired motion of a pair takes: inertia and friction."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.types import PairModel, PairReference
from controllers.friction import PreslidingFriction, SmoothFriction


@dataclass(frozen=True, slots=True)
class FeedforwardSettings:
    """What share of the modelled friction is fed forward, and how it turns round.

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
        Motion over which friction turns round, m (`presliding`). The contacts of the plant of
        PAPER-joint, section 3, need 20 to 30 µm each.
    error_rate : float
        Weight of the position error in the velocity that friction is computed for, rad/s: it
        helps to break loose towards the reference.
    """

    friction: Literal["smooth", "stribeck", "presliding"] = "presliding"
    gain: Annotated[float, Ge(0), Le(2)] = 0.9
    rounding: Annotated[float, Unit("m/s"), Gt(0)] = 1e-3
    distance: Annotated[float, Unit("m"), Gt(0)] = 40e-6
    error_rate: Annotated[float, Unit("rad/s"), Ge(0), Le(100)] = 0.0


class Feedforward:
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
        self._mass = model.mass
        self._error_rate = settings.error_rate
        self._memory: PreslidingFriction | None = None
        gain = settings.gain
        if settings.friction == "presliding":
            self._memory = PreslidingFriction(
                gain * model.coulomb, settings.distance, model.viscous, period
            )
            self._friction = self._memory.update
        else:
            top = model.breakaway if settings.friction == "stribeck" else model.coulomb
            self._friction = SmoothFriction(
                gain * model.coulomb,
                gain * top,
                model.stribeck_velocity,
                model.viscous,
                settings.rounding,
            ).force

    def reset(self) -> None:
        """Forget which way the pair was asked to move."""
        if self._memory is not None:
            self._memory.reset()

    def update(self, reference: PairReference, error: float) -> float:
        """Return the force (N) for a reference, given the position error (m)."""
        velocity = reference.velocity + self._error_rate * error
        return self._mass * reference.acceleration + self._friction(velocity)
