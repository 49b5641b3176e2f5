"""Tell what is wrong when the four rods do not agree on a pose of the ring."""

import itertools
import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Vector
from rig.hal import SafetyError
from rig.mechanisms.joint.alarms.runs import RodRuns
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm

_HISTORY = 256
"""So many checks are remembered, a second at 1 kHz."""
_SUDDEN = 2
"""Checks within which a wire lets go; a ring that is driven takes longer for the same way."""
_EXPLAINED = 0.5
"""An explanation counts if it leaves less than this share of the residual."""
_SWAPPED = 0.35
"""Likewise for two rods that stand for each other; stretch and friction are left."""
_LEAST_TRAVEL = 0.5e-3
"""At home (m) the order of the rods does not show."""
_LEAST_RESIDUAL = 0.25e-3
"""Nor does it while the rods disagree by less (m) than friction and stretch make them."""
_RUNS = 0.1
"""A rod that is faster than this (m/s) goes where no loop sends it …"""
_PUSHED = ", or the ring was pushed or struck"
"""… and a wire or encoder moves its own rod alone."""
_AT_REST = 0.05
"""A rod below this speed (m/s) is pulling on something again."""
_CLEARLY = 0.5
"""A rod let go if the others fit a pose so much better without it than without another one, which
leaves more than `_LEAST_RESIDUAL`: of 110 cut wires 0.4 at most, but near upright."""
_END = 1e-3
"""A rod is at the end of its cylinder from here on, m."""
_LEAST_GRACE = 0.2
"""Share of the grace that rods have however far apart they are: one bad sample is no fault."""
_ROUNDS = 60
"""For moving one rod to where the other three put it; a handful is the rule."""

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

HOME: Vector = (0.0, 0.0, 1.0)


class _Readings(NamedTuple):
    t: float
    rods: Quadruple
    pressures: Quadruple


class WireLimits(NamedTuple):
    """The joint as the watch is told of it.

    Parameters
    ----------
    residual : float
        How far the rods may be from agreeing, m.
    grace : float
        For how long they may be further, s; for half as long when they are twice as far.
    home, stroke : float
        Extension of the rods at home and at most, m.
    least_pull : float
        Below this a chamber may be too weak to move its rod, Pa gauge.
    """

    residual: float
    grace: float
    home: float
    stroke: float
    least_pull: float


