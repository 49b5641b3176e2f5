"""Jumps of a reference that seals hold a pair back from until it is stopped for not following.

A jump farther than `limits.following` is followed only if the law pulls hard enough to break the
seals away, and soon. A law that bears late regulators pulls softly: behind standard seals 5 mm ask
for 11 N, and 12.5 N break them away. What would become of the first jump is tried beforehand on
what the law is told of the pair, with more friction than that.
"""

import copy
import math
from collections import deque
from typing import Final

from controllers.cylinder.law import AnyPairLaw
from controllers.cylinder.types import PairModel, PairReference, PairState

_FRICTION: Final = 1.6
"""Times the friction that the law is told: the most that `rig tune` reckons with. Of 82 drawn pairs
whose jumps bear so much none was stopped; of 56 with standard seals and shorter ones 13 were. E"""
_SOON: Final = 0.75
"""Share of what the alarm waits for: later jumps find in the law what earlier ones left there."""
_RESTING: Final = 0.5
"""The law is at rest for so long before, s."""
_SUBSTEPS: Final = 4
"""Of a regulator in a cycle."""


class _Chamber:
    """The pressure of a chamber: its regulator's, after the dead time for which the air waits."""

    def __init__(self, model: PairModel, period: float) -> None:
        self._model, self._step = model, period / _SUBSTEPS
        self.pressure, self._rate = model.base_pressure, 0.0
        waiting = round(model.air_dead_time / period)
        self._on_the_way = deque([model.base_pressure] * waiting)

    def fill(self, setpoint: float) -> float:
        """Take a cycle's setpoint, and return the pressure after it, Pa gauge."""
        model = self._model
        self._on_the_way.append(min(max(setpoint, model.pressure_min), model.pressure_max))
        wanted, quick = self._on_the_way.popleft(), model.regulator_bandwidth
        damping = 2.0 * model.regulator_damping * quick
        for _ in range(_SUBSTEPS):
            off = wanted - self.pressure
            self._rate += self._step * (quick * quick * off - damping * self._rate)
            self.pressure += self._step * self._rate
        return self.pressure


def followed_after(
    law: AnyPairLaw, jump: float, following: float, most: float, within: float
) -> float | None:
    """Return how long after a jump a pair with more friction is near enough, s; None: not within.

    Parameters
    ----------
    law : PairLaw
        It is not changed.
    jump : float
        Of the reference, m.
    following : float
        So far off is near enough, m.
    most : float
        Force that a pair is permitted, N.
    within : float
        s.
    """
    law, model, period = copy.deepcopy(law), law.model, law.period
    chambers = _Chamber(model, period), _Chamber(model, period)
    base, place, speed = model.base_pressure, 0.0, 0.0
    state = PairState(0.0, 0.0, base, base)
    law.reset(state)
    waits = round(_RESTING / period)
    for cycle in range(waits + math.ceil(within / period)):
        goal = jump if cycle >= waits else 0.0
        asked = law.update(state, PairReference(goal, 0.0, 0.0))
        agonist, antagonist = (one.fill(p) for one, p in zip(chambers, asked, strict=True))
        force = min(max(model.area * (agonist - antagonist), -most), most)
        speed = _sliding(model, speed, force, period)
        place += period * speed
        state = PairState((cycle + 1) * period, place, agonist, antagonist)
        if cycle >= waits and abs(jump - place) <= following:
            return (cycle + 1 - waits) * period
    return None


def _sliding(model: PairModel, speed: float, force: float, period: float) -> float:
    """Return the speed of a pair after a cycle, m/s: seals hold it until a force breaks them."""
    if speed == 0.0 and abs(force) <= _FRICTION * model.breakaway:
        return 0.0
    way = math.copysign(1.0, speed if speed else force)
    dry = _FRICTION * model.coulomb * way
    after = speed + period * (force - dry - model.viscous * speed) / model.mass
    return after if after * way > 0.0 else 0.0


def check_jump(
    law: AnyPairLaw, at: float, jump: float, following: float, most: float, lost: float
) -> None:
    """Refuse a jump of a reference that a pair would be stopped for.

    Parameters
    ----------
    law : PairLaw
        Of the pair.
    at : float
        Time of the jump, s.
    jump : float
        m.
    following, most, lost : float
        ``limits.following`` (m), ``limits.pair_force`` (N), ``alarms.oscillation.lost`` (s).

    Raises
    ------
    ValueError
        The pair would stand, or come too late.
    """
    if followed_after(law, jump, following, most, _SOON * lost) is None:
        raise ValueError(
            f"after {at:.3g} s the reference jumps by {jump * 1e3:.3g} mm, farther than "
            f"limits.following, {following * 1e3:g} mm, and this law pulls too softly for a pair "
            f"with {_FRICTION:g} times the friction that it is told (breakaway "
            f"{law.model.breakaway:.3g} N) to be that near within {_SOON * lost:g} s: it would be "
            f"stopped. Give the step a rise of {lost:g} s or more, or another size."
        )
