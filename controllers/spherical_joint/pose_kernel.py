"""What a pose controller works out around its laws: the functions that are compiled.

They take the numbers of a `PoseNumbers`: the object itself in Python, its `KernelMemory` compiled.
"""

from dataclasses import dataclass

from controllers.compiled import PlainNumbers, inlined
from controllers.spherical_joint.ball_friction import slide
from controllers.spherical_joint.exact_wire import WireConstants
from controllers.spherical_joint.forward import SearchConstants, search, step_ahead
from controllers.spherical_joint.geometry import Pair, Quadruple
from controllers.spherical_joint.poses import Rotation, Vector, move_axis, natural_rotation
from controllers.spherical_joint.taut import kept_taut, kept_within, lifted, pair_forces
from controllers.spherical_joint.tension import pose_shares, pose_tensions, without_tilt
from controllers.spherical_joint.wires import natural_motion

Motion = tuple[Quadruple, Quadruple, Quadruple]
Triple = tuple[float, float, float]
Cycle = tuple[
    tuple[Triple, Triple], tuple[Triple, Triple], Pair, Quadruple, Quadruple, Vector, Quadruple
]
"""The fields of a `pose_step.Step`."""
Remembered = tuple[Quadruple, Quadruple, Quadruple, Quadruple]
"""See `remembered`."""

FOUND, NO_POSE, NO_TENSIONS = range(3)
"""Outcomes of a step."""


@dataclass(frozen=True)
class StepSettings(PlainNumbers):
    """The constants of the steps beside the geometry.

    Parameters
    ----------
    area : float
        Of a cylinder, m².
    compliance : float
        Stretch of a wire that the rods make up for, m/N.
    least, lowest, most : float
        Tension that control leaves in a wire, and what setpoints may ask for, N.
    middle : float
        Pressure about which the laws see the force of a pair, Pa.
    decay : float
        By which what the chambers held at the start fades in a cycle.
    ahead : float
        By which the tensions that hold the ring go out early, s.
    ring, wire, slide : float
        Of the friction on the ball, see `ball_friction.slide`.
    """

    area: float
    compliance: float
    least: float
    lowest: float
    most: float
    middle: float
    decay: float
    ahead: float
    ring: float
    wire: float
    slide: float


class PoseNumbers(PlainNumbers):
    """The constants of the steps, and what they remember from cycle to cycle.

    Parameters
    ----------
    settings : StepSettings
        See there.
    wires, regular : WireConstants
        Of the joint, and of one with its anchors exactly across each other if this one's are not.
    searched : SearchConstants
        Of the forward kinematics.
    home : tuple of float
        Lengths of the wires at home, m.
    """

    def __init__(
        self,
        settings: StepSettings,
        wires: WireConstants,
        regular: WireConstants | None,
        searched: SearchConstants,
        home: Quadruple,
    ) -> None:
        self.settings = settings
        self.wires = wires
        self.is_regular = regular is None
        self.regular = regular or wires
        self.searched = searched
        self.home = home
        # Of the search: tan(tilt / 2) of the last pose, and how it goes on.
        self.guess, self.onward = [0.0] * 2, [0.0] * 2
        # Deflections of the friction on the ball: of the ring's seat and of the pairs' wires.
        self.seat, self.slip = [0.0] * 2, [0.0] * 2
        # The `PoseTensions` of the last pose that was worked out, and the shares of the one ahead.
        self.shares, self.first, self.second = [0.0] * 4, [0.0] * 4, [0.0] * 4
        self.shares_ahead = [0.0] * 4
        # Tensions, N: what holds the pose ahead, and what the chambers held at the start.
        self.hold_ahead, self.start = [0.0] * 4, [0.0] * 4

    def reset(self) -> None:
        """Forget the past."""
        for pair in (self.guess, self.onward, self.seat, self.slip):
            pair[:] = [0.0] * 2
        for four in (self.shares, self.first, self.second, self.shares_ahead):
            four[:] = [0.0] * 4
        self.hold_ahead[:] = self.start[:] = [0.0] * 4


