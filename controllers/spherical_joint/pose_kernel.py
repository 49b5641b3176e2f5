"""What a pose controller works out around its laws: the functions that are compiled.

They work on two flat arrays of numbers: constants, and what is remembered from cycle to cycle.
Arrays cross from Python to compiled code at once, nested tuples number by number.
"""

from typing import Any

from controllers.compiled import inlined
from controllers.spherical_joint.ball_friction import slide
from controllers.spherical_joint.exact_wire import Vectors, WireConstants
from controllers.spherical_joint.forward import Wires, search, step_ahead
from controllers.spherical_joint.geometry import Quadruple
from controllers.spherical_joint.poses import Rotation, Vector, move_axis, natural_rotation
from controllers.spherical_joint.taut import kept_taut, lifted
from controllers.spherical_joint.tension import pose_shares, pose_tensions, without_tilt
from controllers.spherical_joint.wires import natural_motion

Pair = tuple[float, float]
Motion = tuple[Quadruple, Quadruple, Quadruple]
Numbers = Any
"""A flat array of numbers; for static types each of them would be one of numpy's."""

FOUND, NO_POSE, NO_TENSIONS = range(3)
"""How a step went."""

# Where the constants stand …
(
    _AREA, _COMPLIANCE, _LEAST, _LOWEST, _MOST, _MIDDLE, _DECAY, AHEAD, _VANISHING, _RING, _WIRE,
    _SLIDE, _IRREGULAR, _WIRES,
) = range(14)  # fmt: skip
_WIRE_COUNT, _SEARCH_COUNT = 28, 26
_REGULAR = _WIRES + _WIRE_COUNT
_SEARCH = _REGULAR + _WIRE_COUNT
_SEARCH_HOME = _SEARCH + _SEARCH_COUNT
_HOME = _SEARCH_HOME + 4
# … and what is remembered from cycle to cycle.
_GUESS, _ONWARD, _SEAT, _SLIP = range(0, 8, 2)
SHARES, FIRST, SECOND, LATER, _START, _HOLD = range(8, 32, 4)
REMEMBERED = 32


@inlined
def before_natural(
    constants: Numbers,
    memory: Numbers,
    axis: Vector,
    velocity: Vector,
    acceleration: Vector,
    rods: Quadruple,
    pressures: Quadruple,
    base: float,
    anew: bool,
    starts: bool,
) -> tuple[int, Any]:
    """Do what `before` does, for exact wires under the natural pose."""
    motion = natural_motion(
        _wires(constants, _WIRES), four(constants, _HOME), axis, velocity, acceleration
    )
    return before(
        constants, memory, motion, axis, velocity, acceleration, rods, pressures, base, anew, starts
    )


@inlined
def before(
    constants: Numbers,
    memory: Numbers,
    motion: Motion,
    axis: Vector,
    velocity: Vector,
    acceleration: Vector,
    rods: Quadruple,
    pressures: Quadruple,
    base: float,
    anew: bool,
    starts: bool,
) -> tuple[int, Any]:
    """Return how the step went, and it; see `PoseStep.before`.

    Where no pose explains the wires, what they are is in the place of the residuals.
    """
    position, rate, rise = motion
    if anew:
        _balance(constants, memory, axis, velocity, acceleration)
    shares, later = four(memory, SHARES), four(memory, LATER)
    # One minimum for both would miss shares that are no numbers.
    how = FOUND if min(*shares) > 0.0 and min(*later) > 0.0 else NO_TENSIONS
    area, least = constants[_AREA], constants[_LEAST]
    hold = lifted(_scaled(4.0 * area * base, shares), shares, least)
    _put(memory, _HOLD, lifted(_scaled(4.0 * area * base, later), later, least))
    pull = _scaled(area, pressures)
    rates = (0.5 * (rate[0] - rate[2]), 0.5 * (rate[3] - rate[1]))
    friction, seat, slip = slide(
        constants[_RING],
        constants[_WIRE],
        constants[_SLIDE],
        (memory[_SEAT], memory[_SEAT + 1]),
        (memory[_SLIP], memory[_SLIP + 1]),
        rates,
        (hold[0] + hold[2], hold[3] + hold[1]),
    )
    memory[_SEAT], memory[_SEAT + 1] = seat
    memory[_SLIP], memory[_SLIP + 1] = slip
    # The rods pull in by what the wires stretch under what they bear.
    borne = spread(_scaled(_total(pull) / _total(hold), hold), friction)
    stretch = _scaled(constants[_COMPLIANCE], borne)
    wanted = _sum(position, stretch)
    settled, found, residuals = _search(constants, memory, _sum(rods, _scaled(-1.0, stretch)))
    if how == FOUND and not settled:  # without tensions no stretch is known
        how = NO_POSE
    forces = _pair_forces(memory, pull)
    if starts:
        _put(memory, _START, _sum(pull, _scaled(-1.0, spread(hold, forces))))
    middle, half = constants[_MIDDLE], 0.5 / area
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
def after(
    constants: Numbers, memory: Numbers, first: float, second: float, shake: float
) -> Quadruple:
    """Return the setpoints; see `PoseStep.after`."""
    # What holds the ring goes out early, past the laws: it has to be there in time.
    start = four(memory, _START)
    tensions = kept_taut(
        four(memory, FIRST),
        four(memory, SECOND),
        spread(_sum(four(memory, _HOLD), start), (first, second)),
        constants[_LEAST],
    )
    _put(memory, _START, _scaled(constants[_DECAY], start))
    return setpoints(constants, _sum(tensions, _scaled(shake, four(memory, SHARES))))


