"""Breakaway force of a joint's pairs, from tugs (`rig.mechanisms.joint.calibration.tugs`).

The breakaway force is the greatest force of a pair's chambers before the pair moves, smoothed over
21 ms. Three corrections make tugs comparable:

- a ring that leans a little adds to the force: its part is taken off;
- a tug's tensions are some kPa off base pressure: the friction that grows with them is taken off;
- both ways are averaged, so that a zero error of the monitors cancels.

How far the ring leans follows from the rods and from how far the wires stretch. A wire stretches
by its chamber's pull less the seals' friction, which is a tug's force less the ball's friction.

The strokes show what grows with the tensions, but not whether it is the ring's, the wires' or the
seals'. That and the wires' stiffness are part of the interval (a type B evaluation), beside the
scatter of the tugs.

References
----------
JCGM 100:2008, Guide to the expression of uncertainty in measurement, 4.3.7.
JCGM 101:2008, its Supplement 1: the interval is that of drawn sums.
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from controllers.spherical_joint.geometry import PAIRS
from rig.calibration.arrays import Array
from rig.calibration.error_sums import estimate_of_sum
from rig.calibration.estimates import Estimate
from rig.calibration.recording import Recording, Stretch
from rig.config import Profile
from rig.mechanisms.joint.calibration.ball_friction import Belief, axis_with, with_stiffer_wires
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.joint.calibration.tugs import BACK, OTHER, SAME, Tug
from rig.mechanisms.pneumatic.calibration.smoothing import Bump, PairSignals

_MOVING: Final = 5e-3
"""A pair that is faster has broken away, m/s."""

_CREPT: Final = 0.15e-3
"""A pair that is nearer to where it stood has not: its speed is noise, m."""

_BEFORE: Final = 0.1
"""The greatest force comes at most so long before that, s."""


class TugCase(NamedTuple):
    """One possibility for what no tug shows of a joint.

    Parameters
    ----------
    profile : Profile
        Of the joint.
    belief : Belief
        Its friction.
    bound : bool
        Whether it is the bound of equally likely cases, rather than a standard deviation off.
    """

    profile: Profile
    belief: Belief
    bound: bool = False


def forces_of_tugs(cases: Sequence[TugCase], recording: Recording, tugs: Sequence[Tug]) -> Array:
    """Return each tug's breakaway force, N, shape (m, n); NaN where the pair did not move.

    Parameters
    ----------
    cases : sequence of TugCase, length m
        The possibilities that it is computed for.
    recording : Recording
        The tugs' stretches.
    tugs : sequence of Tug, length n
        The tugs.
    """
    forces = np.full((len(cases), len(tugs)), np.nan)
    for k, tug in enumerate(tugs):
        last = _last(cases[0].profile, recording[tug.name], tug)
        if last is not None:
            forces[:, k] = [_taken(case.profile, case.belief, last, tug) for case in cases]
    return forces


def _last(profile: Profile, stretch: Stretch, tug: Tug) -> Stretch | None:
    """Return the last samples before the pair is fast; None if it never is."""
    period = profile.loop.period
    bump, rods = Bump(period), JointPneumatics(profile).rods(stretch)
    one, other = PAIRS[tug.pair]
    position = 0.5 * tug.side * (rods[:, one] - rods[:, other])
    signals = bump.smooth(PairSignals("", position, position, position))
    fast = np.flatnonzero((signals.position > _CREPT) & (signals.velocity > _MOVING))
    if not len(fast):
        return None
    end = int(fast[0]) + bump.width - 1
    rows = slice(max(end - round(_BEFORE / period), 0), end)
    return Stretch({name: column[rows] for name, column in stretch.items()})


def _taken(profile: Profile, belief: Belief, last: Stretch, tug: Tug) -> float:
    """Return the greatest force before the pair moved, N at base pressure and upright."""
    bump, pneumatics, usual = Bump(profile.loop.period), JointPneumatics(profile), belief.usual
    raw, k = pneumatics.signals(last)[tug.pair], -bump.width
    seals = 0.5 * (tug.side * float(raw.force[k]) - belief.alone * float(raw.load[k]))
    taken = np.zeros(4)
    taken[list(PAIRS[tug.pair])] = tug.side * seals * np.array([1.0, -1.0])
    axis = axis_with(profile, last, taken)
    pairs = [bump.smooth(pair) for pair in pneumatics.signals(last, axis)]
    pull = tug.side * pairs[tug.pair].force
    k = int(np.argmax(pull))
    # The ring's friction grows with all four tensions, the pair's own with its two.
    four = sum(float(pair.load[k]) for pair in pairs) - 2.0 * usual
    own = float(pairs[tug.pair].load[k]) - usual
    grown = belief.ring * four + (belief.wound * belief.wire + belief.seals) * own
    return float(pull[k]) - grown


class Breakaways:
    """Least-squares means of the breakaway forces of pairs.

    The fit has a term for each known difference between tugs, so that it counts neither in the mean
    nor as scatter: the side (a zero error of the monitors), the tug before (tension that contacts
    keep), and whether the swing before began with a rise or a fall. The last one need not be
    symmetrical about contacts that keep nothing. Those are taken to lie anywhere between the two.

    Parameters
    ----------
    tugs : sequence of Tug
        The tugs.
    forces : ndarray, shape (n,)
        Their breakaway forces, N; NaN where the pair did not move.
    pairs : sequence of int
        The pairs that are estimated.
    risen : float
        Bound of what a force rises by while the moment is not known, N.
    """

    def __init__(
        self, tugs: Sequence[Tug], forces: Array, pairs: Sequence[int], risen: float = 0.0
    ) -> None:
        self._risen = risen / math.sqrt(3.0)
        self._kinds = [(pair, side) for pair in pairs for side in (1, -1)]
        self._mine = np.isfinite(forces) & np.array([tug.pair in pairs for tug in tugs])
        rows = [self._row(tug) for tug, mine in zip(tugs, self._mine, strict=True) if mine]
        design = np.array(rows).reshape(len(rows), len(self._kinds) + 3)
        self._inverse = np.linalg.pinv(design)
        taken = forces[self._mine]
        found = self._inverse @ taken
        residuals = taken - design @ found
        self._freedom = float(len(rows) - np.linalg.matrix_rank(design)) if rows else 1.0
        self._variance = float(residuals @ residuals) / self._freedom
        self._left = abs(float(found[len(self._kinds)])) / math.sqrt(3.0)

    def _row(self, tug: Tug) -> list[float]:
        # Each of the last three sums to zero over a round's tugs of a kind.
        kind = [float((tug.pair, tug.side) == kind) for kind in self._kinds]
        after = {SAME: (1.0, 0.0), BACK: (0.0, 1.0), OTHER: (-0.5, -0.5)}[tug.after]
        return [*kind, float(tug.swing), *after]

    def _weights(self, pair: int) -> Array:
        kinds = np.array([0.5 * (kind[0] == pair) for kind in self._kinds])
        weights: Array = kinds @ self._inverse[: len(kinds)]
        return weights

    def estimate(
        self,
        pair: int,
        name: str,
        cases: Sequence[TugCase],
        forces: Array,
        model: float = 0.0,
    ) -> Estimate:
        """Return a pair's breakaway with its interval.

        Parameters
        ----------
        pair : int
            Which one.
        name : str
            Of the estimate.
        cases : sequence of TugCase, length m
            What is believed, and what else may be true.
        forces : ndarray, shape (m, n)
            Breakaway forces in each case, N.
        model : float
            Bound of what the model leaves out, as a share of the breakaway.
        """
        weights = self._weights(pair)
        value, *others = (float(weights @ row[self._mine]) for row in forces)
        scatter = math.sqrt(self._variance * float(weights @ weights))
        off = [(case.bound, abs(r - value)) for case, r in zip(cases[1:], others, strict=True)]
        missing = model * abs(value)
        even = [
            self._left,
            missing,
            self._risen,
            *(size / math.sqrt(3.0) for bound, size in off if bound),
        ]
        normal = math.hypot(*(size for bound, size in off if not bound))
        return estimate_of_sum(name, value, "N", scatter, self._freedom, normal, even)


def cases_of(profile: Profile, belief: Belief, growth: float) -> list[TugCase]:
    """Return what is believed, and each bound of it.

    Parameters
    ----------
    profile : Profile
        Of the joint.
    belief : Belief
        What was found of its friction.
    growth : float
        Standard deviation of what grows with the tensions in all, as a share of it.
    """
    # The seals have anything from nothing to twice as much, as where strokes are fitted.
    ball = 1.0 + belief.seals / belief.shared
    more = 1.0 + growth
    # Any share of the ring's within its tolerance is as likely.
    share = profile.mechanism_settings.tolerance.friction
    return [
        TugCase(profile, belief),
        TugCase(profile, belief.with_ring(share), bound=True),
        TugCase(
            profile,
            belief._replace(ring=ball * belief.ring, wire=ball * belief.wire, seals=0.0),
            bound=True,
        ),
        TugCase(
            profile,
            belief._replace(
                ring=more * belief.ring, wire=more * belief.wire, seals=more * belief.seals
            ),
        ),
        TugCase(with_stiffer_wires(profile), belief),
    ]