@inlined
def before_natural(
    numbers: PoseNumbers,
    axis: Vector,
    velocity: Vector,
    acceleration: Vector,
    rods: Quadruple,
    pressures: Quadruple,
    base: float,
    anew: bool,
    starts: bool,
) -> tuple[int, Cycle]:
    """Do what `before` does, for exact wires under the natural pose."""
    motion = natural_motion(numbers.wires, four(numbers.home), axis, velocity, acceleration)
    return before(
        numbers, motion, axis, velocity, acceleration, rods, pressures, base, anew, starts
    )


@inlined
def before(
    numbers: PoseNumbers,
    motion: Motion,
    axis: Vector,
    velocity: Vector,
    acceleration: Vector,
    rods: Quadruple,
    pressures: Quadruple,
    base: float,
    anew: bool,
    starts: bool,
) -> tuple[int, Cycle]:
    """Return how the step went, and it; see `PoseStep.before`.

    Where no pose explains the wires, what they are is in the place of the residuals.
    """
    settings = numbers.settings
    position, rate, rise = motion
    if anew:
        _balance(numbers, axis, velocity, acceleration)
    shares, shares_ahead = four(numbers.shares), four(numbers.shares_ahead)
    # Shares of a pose that does not exist are NaN, all four. A minimum over both poses could pass
    # over them, because NaN is neither less nor more than any number.
    holds = min(*shares) > 0.0 and min(*shares_ahead) > 0.0
    hold = lifted(_scaled(4.0 * settings.area * base, shares), shares, settings.least)
    ahead = lifted(_scaled(4.0 * settings.area * base, shares_ahead), shares_ahead, settings.least)
    put_four(numbers.hold_ahead, ahead)
    rates = (0.5 * (rate[0] - rate[2]), 0.5 * (rate[3] - rate[1]))
    friction = _slide(numbers, rates, (hold[0] + hold[2], hold[3] + hold[1]))
    pull = _scaled(settings.area, pressures)
    # The rods pull in by what the wires stretch under what they bear.
    borne = spread(_scaled(_total(pull) / _total(hold), hold), friction)
    stretch = _scaled(settings.compliance, borne)
    wanted = _sum(position, stretch)
    settled, found, residuals = _search(numbers, _sum(rods, _scaled(-1.0, stretch)))
    how = NO_TENSIONS
    if holds:  # without tensions no stretch is known, and so no pose
        how = FOUND if settled else NO_POSE
    forces = pair_forces(four(numbers.first), four(numbers.second), pull)
    if starts:
        put_four(numbers.start, _sum(pull, _scaled(-1.0, spread(hold, forces))))
    middle, half = settings.middle, 0.5 / settings.area
    measured = (
        (0.5 * (rods[0] - rods[2]), middle + half * forces[0], middle - half * forces[0]),
        (0.5 * (rods[3] - rods[1]), middle + half * forces[1], middle - half * forces[1]),
    )
    goals = (
        (0.5 * (wanted[0] - wanted[2]), rates[0], 0.5 * (rise[0] - rise[2])),
        (0.5 * (wanted[3] - wanted[1]), rates[1], 0.5 * (rise[3] - rise[1])),
    )
    return how, (measured, goals, friction, wanted, hold, found, residuals)


@inlined
def after(numbers: PoseNumbers, first: float, second: float, shake: float) -> Quadruple:
    """Return the setpoints; see `PoseStep.after`."""
    settings = numbers.settings
    # What holds the ring goes out early, past the laws: it has to be there in time.
    start = four(numbers.start)
    ones, others = four(numbers.first), four(numbers.second)
    wanted = spread(_sum(four(numbers.hold_ahead), start), (first, second))
    taut = kept_taut(ones, others, wanted, settings.least)
    tensions = kept_within(ones, others, taut, settings.least, settings.most)
    put_four(numbers.start, _scaled(settings.decay, start))
    return setpoints(settings, _sum(tensions, _scaled(shake, four(numbers.shares))))


@inlined
def remembered(numbers: PoseNumbers) -> Remembered:
    """Return the last pose's shares and pairs' forces per newton, and the shares of that ahead."""
    return (
        four(numbers.shares),
        four(numbers.first),
        four(numbers.second),
        four(numbers.shares_ahead),
    )


