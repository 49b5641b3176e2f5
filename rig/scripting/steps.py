"""What a plan written in Python may ask of a rig, step by step."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

from rig.hal import Device
from rig.hal.motion import Note
from rig.hal.targets import Targets

Target: TypeAlias = float | Sequence[float]
"""One number, or as many as the mechanism asks for; see `Targets.words`."""

_SPACING = 1e-3
"""Between the three places from which the speed of a path is taken, s."""
_CHECK_EVERY = 0.01
"""A path is checked at this distance, s."""
_LEAST_CHECKS = 40


class PlanFailed(Exception):
    """A plan asks for something that cannot be."""


class PlanStep(NamedTuple):
    """A step of a plan.

    Parameters
    ----------
    path : callable
        ``path(t)``: the reference `t` seconds after the step began.
    duration : float
        At most, s.
    what : str
        For the run's events.
    until : callable, optional
        ``until(t, here)``: whether the step is over before its time.
    moves : bool
        Whether the reference changes in it.
    """

    path: Callable[[float], object]
    duration: float
    what: str
    until: Callable[[float, object], bool] | None = None
    moves: bool = False

    def instants(self) -> Iterator[float]:
        """Yield the instants at which its path is checked, its end first."""
        count = max(_LEAST_CHECKS, round(self.duration / _CHECK_EVERY)) if self.moves else 0
        return (self.duration * (1.0 - k / max(count, 1)) for k in range(count + 1))


class Steps:
    """The rig as a plan sees it: ``yield`` what `move` and the like return, and it is done.

    Parameters
    ----------
    targets : Targets
        Where the mechanism may be sent.
    approach : callable
        `Mechanism.approach`: the minimum-jerk way between two rests.
    start : Reference
        Where the plan starts, at rest.
    rehearsing : bool
        Whether this is the rehearsal in simulation.
    """

    def __init__(
        self,
        targets: Targets[object],
        approach: Callable[[object, object, float, float], object],
        start: object,
        *,
        rehearsing: bool,
    ) -> None:
        self.rehearsing = rehearsing
        self.t = 0.0
        """Time since the plan began, s."""
        self.state: object = None
        """What was measured in this cycle: a named tuple of the mechanism."""
        self.notes: list[Note] = []
        self.marks: list[tuple[float, str]] = []
        self.devices: dict[str, Device] = {}
        self.goal = start
        """Where the rig rests once the steps so far are done."""
        self._targets = targets
        self._approach = approach

    # What is yielded --------------------------------------------------------------------

    def move(self, to: Target, duration: float) -> PlanStep:
        """Go to a target smoothly.

        Parameters
        ----------
        to : float or sequence of float
            Cylinder: position, m. Joint: tilt and azimuth, rad. Arm: the six axes, rad.
        duration : float
            s; twice as fast is 1.875 / duration times the distance at its fastest.
        """
        start, goal, approach = self.goal, self._rest(to), self._approach
        duration = _positive(duration, "the duration of a move")
        self.goal = goal
        return PlanStep(
            lambda t: approach(start, goal, duration, t), duration,
            f"move to {_told(to)} in {duration:g} s", moves=True,
        )  # fmt: skip

    def step(self, to: Target, duration: float = 0.0) -> PlanStep:
        """Ask for a target at once, as a step response does, and stay for `duration` seconds."""
        goal = self.goal = self._rest(to)
        return PlanStep(lambda _: goal, _not_negative(duration, "the duration of a step"),
                    f"step to {_told(to)}")  # fmt: skip

    def hold(self, duration: float) -> PlanStep:
        """Stay for `duration` seconds."""
        goal = self.goal
        return PlanStep(lambda _: goal, _not_negative(duration, "the duration of a hold"),
                    f"hold for {duration:g} s")  # fmt: skip

    def settle(self, tolerance: float, within: float = 5.0, still: float = 0.2) -> PlanStep:
        """Wait until the rig has been within `tolerance` of its reference for `still` seconds.

        ``yield`` returns whether it has, `within` seconds.

        Parameters
        ----------
        tolerance : float
            In the unit of a target: m or rad.
        within, still : float
            s.
        """
        goal, distance = self.goal, self._targets.distance
        tolerance = _positive(tolerance, "the tolerance of settle")
        since: list[float] = []

        def has_settled(t: float, here: object) -> bool:
            if distance(here, goal) > tolerance:
                since.clear()
            else:
                since.append(t)
            return bool(since) and t - since[0] >= still

        return PlanStep(
            lambda _: goal, _positive(within, "the time to settle within"),
            f"wait until settled to {tolerance:g}, {within:g} s at most", has_settled,
        )  # fmt: skip

    def follow(self, path: Callable[[float], Target], duration: float) -> PlanStep:
        """Follow a function of time.

        Parameters
        ----------
        path : callable
            ``path(t)``: the target `t` seconds after the step began. It starts where the rig is.
        duration : float
            s.
        """
        duration = _positive(duration, "the duration of a path")
        targets, rest, goal = self._targets, self._rest, self.goal
        gap = targets.distance(rest(path(0.0)), goal)
        if gap > 1e-6:
            raise PlanFailed(f"the path starts {gap:.3g} away from where the rig is: move there")
        self.goal = rest(path(duration))

        def at(t: float) -> object:
            # Both ends are rests: there the speed is taken from one side.
            before, after = max(t - _SPACING, 0.0), min(t + _SPACING, duration)
            around = rest(path(before)), rest(path(t)), rest(path(after))
            return targets.moving(*around, 0.5 * (after - before))

        return PlanStep(at, duration, f"follow a path for {duration:g} s", moves=True)

    # What is done at once ---------------------------------------------------------------

    def mark(self, name: str) -> None:
        """Name what begins here: an event of the run, and a segment that measures may name."""
        self.marks.append((self.t, str(name)))
        self.notes.append(Note("mark", str(name)))

    def reading(self, name: str) -> float:
        """Return a measured number.

        Parameters
        ----------
        name : str
            A field of `state` (``"position"``), one of its numbers (``"pressures.0"``), or a
            device's own column of the log (``"load-cell.force"``).
        """
        first, _, rest = name.partition(".")
        if first in self.devices:
            device = self.devices[first]
            columns = [column.name for column in device.log_columns]
            if name in columns:
                return device.log_values()[columns.index(name)]
        fields: tuple[str, ...] = getattr(self.state, "_fields", ())
        if first in fields:
            value = getattr(self.state, first)
            if not rest:
                return float(value)
            if rest.isdigit() and int(rest) < len(value):
                return float(value[int(rest)])
        known = [*fields, *(c.name for d in self.devices.values() for c in d.log_columns)]
        raise PlanFailed(f"there is no reading {name!r}; there are {', '.join(known)}")

    def _rest(self, target: Target) -> object:
        try:
            numbers = (target,) if isinstance(target, int | float) else target
            return self._targets.rest([float(number) for number in numbers])
        except (TypeError, ValueError) as error:
            raise PlanFailed(f"{target!r} is no target, which is {self._targets.words}") from error


def _positive(value: float, what: str) -> float:
    if not (isinstance(value, int | float) and 0.0 < value < float("inf")):
        raise PlanFailed(f"{what} is {value!r}, and must be a time or distance above 0")
    return float(value)


def _not_negative(value: float, what: str) -> float:
    return 0.0 if value == 0 else _positive(value, what)


def _told(target: Target) -> str:
    if isinstance(target, int | float):
        return f"{target:g}"
    return f"({', '.join(f'{number:g}' for number in target)})"
