"""Twists that come from outside, as the loop follows them: known beforehand, or as they come."""

import math
from collections.abc import Mapping, Sequence

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.on_direction.numbers import Six
from controllers.arm.online.commands import FASTEST, ArmTwists, Heard
from controllers.arm.online.rehearsal import asked_in_base, share_of, twist_within
from controllers.arm.plan import ArmPlan
from controllers.arm.types import AT_REST, ArmReference
from rig.hal import Device, SafetyError
from rig.hal.motion import Fact, Motion, Note, Segment
from rig.mechanisms.arm.planned_motion import SETTLING, PlannedArmMotion
from rig.mechanisms.arm.twist_facts import facts_of_twists
from rig.mechanisms.arm.twist_remarks import remarks_on_rest, remarks_on_standing

_NUMBERS = 6
_AWAY = 0.1
"""Who has not been heard for so long may have let go of the sticks, s: asked to begin anew."""
_EDGE = 1e-9
"""s: instants of cycles are sums of periods."""


class KnownTwists(PlannedArmMotion):
    """Twists that a law has gone through beforehand."""

    def __init__(self, plan: ArmPlan, geometry: ArmGeometry, asked: ArmTwists) -> None:
        super().__init__(plan, geometry, asked)
        self.remarks = (*self.remarks, *remarks_on_standing(plan, geometry))
        end, *twist = (asked.known() or [(0.0,) * 7])[-1]
        if any(twist):
            note = f"at {end:g} s: the last row says when, and its own twist is not followed"
            self.remarks = (*self.remarks, Note("ends", note))

    def at(self, t: float) -> ArmReference:
        """Return what the arm should do at `t`, and what it is asked for."""
        reference = super().at(t)
        if not reference.following:
            return reference
        k = min(round(t / self.plan.period), len(self.plan.t) - 1)  # the last asks for rest
        if k == 0:  # where the plan begins, and not where an approach is a cycle before its end
            return reference
        return reference._replace(twist=tuple(self.plan.command[k].tolist()))

    @classmethod
    def facts_from(cls, plan: ArmPlan, geometry: ArmGeometry, asked: object) -> dict[str, Fact]:
        """Return what is known of it beforehand."""
        assert isinstance(asked, ArmTwists)
        return facts_of_twists(plan, geometry, asked)


class HeardTwists(Motion[ArmReference]):
    """Twists as they are heard; who says nothing stops the hand.

    From `ArmTwists.silence` on the hand brakes as hard as its joints can. Who is heard again
    within 0.1 s of the last word was only late, and goes on. Whoever comes later has to ask for
    rest first: what was asked for long ago must not move the hand.

    Parameters
    ----------
    twists : ArmTwists
        Who is listened to.
    geometry : ArmGeometry
        The arm.
    period : float
        Of the cycle, s.
    """

    watches = True

    def __init__(self, twists: ArmTwists, geometry: ArmGeometry, period: float) -> None:
        self._twists, self._geometry, self._arm = twists, geometry, dimensions_of(geometry)
        self.remarks = remarks_on_rest(twists, geometry, period)
        self._before: tuple[float, Six] | None = None
        self.real_time = twists.real_time
        self._ear: Heard | None = None
        self._asked = AT_REST
        self._heard = 0.0
        self._silent = self._late = False
        self._at_rest = ArmReference(twists.start, AT_REST, False)

    @property
    def duration(self) -> float:
        """How long is listened, s."""
        return self._twists.duration + SETTLING

    @property
    def segments(self) -> tuple[Segment, ...]:
        """All of it."""
        return (Segment("all", 0.0, self.duration),)

    @property
    def foreseen(self) -> Motion[ArmReference]:
        """Nothing: the arm where it starts."""
        return _Unheard(self._at_rest, self.duration)

    def attach(self, devices: Mapping[str, Device]) -> None:
        """Begin to listen."""
        del devices
        self._ear = self._twists.listen()

    def at(self, t: float) -> ArmReference:
        """Return what is asked for now; right at the start and after the end the arm rests."""
        following = self._at_rest._replace(following=True, twist=self._asked)
        return following if t > 0.0 else self._at_rest

    def see(self, t: float, state: object, here: object) -> Sequence[Note]:
        """Ask for the twist of this cycle."""
        assert isinstance(here, ArmReference)
        ahead = self._half_way(t, here.positions)
        if t >= self._twists.duration:
            self._asked = AT_REST
            if self._ear is not None:
                self._ear.leave()
                self._ear = None
            return ()
        told = None if self._ear is None else self._ear.twist(t)
        if told is not None:
            return self._take(t, told, here, ahead)
        since = t - self._heard
        if since >= self._twists.silence - _EDGE:
            self._asked = AT_REST
        if since < _AWAY - _EDGE or self._silent:
            return ()
        self._silent = True
        return (
            Note(
                "silence",
                f"no twist has been heard for {1e3 * since:.0f} ms: the hand brakes from "
                f"{1e3 * self._twists.silence:.0f} ms on, and goes on after a twist of zero",
            ),
        )

    def _half_way(self, t: float, positions: Six) -> float:
        """Return for how long the tool will have done its twist in the middle of this cycle, s.

        As `asked_in_base` wants it for the tool's axes; it goes on as in the cycle before.
        """
        before, self._before = self._before, (t, positions)
        if self._twists.frame == "base" or before is None or t <= before[0]:
            return 0.0
        period = t - before[0]
        q1, q2, q3, q4, q5, q6 = (
            (now - then) / period for now, then in zip(positions, before[1], strict=True)
        )
        done = twist_within(self._arm, positions, (q1, q2, q3, q4, q5, q6), period)
        return 0.5 * period * share_of(self._asked, done)

    def _take(
        self, t: float, told: Sequence[float], here: ArmReference, ahead: float
    ) -> Sequence[Note]:
        try:
            vx, vy, vz, wx, wy, wz = (float(value) for value in told)
        except (TypeError, ValueError) as error:
            raise SafetyError(f"{self._name} returned {told!r}, not {_NUMBERS} numbers") from error
        twist = (vx, vy, vz, wx, wy, wz)
        if not all(math.isfinite(value) for value in twist):
            raise SafetyError(f"{self._name} asks for {twist}, which are not all numbers")
        if max(map(abs, twist)) > FASTEST:
            raise SafetyError(
                f"{self._name} asks for {max(twist, key=abs):g} m/s or rad/s; no arm is faster "
                f"than {FASTEST:g}"
            )
        gap, self._heard = t - self._heard, t
        if self._silent:
            if any(twist):
                return ()
            self._silent = False
            return (Note("twist", "a twist of zero has been heard: the hand follows again"),)
        frame = self._twists.frame
        self._asked = asked_in_base(self._geometry, here.positions, twist, frame, ahead)
        if gap < self._twists.silence - _EDGE or self._late or not any(twist):
            return ()
        self._late = True  # said once: a slow source is late with every word
        return (
            Note(
                "late",
                f"a twist came {1e3 * gap:.0f} ms after the last: from "
                f"{1e3 * self._twists.silence:.0f} ms on (reference.silence) the hand brakes",
            ),
        )

    @property
    def _name(self) -> str:
        return f"{type(self._twists).__name__}.twist()"


class _Unheard(Motion[ArmReference]):
    """The motion of twists that nobody has asked for yet: it stays where it starts."""

    def __init__(self, start: ArmReference, duration: float) -> None:
        self._start, self._duration = start, duration

    @property
    def duration(self) -> float:
        return self._duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        return (Segment("all", 0.0, self._duration),)

    def at(self, t: float) -> ArmReference:
        del t
        return self._start