class WireWatch:
    """Follows the pose that the rods agree on, and says who is wrong when they do not.

    Attributes
    ----------
    axis : tuple of float
        Of the ring, as the rods say.
    residual : float
        How far they are from agreeing, m; infinite if no pose explains them.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions.
    limits : WireLimits
        See there.
    frozen : FrozenAlarm
        When an encoder is frozen.
    encoders, channels : sequence of str
        Names in order, for messages.
    """

    def __init__(
        self,
        geometry: SphericalJointGeometry,
        limits: WireLimits,
        frozen: FrozenAlarm,
        encoders: Sequence[str],
        channels: Sequence[str],
    ) -> None:
        self.axis = HOME
        self.residual = 0.0
        self._kinematics = ForwardKinematics(geometry)
        self._diagnosis = ForwardKinematics(geometry)
        self._limits = limits
        self._frozen = frozen
        self._encoders = tuple(encoders)
        self._channels = tuple(channels)
        self._history: deque[_Readings] = deque(maxlen=_HISTORY)
        self._runs = RodRuns(limits.least_pull)
        self._agreed_at: float | None = None
        self._rods: Quadruple | None = None
        self._changed_at: list[float]
        self._residual_then: list[float]
        self._small_at: list[float]

    def compile(self) -> None:
        """Make the searches for a pose fast, which takes a second where nothing is kept of it."""
        self._kinematics.compile()
        self._diagnosis.compile()

    def check(
        self, rods: Quadruple, unstretched: Quadruple, pressures: Quadruple, now: float
    ) -> None:
        """Take readings, every few cycles, and raise if they cannot be true together.

        Parameters
        ----------
        rods, unstretched : tuple of float
            Shortening of each wire as measured, and less what the wire stretches, m.
        pressures : tuple of float
            Pa gauge.
        now : float
            s.

        Raises
        ------
        SafetyError
            It names encoder or wire, with the number and its bound.
        """
        self._history.append(_new(_Readings, (now, rods, pressures)))
        try:
            pose = self._kinematics.update(unstretched)
        except ValueError:
            self.residual = math.inf
        else:
            self.axis, self.residual = pose.axis, pose.residual
            self._check_frozen(rods, pose.residuals, now)
        residual, limits = self.residual, self._limits
        if residual <= limits.residual or self._agreed_at is None:
            self._agreed_at = now
            return
        # The further the rods are apart, the sooner: a loop that is closed over an encoder that
        # counts backwards has thrown the ring before a fixed time is over.
        share = max(limits.residual / residual, _LEAST_GRACE)
        if now - self._agreed_at > share * limits.grace:
            cause = self._explain(rods, unstretched, pressures)
            raise SafetyError(
                f"{cause} [the four wires disagree about the pose by "
                f"{residual * 1e3:.2f} mm for {now - self._agreed_at:.3f} s, at most "
                f"{limits.residual * 1e3:g} mm for {limits.grace:g} s, here for "
                f"{share * limits.grace:.3g} s]"
            )

    def follow(self, rods: Quadruple, now: float) -> None:
        """Take the rods of a cycle, whether it is checked or not."""
        self._runs.follow(rods, now)

    def axis_of(self, unstretched: Quadruple) -> Vector:
        """Return the axis that rods show; the last one known if they fit no pose."""
        self._diagnosis.reset()
        try:
            return self._diagnosis.update(unstretched).axis
        except ValueError:
            return self.axis

    def suspicion(
        self, rods: Quadruple, unstretched: Quadruple, pressures: Quadruple
    ) -> str | None:
        """Return which rod does not agree with the others, before that has lasted; else None.

        Where its chamber cannot pull, its wire may be slack because of that. Parameters as `check`.
        """
        residual = self._residual_of(unstretched)
        if not self._history or residual <= _EXPLAINED * self._limits.residual:
            return None
        rest, k = min((self._without(unstretched, k)[0], k) for k in range(4))
        if rest >= _EXPLAINED * residual or pressures[k] < self._limits.least_pull:
            return None
        return self._explain(rods, unstretched, pressures)

    def explain_run(self, unstretched: Quadruple, pressures: Quadruple, k: int) -> str | None:
        """Return why a rod runs too fast, if its wire is why.

        Parameters
        ----------
        unstretched, pressures : tuple of float
            As for `check`.
        k : int
            Which rod, 0 … 3; or the opposite one let go and this one only follows.
        """
        if self.agree(unstretched):
            return None
        both = (k, (k + 2) % 4)
        offs = {i: self._without(unstretched, i) for i in both}
        found = self._who_let_go(both, {i: rest for i, (rest, _) in offs.items()}, pressures)
        off = offs[found[0]][1]
        if not off > 0.0:
            return None
        ahead = "far" if math.isinf(off) else f"{off * 1e3:.2f} mm"
        return (
            f"the wire of {self._names_of(found)} is slack or cut, or its anchor slips: its rod "
            f"runs in, {ahead} ahead of where the other three put it"
        )

    def agree(self, unstretched: Quadruple) -> bool:
        """Return whether rods that run still agree.

        Where they do not it has just begun: they are about to disagree by more. While somebody
        finds out what the limit is to be, it is wide, and friction and stretch are less.
        """
        least = min(_EXPLAINED * self._limits.residual, _LEAST_RESIDUAL)
        return self._residual_of(unstretched) <= least

    def explain_swap(self, unstretched: Quadruple) -> str | None:
        """Return which encoders are swapped if that explains the rods, and they are far off.

        Opposite ones never do: the mirrored pose fits as well.
        """
        residual = self._residual_of(unstretched)
        if residual < _LEAST_RESIDUAL or max(map(abs, unstretched)) < _LEAST_TRAVEL:
            return None
        found = []
        for one, other in itertools.combinations(range(4), 2):
            order = list(range(4))
            order[one], order[other] = other, one
            rods = tuple(unstretched[k] for k in order)
            if self._residual_of(rods) < _SWAPPED * residual:  # type: ignore[arg-type]
                found.append((self._work(order), one, other))
        if not found:
            return None
        _, one, other = max(found)  # two fit, and one of them would move against its pull
        return f"{self._encoders[one]} and {self._encoders[other]} are swapped"

    def _check_frozen(self, rods: Quadruple, residuals: Quadruple, now: float) -> None:
        """Raise if one count stays while what the others say of it moves on.

        A wrong rod spreads half of its error to its own residual: two are free for four rods.
        """
        before, self._rods = self._rods, rods
        if before is None:
            self._changed_at, self._small_at = [now for _ in rods], [now for _ in rods]
            self._residual_then = list(residuals)
            return
        distance = self._frozen.distance
        for k in range(4):
            if rods[k] != before[k]:
                self._changed_at[k] = self._small_at[k] = now
                self._residual_then[k] = residuals[k]
                continue
            drift = 2.0 * abs(residuals[k] - self._residual_then[k])
            if drift < 0.25 * distance:
                self._small_at[k] = now
            elif drift > distance:
                if self._is_sudden(now - self._small_at[k]):
                    self._residual_then[k] = residuals[k]  # another rod moved at once, not this
                elif now - self._changed_at[k] > self._frozen.time:
                    raise SafetyError(
                        f"{self._encoders[k]} is frozen, or the rod of {self._channels[k]} is "
                        f"jammed: the other three moved on by {drift * 1e3:.2f} mm while it said "
                        f"the same for {now - self._changed_at[k]:.3f} s [at most "
                        f"{distance * 1e3:g} mm for {self._frozen.time:g} s]"
                    )

    def _is_sudden(self, took: float) -> bool:
        return took < (_SUDDEN + 0.5) * (self._history[-1].t - self._history[-2].t)

    def _explain(self, rods: Quadruple, unstretched: Quadruple, pressures: Quadruple) -> str:
        swapped = self.explain_swap(unstretched)
        if swapped is not None:
            return swapped
        residual = self._residual_of(unstretched)
        offs = [self._without(unstretched, k) for k in range(4)]
        suspects = [k for k in range(4) if offs[k][0] < _EXPLAINED * residual]
        if not suspects:
            return "more than one wire is slack, or the ring is twisted"
        k = min(suspects, key=lambda k: offs[k][0])
        off = offs[k][1]
        if off < 0.0:
            which = " or ".join(f"the wire of {self._channels[k]}" for k in suspects)
            encoders = " or ".join(self._encoders[k] for k in suspects)
            caught = f"{which} is caught, or {encoders} is off, by {-off * 1e3:.2f} mm"
            if max(pressures) < self._limits.least_pull:
                return f"{caught}, or the ring was pushed while its wires were slack"
            others = (abs(self._speed(i)) for i in range(4) if i not in suspects)
            return f"{caught}{_PUSHED}" if max(others, default=0.0) > _RUNS else caught
        found = self._who_let_go(suspects, {k: offs[k][0] for k in suspects}, pressures)
        if len(found) > 1:
            which = self._names_of(found)
            return (
                f"the wire of {which} is slack, or softer than the profile says, or its anchor "
                f"slips, by {off * 1e3:.2f} mm"
            )
        k = found[0]
        return self._explain_wire(k, offs[k][1], rods[k], pressures[k])

    def _explain_wire(self, k: int, off: float, rod: float, pressure: float) -> str:
        name, limits = self._channels[k], self._limits
        extension = limits.home - rod
        if not _END < extension < limits.stroke - _END:
            cut = f"the wire of {name} is cut or has come off: its rod is at its end"
            seen = [reading.rods[k] for reading in self._history]
            if max(seen) - min(seen) < _END:  # nobody saw it run there
                return f"{cut}, or {self._encoders[k]} is wrong: it has not moved"
            return cut
        if abs(self._speed(k)) > _AT_REST or pressure < limits.least_pull:
            return f"the wire of {name} is slack or cut, by {off * 1e3:.2f} mm"
        return (
            f"the anchor of {name} has slipped, or its wire was slack, by {off * 1e3:.2f} mm; "
            "it is taut again"
        )

    def _work(self, order: Sequence[int]) -> float:
        """Return what the pressures did in the history, J/m², were the rods in another order."""
        return sum(
            sum(after.pressures[k] * (after.rods[i] - before.rods[i]) for k, i in enumerate(order))
            for before, after in itertools.pairwise(self._history)
        )

    def _speed(self, k: int) -> float:
        """Return the speed of a rod since the last check, m/s; inwards is positive."""
        if len(self._history) < 2:
            return 0.0
        return _speed_between(self._history[-2], self._history[-1], k)

    def _who_let_go(
        self, suspects: Sequence[int], rests: Mapping[int, float], pressures: Quadruple
    ) -> tuple[int, ...]:
        """Return which of some rods that run in has lost its wire; several if nothing tells.

        Opposite ones are alike near upright in what is off. There it is the one that gained more
        speed for what its chamber pulls: it moves itself alone.

        Parameters
        ----------
        suspects : sequence of int
            The rods.
        rests : mapping
            What is left of the residual without each of them, m.
        pressures : tuple of float
            Pa gauge.
        """
        most = max(_LEAST_RESIDUAL, min(rests.values()) / _CLEARLY)
        alike = tuple(k for k in sorted(suspects) if rests[k] <= most)
        if len(alike) == 1:
            return alike
        leader = self._runs.leader(alike, pressures)
        return alike if leader is None else (leader,)

    def _names_of(self, rods: Sequence[int]) -> str:
        return " or ".join(self._channels[k] for k in rods)

    def _residual_of(self, rods: Quadruple) -> float:
        self._diagnosis.reset()
        try:
            return self._diagnosis.update(rods).residual
        except ValueError:
            return math.inf

    def _without(self, rods: Quadruple, left_out: int) -> tuple[float, float]:
        """Return the residual that three rods have, and how far the fourth is off their pose, m.

        The fourth is moved to where the others put it, half of its error in each round.
        """
        adapted = list(rods)
        for _ in range(_ROUNDS):
            self._diagnosis.reset()
            try:
                residuals = self._diagnosis.update((*adapted,)).residuals  # type: ignore[arg-type]
            except ValueError:
                return math.inf, math.inf
            adapted[left_out] -= 2.0 * residuals[left_out]
            if abs(residuals[left_out]) < 1e-7:
                break
        rest = math.sqrt(0.5 * sum(r * r for k, r in enumerate(residuals) if k != left_out))
        return rest, rods[left_out] - adapted[left_out]


def _speed_between(before: _Readings, after: _Readings, k: int) -> float:
    """Return the speed of a rod, m/s; inwards is positive."""
    return (after.rods[k] - before.rods[k]) / (after.t - before.t)
