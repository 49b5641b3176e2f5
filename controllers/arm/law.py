"""What the laws of the arm have in common: one motion, planned whole and then sent out."""

from abc import abstractmethod
from collections.abc import Generator
from typing import Any, ClassVar

from controllers.arm.choice import begun_elsewhere
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.online.braking import periods_to_rest, slowed_to_rest
from controllers.arm.online.commands import ArmTwists
from controllers.arm.online.follower import TwistFollower
from controllers.arm.online.rehearsal import rehearse
from controllers.arm.paths import TurnBack
from controllers.arm.plan import ArmPlan, OutOfRange, Sample, make_plan
from controllers.arm.pose_path import PosePath
from controllers.arm.promises import Promises, TooFast, check_promises
from controllers.arm.slower import slower_path
from controllers.arm.trajectories import ArmPathSettings, make_trajectory
from controllers.arm.trajectory import Trajectory
from controllers.arm.types import AT_REST, ArmCommand, ArmReference, ArmState, Joints
from controllers.base import Chosen, PlanningLaw
from controllers.motion import InfeasibleMotion, LongMotion, check_length

_TRIES = 12
"""So many slower motions are tried until one fits …"""
_CLOSELY = 5
"""… and so many of them no slower than the one before has to be."""
_STRIDE = 1.25
"""At least so much slower are the others: one law's needs come and go with the speed."""
_SLOWEST = 1e9
"""Times as long beyond which no speed is looked for."""
_TRIED = 60_000
"""Cycles of a slower motion beyond which it is not tried: that would take longer than one waits."""
_SHORTEST = 1e-6
"""A path takes the hand so far at least, m or rad, or leaves it where it is."""


class MotionEnd:
    """The end of a motion, which its law fills in.

    Attributes
    ----------
    duration : float
        s.
    outcome : str
        See `ArmPlan`.
    marks : dict
        See `ArmPlan`.
    """

    def __init__(self) -> None:
        self.duration = 0.0
        self.outcome = "done"
        self.marks: dict[str, tuple[float, ...]] = {}


Motion = Generator[Sample, None, None]


def collected(motion: Motion, period: float, longest: float) -> list[Sample]:
    """Return the samples of a motion that takes no longer than is permitted, s.

    Raises
    ------
    LongMotion
        It goes on; what it would have come to is not waited for.
    """
    samples: list[Sample] = []
    for sample in motion:
        check_length(len(samples) * period, longest)
        samples.append(sample)
    return samples


def _check_extent(trajectory: Trajectory) -> None:
    """Raise if a path is too short to be one: rounding would decide where it leads.

    Raises
    ------
    InfeasibleMotion
        With its length and the shortest.
    """
    way, turn = (
        abs(rate) * trajectory.duration for rate in (trajectory.speed, trajectory.turn_rate)
    )
    if max(way, turn) < _SHORTEST and (way or turn):
        said, unit = (f"{way:.3g} m long", "m") if way else (f"a turn by {turn:.3g} rad", "rad")
        raise InfeasibleMotion(f"the path is {said}; less than {_SHORTEST:g} {unit} is no motion.")