@inlined
def _balance(numbers: PoseNumbers, axis: Vector, velocity: Vector, acceleration: Vector) -> None:
    """Work out what tensions do in a pose, and which will hold the one that follows."""
    shares, first, second = _tensions(numbers, natural_rotation(axis))
    ahead = move_axis(axis, velocity, acceleration, numbers.settings.ahead)
    put_four(numbers.shares, shares)
    put_four(numbers.first, first)
    put_four(numbers.second, second)
    put_four(numbers.shares_ahead, _tensions(numbers, natural_rotation(ahead))[0])


@inlined
def _tensions(numbers: PoseNumbers, rotation: Rotation) -> tuple[Quadruple, Quadruple, Quadruple]:
    """Return what `TensionDistribution.at` does."""
    shares, first, second = pose_tensions(numbers.wires, rotation)
    if not numbers.is_regular:
        shares = without_tilt(pose_shares(numbers.regular, rotation), first, second)
    return shares, first, second


@inlined
def _slide(numbers: PoseNumbers, rates: Pair, tensions: Pair) -> Pair:
    """Return the friction on the ball and remember its deflections; see `ball_friction.slide`."""
    settings = numbers.settings
    seat, slip = two(numbers.seat), two(numbers.slip)
    friction, seat, slip = slide(
        settings.ring, settings.wire, settings.slide, seat, slip, rates, tensions
    )
    put_two(numbers.seat, seat)
    put_two(numbers.slip, slip)
    return friction


@inlined
def _search(numbers: PoseNumbers, shortening: Quadruple) -> tuple[bool, Vector, Quadruple]:
    """Return what `ForwardKinematics.update` does; the shortenings if there is no pose."""
    last, onward = two(numbers.guess), two(numbers.onward)
    guess = (last[0] + onward[0], last[1] + onward[1])
    settled, p, axis, residuals = search(numbers.searched, guess, shortening)
    onward = step_ahead(last, p)
    if not settled:
        p, onward, residuals = (0.0, 0.0), (0.0, 0.0), shortening
    put_two(numbers.guess, p)
    put_two(numbers.onward, onward)
    return settled, axis, residuals


@inlined
def setpoints(settings: StepSettings, tensions: Quadruple) -> Quadruple:
    """Return the pressures (Pa gauge) of tensions (N), within what may be asked for."""
    area, lowest, most = settings.area, settings.lowest, settings.most
    return (
        min(max(tensions[0], lowest), most) / area,
        min(max(tensions[1], lowest), most) / area,
        min(max(tensions[2], lowest), most) / area,
        min(max(tensions[3], lowest), most) / area,
    )


@inlined
def two(values: list[float]) -> Pair:
    """Return two remembered numbers."""
    return values[0], values[1]


@inlined
def four(values: list[float] | Quadruple) -> Quadruple:
    """Return four remembered numbers."""
    return values[0], values[1], values[2], values[3]


@inlined
def put_two(values: list[float], numbers: Pair) -> None:
    """Remember two numbers."""
    values[0], values[1] = numbers


@inlined
def put_four(values: list[float], numbers: Quadruple) -> None:
    """Remember four numbers."""
    values[0], values[1], values[2], values[3] = numbers


@inlined
def _scaled(factor: float, values: Quadruple) -> Quadruple:
    return factor * values[0], factor * values[1], factor * values[2], factor * values[3]


@inlined
def _sum(first: Quadruple, second: Quadruple) -> Quadruple:
    return (
        first[0] + second[0],
        first[1] + second[1],
        first[2] + second[2],
        first[3] + second[3],
    )


@inlined
def _total(values: Quadruple) -> float:
    return values[0] + values[1] + values[2] + values[3]


@inlined
def spread(tensions: Quadruple, forces: Pair) -> Quadruple:
    """Return tensions with the pairs' forces, half on either wire (see `PAIRS`)."""
    first, second = forces
    return (
        tensions[0] + 0.5 * first,
        tensions[1] - 0.5 * second,
        tensions[2] - 0.5 * first,
        tensions[3] + 0.5 * second,
    )
