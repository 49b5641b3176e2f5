"""What is watched of an antagonistic pair while it moves, and what is a fault."""

from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from controllers.cylinder.types import PairState
from rig.hal import DeviceFault, LimitExceeded, SafetyError
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.pneumatic.alarms.balance import PullBalance
from rig.mechanisms.pneumatic.alarms.bounds import derive_bounds
from rig.mechanisms.pneumatic.alarms.pressures import PressureOff, PressureWatch
from rig.mechanisms.pneumatic.alarms.scatter import explain_scatter
from rig.mechanisms.pneumatic.alarms.tracking import Gone, Shifted, Strayed
from rig.mechanisms.pneumatic.alarms.unheld import explain_unheld
from rig.mechanisms.pneumatic.alarms.work import WorkWatch

CHANNELS = ("agonist", "antagonist")

_SPEED_WINDOW = 0.01
"""The speed is judged over this time, s: over one cycle, an encoder step would look fast."""
_HISTORY = 256
"""So many cycles are remembered, a quarter of a second at 1 kHz …"""
_RECENT = 4
"""… and over so many a wire lets go."""
_SETTLED = 0.1
"""The wires are taut for this time before the rods' agreement is taken for the usual one, s."""
_JUMP = 0.3
"""A rod that runs was at this share of its speed a cycle before; an encoder that jumps was not."""
_LEAST_RUN = 0.1
"""If a wire lets go both rods run in; where one does less than this share, an encoder is wrong."""
_OUT = 20e-6
"""A rod that moves out by less in a cycle (m) turns round within the next one if its wire lets go;
nor is encoder noise that much."""
_AGREED = 0.2
"""The rods agree while their change is below this share of its bound."""

Two = tuple[float, float]


class _Readings(NamedTuple):
    extensions: Two
    pulls: Two
    """Of the two chambers, N."""
    change: float
    """Of the rods' agreement, m."""