@inlined
def _balance(
    constants: Numbers, memory: Numbers, axis: Vector, velocity: Vector, acceleration: Vector
) -> None:
    """Work out what tensions do in a pose, and which will hold the one that follows."""
    shares, first, second = _tensions(constants, natural_rotation(axis))
    ahead = move_axis(axis, velocity, acceleration, constants[AHEAD])
    _put(memory, SHARES, shares)
    _put(memory, FIRST, first)
    _put(memory, SECOND, second)
    _put(memory, LATER, _tensions(constants, natural_rotation(ahead))[0])


@inlined
def _tensions(constants: Numbers, rotation: Rotation) -> tuple[Quadruple, Quadruple, Quadruple]:
    """Return what `TensionDistribution.at` does."""
    vanishing = constants[_VANISHING]
    shares, first, second = pose_tensions(_wires(constants, _WIRES), vanishing, rotation)
    if constants[_IRREGULAR] > 0.0:
        regular = pose_shares(_wires(constants, _REGULAR), vanishing, rotation)
        shares = without_tilt(regular, first, second)
    return shares, first, second


@inlined
def _search(
    constants: Numbers, memory: Numbers, shortening: Quadruple
) -> tuple[bool, Vector, Quadruple]:
    """Return what `ForwardKinematics.update` does; the shortenings if there is no pose."""
    last = (memory[_GUESS], memory[_GUESS + 1])
    guess = (last[0] + memory[_ONWARD], last[1] + memory[_ONWARD + 1])
    settled, p, axis, residuals = search(
        _searched(constants), four(constants, _SEARCH_HOME), guess, shortening
    )
    onward = step_ahead(last, p)
    if not settled:
        p, onward, residuals = (0.0, 0.0), (0.0, 0.0), shortening
    memory[_GUESS], memory[_GUESS + 1] = p
    memory[_ONWARD], memory[_ONWARD + 1] = onward
    return settled, axis, residuals


@inlined
def _pair_forces(memory: Numbers, tensions: Quadruple) -> Pair:
    """Return what `PoseTensions.pair_forces` does."""
    a, b, c, d = tensions
    e, f, g, h = four(memory, FIRST)
    k, m, n, p = four(memory, SECOND)
    return a * e + b * f + c * g + d * h, a * k + b * m + c * n + d * p


@inlined
def setpoints(constants: Numbers, tensions: Quadruple) -> Quadruple:
    """Return the pressures (Pa gauge) of tensions (N), within what may be asked for."""
    area, lowest, most = constants[_AREA], constants[_LOWEST], constants[_MOST]
    a, b, c, d = tensions
    return (
        min(max(a, lowest), most) / area,
        min(max(b, lowest), most) / area,
        min(max(c, lowest), most) / area,
        min(max(d, lowest), most) / area,
    )


@inlined
def _wires(values: Numbers, at: int) -> WireConstants:
    """Return the constants of the wires from where they stand."""
    radius, wound_from, straight, squares = four(values, at)
    anchors, adjusts = _vectors(values, at + 4), _vectors(values, at + 16)
    return radius, wound_from, straight, squares, anchors, adjusts


@inlined
def _vectors(values: Numbers, at: int) -> Vectors:
    return (
        (values[at], values[at + 1], values[at + 2]),
        (values[at + 3], values[at + 4], values[at + 5]),
        (values[at + 6], values[at + 7], values[at + 8]),
        (values[at + 9], values[at + 10], values[at + 11]),
    )


@inlined
def _searched(values: Numbers) -> Wires:
    """Return what the search computes with."""
    a, b, c, d = four(values, _SEARCH)
    e, f = values[_SEARCH + 4], values[_SEARCH + 5]
    at = _SEARCH + 6
    wires = _five(values, at), _five(values, at + 5), _five(values, at + 10), _five(values, at + 15)
    return (a, b, c, d, e, f), wires


@inlined
def four(values: Numbers, at: int) -> Quadruple:
    """Return four numbers from where they stand."""
    return (values[at], values[at + 1], values[at + 2], values[at + 3])


@inlined
def _five(values: Numbers, at: int) -> tuple[float, float, float, float, float]:
    return (values[at], values[at + 1], values[at + 2], values[at + 3], values[at + 4])


@inlined
def _put(values: Numbers, at: int, numbers: Quadruple) -> None:
    values[at], values[at + 1], values[at + 2], values[at + 3] = numbers


@inlined
def _scaled(factor: float, values: Quadruple) -> Quadruple:
    a, b, c, d = values
    return (factor * a, factor * b, factor * c, factor * d)


@inlined
def _sum(first: Quadruple, second: Quadruple) -> Quadruple:
    (a, b, c, d), (e, f, g, h) = first, second
    return (a + e, b + f, c + g, d + h)


@inlined
def _total(values: Quadruple) -> float:
    a, b, c, d = values
    return a + b + c + d


@inlined
def spread(tensions: Quadruple, forces: Pair) -> Quadruple:
    """Return tensions with the pairs' forces, half on either wire (see `PAIRS`)."""
    (a, b, c, d), (first, second) = tensions, forces
    return (a + 0.5 * first, b - 0.5 * second, c - 0.5 * first, d + 0.5 * second)