class ArmLaw(
    PlanningLaw[Chosen, ArmGeometry, ArmReference, ArmState, ArmCommand, ArmPathSettings, ArmPlan]
):
    """A law that moves the arm along one path.

    `prepare` runs the law through the whole motion, before anything moves; `update` gives what was
    planned, one period per call whatever the clock says: a late cycle is a cycle later, not a
    jump. Nothing is planned in the loop, where that would stop the arm for many periods. The law
    moves the commanded joints; that the measured ones follow is for the drives.
    """

    name: ClassVar[str]
    promises: ClassVar[Promises] = Promises()
    """What every plan of it is held against."""

    def __init__(self, settings: Chosen, model: ArmGeometry, period: float) -> None:
        super().__init__(settings, model, period)
        self.geometry = model
        self.arm = dimensions_of(model)
        self._plan: ArmPlan | None = None
        self._cycle = 0
        self._follower: TwistFollower | None = None

    @abstractmethod
    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period, the first at the start; say in `end` how it ended.

        Raises
        ------
        InfeasibleMotion
            The law cannot do the path.
        """

    def promised(self, trajectory: Trajectory) -> Promises:
        """Return what the law promises on a path."""
        del trajectory
        return self.promises

    def prepare(self, path: ArmPathSettings) -> ArmPlan:
        """Return the whole motion along a path, which `update` then follows.

        Raises
        ------
        InfeasibleMotion
            It cannot be done; the message says by how much.
        """
        try:
            plan = self._within_ranges(path)
        except TooFast as error:
            raise InfeasibleMotion(f"{error}; {self._fitting(path, error)}.") from error
        self._follower, self._plan, self._cycle = None, plan, 0
        return plan

    def _within_ranges(self, path: ArmPathSettings) -> ArmPlan:
        """Return the plan of a path, begun elsewhere where only that keeps the ranges."""
        try:
            return self._planned(path)
        except OutOfRange as error:
            if not isinstance(path, PosePath):
                raise
            return begun_elsewhere(self.arm, path, error, self._planned_elsewhere)

    def _planned_elsewhere(self, path: ArmPathSettings) -> ArmPlan:
        """Return what `_planned` does of a path of which it only matters whether it fits.

        A law that knows the joints before their timing may raise `OutOfRange` as soon as they
        leave their ranges.
        """
        return self._planned(path)

    def _planned(self, path: ArmPathSettings) -> ArmPlan:
        """Return the plan of a path that keeps what is promised.

        Raises
        ------
        InfeasibleMotion
            It cannot be done, `TooFast` if it can more slowly.
        """
        trajectory = make_trajectory(self.arm, path)
        check_length(trajectory.duration, self.longest)
        if not isinstance(path, TurnBack):  # whose own refusals say what is wrong with its start
            _check_extent(trajectory)
        end = MotionEnd()
        samples = collected(self.move(trajectory, end), self.period, self.longest)
        plan = make_plan(
            self.name,
            self.geometry,
            trajectory,
            samples,
            self.period,
            end.duration,
            end.outcome,
            end.marks,
        )
        promises = self.promised(trajectory)
        if isinstance(path, PosePath) and path.torques:
            promises = promises._replace(carried=path.payload)
        check_promises(self.geometry, plan, promises)
        return plan

    def _fitting(self, path: ArmPathSettings, refused: TooFast) -> str:
        """Say at which speed a path would fit, which is tried if it does not take too long.

        What a joint needs at a singularity is not in proportion to the speed: a slower motion may
        have its samples nearer to it.
        """
        trial = self.at_period(self.period)
        trial.longest = min(self.longest, _TRIED * self.period)
        factor = refused.factor
        for tried in range(_TRIES):
            slower = slower_path(path, factor)
            if slower is None or factor > _SLOWEST:
                break
            try:
                trial._within_ranges(slower.path)
            except TooFast as error:
                factor *= 1.001 * max(error.factor, 1.0 if tried < _CLOSELY else _STRIDE)
                refused = error
            except LongMotion as error:
                if refused.is_guess:
                    break
                return self._too_slow(slower.words, error.duration)
            except InfeasibleMotion as error:
                return f"{slower.words} it would be refused, too: {str(error).rstrip('.')}"
            else:
                return f"{slower.words} it would fit"
        return "no speed was found at which it would fit"

    def _too_slow(self, words: str, duration: float) -> str:
        """Say of a speed that it would do, and why it was not tried or does not help."""
        if duration > self.longest:
            return (
                f"{words} it would fit, but take at least {duration:.4g} s, and the longest that "
                f"is permitted is {self.longest:g} s"
            )
        return f"{words} it should fit, which was not tried as it takes at least {duration:.4g} s"

    def follower(
        self, geometry: ArmGeometry, *, through: bool, rest: int | None = None
    ) -> TwistFollower:
        """Return what follows twists that come from outside.

        Parameters
        ----------
        geometry : ArmGeometry
            The arm, with the rates that it may go at: less than its own where `rest` asks for it.
        through : bool
            Whether the elbow may go through its singularity; see `ArmTwists.boundary`.
        rest : int, optional
            Within how many periods the hand has to be able to come to rest; see `ArmTwists.rest`.

        Raises
        ------
        InfeasibleMotion
            The law needs a whole path.
        """
        del geometry, through, rest
        raise InfeasibleMotion(
            f"{self.name} plans whole paths; esc, dls and servo-halt follow twists as they come."
        )

    def prepare_twists(self, twists: ArmTwists) -> ArmPlan | None:
        """Make ready for twists; return what will come of them if they are known beforehand.

        Raises
        ------
        InfeasibleMotion
            The law follows no twists, or they cannot be read or take too long.
        """
        rows = twists.known()
        rest = periods_to_rest(twists, self.period) if rows is None else None
        its = slowed_to_rest(self.geometry, rest, self.period)
        self._follower = self.follower(its, through=twists.boundary == "back", rest=rest)
        self._follower.rest(twists.start)
        if rows is None:
            self._check_start(twists.start)
            return None
        return rehearse(
            self.name, self.geometry, self.period, self._follower, rows, twists.frame, self.longest
        )

    def _check_start(self, start: Joints) -> None:
        """Raise if a joint would start outside its range, from where nobody plans it back."""
        its = self.geometry
        for name, q, low, high in zip(
            AXIS_NAMES, start, its.position_min, its.position_max, strict=True
        ):
            if not low <= q <= high:
                raise InfeasibleMotion(
                    f"{name} would start at {q:.4f} rad, outside its range of {low:.4f} to "
                    f"{high:.4f} rad (reference.start)."
                )

    def reset(self, state: ArmState) -> None:
        """Go back to the beginning of the path."""
        del state  # the motion starts where the path does; the approach leads there
        self._cycle = 0

    def update(self, state: ArmState, reference: ArmReference) -> ArmCommand:
        """Return the command for this period; at the end of the path the arm rests."""
        del state
        if self._follower is not None:
            return self._follow(self._follower, reference)
        plan = self._plan
        if not reference.following or plan is None:
            return ArmCommand(reference.positions, reference.velocities)
        k = self._cycle
        if k == len(plan.t):
            return ArmCommand(tuple(plan.positions[-1].tolist()), AT_REST)
        self._cycle = k + 1
        return ArmCommand(tuple(plan.positions[k].tolist()), tuple(plan.velocities[k].tolist()))

    def _follow(self, follower: TwistFollower, reference: ArmReference) -> ArmCommand:
        """Return the command for a twist; while none is followed, that of the reference."""
        if not reference.following or reference.twist is None:
            follower.rest(reference.positions)
            return ArmCommand(reference.positions, reference.velocities)
        return ArmCommand(*follower.step(reference.twist))


AnyArmLaw = ArmLaw[Any]
"""A law of the arm, whatever its settings."""