class PairWatch:
    """Checks each state of the pair and names what is broken.

    The two rods show the pair's position twice. What they cannot tell is which of them is right
    while both move: a drift or a wrong scale of one encoder looks like that of the other, so the
    message names both. One that stands still or goes against the pull is named alone. While the
    pair rests, a frozen, mirrored or wrongly scaled encoder says what a healthy one says.

    Parameters
    ----------
    settings : CylinderSettings
        Dimensions, limits and alarms.
    regulators : str
        Name of the regulators, for messages.
    encoders : sequence of str
        Names of the agonist's and the antagonist's encoder, for messages.
    """

    def __init__(
        self, settings: CylinderSettings, regulators: str, encoders: Sequence[str]
    ) -> None:
        alarms, friction = settings.alarms, settings.friction
        self._limits = settings.limits
        self._home = settings.home
        self._area = settings.area
        self._encoders = tuple(encoders)
        self._regulators = regulators
        self._give = 0.5 * settings.area / settings.wire_stiffness
        self._taut = 0.5 * friction.breakaway / settings.area
        self._sliding = 0.5 * friction.coulomb
        self._bound = settings.most_disagreement
        self._frozen = alarms.frozen
        self.pressures = PressureWatch(
            derive_bounds(alarms.pressure, settings),
            settings.regulator_response,
            CHANNELS,
            regulators,
            settings.feeder,
        )
        self._work = WorkWatch(
            alarms.swapped, settings.area, friction.coulomb, encoders, CHANNELS, ((0, 1),)
        )
        self._balance = PullBalance(
            settings.area, settings.moving_mass, friction, ((0, 1),), CHANNELS, regulators,
            "the carriage",
        )  # fmt: skip
        self._least_work = alarms.swapped.share * friction.coulomb
        self._history: deque[_Readings] = deque(maxlen=_HISTORY)
        self._speed_from: Two | None = None
        self._slack_at = 0.0
        self._usual: float | None = None
        # What each encoder says, where the other rod was when it first said so, and since when.
        self._still: list[tuple[float, float, float]] = []
        self._step = self._then = 0.0
        self._explained: Exception | None = None

    def restart(self) -> None:
        """Forget where the pair was: a new motion starts."""
        self._speed_from = None
        self._balance.restart()

    def send(self, setpoints: Sequence[float]) -> None:
        """Take the setpoints that the regulators get in this cycle, Pa gauge."""
        self.pressures.send(setpoints)

    def check(self, state: PairState, extensions: Two, now: float) -> None:
        """Raise if something is broken.

        Raises
        ------
        SafetyError
            It names channel or device.
        LimitExceeded
            The rods disagree, or the pair is too fast.
        """
        _, position, agonist, antagonist = state
        self._step, self._then = now - self._then, now
        mismatch = 0.5 * (extensions[0] + extensions[1]) - self._home
        change = self._change(mismatch, agonist, antagonist, now)
        pulls = self._area * agonist, self._area * antagonist
        self._history.append(_Readings(extensions, pulls, change))
        if not self._still:
            self._still = [(extensions[k], extensions[1 - k], now) for k in range(2)]
        self._check_rods(mismatch, change)
        self._check_frozen(extensions, now)
        self.pressures.check((agonist, antagonist), now)
        rods = self._home - extensions[0], self._home - extensions[1]
        self._balance.note(now, rods, (agonist, antagonist))
        self._work.check(rods, (agonist, antagonist), lambda: None)
        self._check_speed(position, now)
        are_taut = self._usual is not None and abs(change) < _AGREED * self._bound
        if are_taut and (cause := self._balance.explain_unseen()):
            scatters = self._explain_scatter()
            raise SafetyError(f"{scatters} ({cause})" if scatters else cause)

    def explain(self, error: Exception) -> Exception:
        """Return an error of a device or limit with the cause that the rest of the pair shows."""
        cause = None
        if not self._history:
            cause = explain_unheld(error, self._encoders, "the carriage")
        elif isinstance(error, DeviceFault) and error.device in self._encoders:
            # This cycle's state was not checked: the device said first that it is wrong.
            k = self._encoders.index(error.device)
            if self._runs(k):
                cause = self._explain_run() or self.pressures.suspicion()
                cause = cause or self._explain_push(k) or self._explain_push(1 - k)
        elif isinstance(error, LimitExceeded) and error is not self._explained:
            cause = self._explain_run() or self._balance.explain() or self.pressures.suspicion()
            cause = cause or self._explain_place(error)
        elif isinstance(error, PressureOff):
            cause = self._explain_scatter()
        return error if cause is None else SafetyError(f"{cause} ({error})")

    def _explain_place(self, error: LimitExceeded) -> str | None:
        """Return why the pair is where it should not be, if that is the error."""
        balance, off = self._balance, error.value
        match error:
            case Strayed():
                return balance.explain_strayed(off, ran=error.ran, lasted=error.lasted)
            case Shifted():
                gone = balance.explain_gone(off, 0) if error.ran else None
                return self._explain_shift() or gone
            case Gone() if balance.rods and (balance.runs() or not balance.drives(off, 0)):
                return balance.explain_gone(off, 0)
        return None

    def _change(self, mismatch: float, agonist: float, antagonist: float, now: float) -> float:
        """Return how much the rods' agreement has changed, m; 0 while the wires may be slack."""
        if min(agonist, antagonist) < self._taut:
            self._slack_at, self._usual = now, None
            return 0.0
        mismatch += self._give * (agonist + antagonist)  # by which the wires' stretch shortens it
        if self._usual is None:
            if now - self._slack_at > _SETTLED:
                self._usual = mismatch
            return 0.0
        return mismatch - self._usual

    def _check_rods(self, mismatch: float, change: float) -> None:
        for what, far, bound in (
            ("mismatch of the two rods", mismatch, self._limits.mismatch),
            ("change of the mismatch of the two rods", change, self._bound),
        ):
            if not -bound <= far <= bound:
                cause = self._explain_mismatch(far)
                self._explained = LimitExceeded(f"{what} ({cause})", far, -bound, bound, "m")
                raise self._explained

    def _check_frozen(self, extensions: Two, now: float) -> None:
        """Raise if one rod says the same while the other moves."""
        for k in range(2):
            here, there = extensions[k], extensions[1 - k]
            said, other, since = self._still[k]
            if here != said:
                self._still[k] = here, there, now
                continue
            way = abs(there - other)
            if way > self._frozen.distance and now - since > self._frozen.time:
                scatters = self._explain_scatter()
                what = f"{scatters}; or {self._encoders[k]}" if scatters else self._encoders[k]
                raise SafetyError(
                    f"{what} is frozen, or the rod of {CHANNELS[k]} is jammed: the "
                    f"other one moved on by {way * 1e3:.2f} mm while it said the same for "
                    f"{now - since:.3f} s [at most {self._frozen.distance * 1e3:g} mm for "
                    f"{self._frozen.time:g} s]"
                )

    def _check_speed(self, position: float, now: float) -> None:
        if self._speed_from is None:
            self._speed_from = (now, position)
            return
        then, was_at = self._speed_from
        if now - then < _SPEED_WINDOW:
            return
        speed = (position - was_at) / (now - then)
        bound = self._limits.speed
        if abs(speed) > bound:
            raise LimitExceeded("speed of the pair", speed, -bound, bound, "m/s")
        self._speed_from = (now, position)

    def _explain_mismatch(self, change: float) -> str:
        """Return why the rods disagree; a wire holds a rod back, and never pushes it out."""
        cause = self._explain_still() or self._explain_run() or self._explain_against()
        cause = cause or self._explain_blow()
        if cause is not None:
            return cause
        slack = "" if change > 0.0 else "a wire is slack, or "
        pulled = min(self._history[-1].pulls) >= self._taut * self._area
        pushed = "; or the carriage was pushed"
        if not pulled:
            pushed += " while its wires were slack"
        wrong = f"{slack}{' or '.join(self._encoders)} drifts or has a wrong scale"
        return f"{wrong}, or wires are softer than the profile says{pushed}"

    def _explain_scatter(self) -> str | None:
        """Return which encoder scatters: beside it the other one seems to stand."""
        return explain_scatter(self._encoders, self._balance.rods)

    def _explain_still(self) -> str | None:
        """Return which encoder has said the same while the other one moved, or why its rod did."""
        here = self._history[-1].extensions
        for k in range(2):
            said, other, _ = self._still[k]
            if here[k] == said and abs(here[1 - k] - other) > self._bound:
                if self._history[-1].pulls[k] > self._sliding:
                    return self._explain_scatter() or f"{self._encoders[k]} is frozen"
                return (
                    f"the rod of {CHANNELS[k]} stays behind, as its chamber is empty: the carriage "
                    "was pushed or struck"
                )
        return None

    def _explain_run(self) -> str | None:
        """Return which wire let go, if the rods have just begun to run in."""
        if len(self._history) <= 2 * _RECENT:
            return None
        before, then, now = (
            self._history[k].extensions for k in (-1 - 2 * _RECENT, -1 - _RECENT, -1)
        )
        ways = [2.0 * then[k] - now[k] - before[k] for k in range(2)]
        least = _JUMP * self._limits.speed * self._step * 2.0
        if max(ways) < least or min(ways) < _LEAST_RUN * max(ways):
            return None
        # By its own chamber's pull and its friction: the one that has the least to move.
        pulls = self._history[-1].pulls
        forces = [max(pulls[k] - self._sliding * self._drag(k), 1.0) for k in range(2)]
        k = max(range(2), key=lambda k: ways[k] / forces[k])
        return f"the wire of {CHANNELS[k]} is slack or cut: its rod runs in"

    def _drag(self, k: int) -> float:
        """Return friction against a rod's pull of late over what sliding takes: 1 … -1.

        A rod that a wire drew out is braked by its friction as well, until it turns round.
        """
        late = [each.extensions[k] for each in self._history][-1 - _RECENT :]
        out = sum(after - before > _OUT for before, after in pairwise(late))
        return 1.0 - 2.0 * out / _RECENT

    def _explain_push(self, k: int) -> str | None:
        """Return that somebody pushed, if a rod is pulled out and the other one runs in.

        Chambers pull rods in, and so does a wire that lets go. The other one may be slower: its
        wire is slack, as a push is faster than the chamber behind it.
        """
        now, then = self._history[-1].extensions, self._history[-2].extensions
        out, other = now[k] - then[k], now[1 - k] - then[1 - k]
        if out <= 0.0 or -other < _LEAST_RUN * out:
            return None
        return f"the carriage was pushed or struck: it pulls the rod of {CHANNELS[k]} out"

    def _explain_blow(self) -> str | None:
        """Return that somebody pushed, if one rod runs out cycle after cycle and the other in.

        A wire does not pass that on at once.
        """
        late = [each.extensions for each in self._history][-_RECENT:]
        for k in range(2):
            goes_on = len(late) == _RECENT and all(
                before[k] < after[k] and before[1 - k] > after[1 - k]
                for before, after in pairwise(late)
            )
            if goes_on and self._runs(k):
                return self._explain_push(k)
        return None

    def _explain_shift(self) -> str | None:
        """Return which chamber fills more slowly than the other, if that can move the pair."""
        pulls = self._history[-1].pulls
        k = pulls.index(min(pulls))
        if pulls[1 - k] - pulls[k] < self._sliding:
            return None
        slow, quick = (f"{1e-3 * pulls[i] / self._area:.0f} kPa" for i in (k, 1 - k))
        return (
            f"{self._regulators}: the regulator of {CHANNELS[k]} is stuck, slow or off: its "
            f"chamber has {slow} while both fill, and that of {CHANNELS[1 - k]} {quick}"
        )

    def drives(self, number: int, off: float) -> bool:
        """Return whether the pressures pull the pair to where it is off its reference, m."""
        return self._balance.drives(off, number)

    def explain_held(self) -> str | None:
        """Return why a pair sticks whose pressures should move it; None: they need not."""
        return self._balance.explain(sticks=True)

    def _explain_against(self) -> str | None:
        """Return which encoder alone goes against the pull since the two disagree."""
        work, way = [0.0, 0.0], [0.0, 0.0]
        after = self._history[-1]
        for before in list(self._history)[-2::-1]:
            pull = after.pulls[0] - after.pulls[1]
            for k, sign in enumerate((-1.0, 1.0)):
                moved = sign * (after.extensions[k] - before.extensions[k])
                work[k] += pull * moved
                way[k] += abs(moved)
            after = before
            if abs(before.change) < _AGREED * self._bound:
                break
        for k in range(2):
            if work[k] < -self._least_work * way[k] and work[1 - k] > self._least_work * way[1 - k]:
                return f"{self._encoders[k]} is mirrored or drifts: it goes against the pull"
        return None

    def _runs(self, k: int) -> bool:
        """Return whether a rod was about as fast as permitted in the last checked cycle."""
        late = [each.extensions[k] for each in self._history][-2:]
        if len(late) < 2:  # the first readings of all are wrong
            return False
        return abs(late[1] - late[0]) > _JUMP * self._limits.speed * self._step
