"""The fit of an arm's zeros and lengths to where a marker on its hand was seen.

What no pose tells apart is found from the singular directions of the fit before it is made, said
in words, and left as the profile has it.
"""

import itertools
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.recording import CalibrationRefused
from rig.mechanisms.arm.calibration.hand_model import (
    FRAME,
    JOINTS,
    LENGTHS,
    Parameter,
    align,
    angles_of,
    marker_positions,
)

_WHY: Final = {
    "q1": "a turn of the base looks the same",
    "base_height": "a lift of the base looks the same",
    "q6": "a point on the tool's axis does not move as the tool turns; give "
    "arm.geometry.marker 20 mm or more across it",
}
"""What may stay as the profile has it, and why it is not seen."""

_VAGUE: Final = 1.0
"""A direction that is not known better than this, in its typical error, is not seen."""

_PART: Final = 0.05
_DIFFERENCE: Final = 1e-3

Directions = tuple[float, ...]

_NEAREST: Final = 8
_FARTHEST: Final = np.array((1.5,) * 6 + (0.1,) * 7)
"""No zero (rad) and no length (m) is as wrong as that."""
_EVALUATIONS: Final = 25
"""A fit takes five to ten; what does not come near by then does not come near."""
_CLEARLY: Final = 3.0
"""So much worse must the next best directions fit."""


class HandFit(NamedTuple):
    """Zeros and lengths of an arm, fitted to positions of its hand.

    Parameters
    ----------
    values : ndarray, shape (22,)
        Of the parameters, rad and m.
    covariance : ndarray, shape (22, 22)
        0 where a parameter was held.
    seen : tuple of bool
        Which parameters were found.
    notes : tuple of str
        Sentences on those that were not.
    freedom : float
        Degrees of freedom of the residuals.
    residuals : ndarray, shape (n, 3)
        Measured less fitted, m.
    """

    values: Array
    covariance: Array
    seen: tuple[bool, ...]
    notes: tuple[str, ...]
    freedom: float
    residuals: Array


def jacobian(parameters: Sequence[Parameter], values: Array, readings: Array, sign: float) -> Array:
    """Return the marker's positions by parameter, each in its typical error; shape (n, 3, p)."""
    columns = []
    for k, parameter in enumerate(parameters):
        step = np.zeros(len(values))
        step[k] = _DIFFERENCE * parameter.scale
        after = marker_positions(values + step, readings, sign)
        before = marker_positions(values - step, readings, sign)
        columns.append((after - before) / (2.0 * _DIFFERENCE))
    return np.stack(columns, axis=2)


def find_unseen(
    parameters: Sequence[Parameter], design: Array, accuracy: float
) -> tuple[tuple[bool, ...], tuple[str, ...]]:
    """Return which parameters poses can tell, and sentences on those that they cannot.

    Parameters
    ----------
    parameters : sequence of Parameter
        p of them.
    design : ndarray, shape (n, 3, p)
        Of `jacobian`.
    accuracy : float
        Of a coordinate, m.

    Raises
    ------
    CalibrationRefused
        Something that must be found is among them.
    """
    rows = design.reshape(-1, len(parameters)) / accuracy
    free = [k for k, parameter in enumerate(parameters) if parameter.known > 0.0]
    known = np.diag([parameters[k].scale / parameters[k].known for k in free])
    _, singular, directions = np.linalg.svd(np.vstack((rows[:, free], known)))
    vague = directions[singular < 1.0 / _VAGUE].T
    held: list[int] = []
    for name in _WHY:
        place = next((i for i, k in enumerate(free) if parameters[k].name == name), None)
        if place is None or len(held) == vague.shape[1]:
            continue
        if np.linalg.matrix_rank(vague[[*held, place]], tol=_PART) > len(held):
            held.append(place)
    if len(held) < vague.shape[1]:
        parts = np.linalg.norm(vague, axis=1)
        names = [parameters[free[i]].words for i in np.argsort(-parts) if parts[i] > 0.2]
        raise CalibrationRefused(
            f"these poses do not tell {', '.join(names[:-1])} and {names[-1]} apart: measure "
            "more of them, or poses that differ more"
            if len(names) > 1
            else f"these poses do not show {names[0]}"
        )
    notes = []
    mixed = vague @ np.linalg.inv(vague[held]) if held else vague
    for column, place in zip(mixed.T, held, strict=True):
        parameter = parameters[free[place]]
        others = [
            parameters[free[i]].words for i in range(len(free))
            if i != place and abs(column[i]) > _PART
        ]  # fmt: skip
        one = f"and {' and '.join(others)} are one" if others else "is not seen"
        notes.append(f"{parameter.words} {one}: {_WHY[parameter.name]}; it stays as it was")
    seen = [k in free and free.index(k) not in held for k in range(len(parameters))]
    return tuple(seen), tuple(notes)


def fit_hand(
    parameters: Sequence[Parameter],
    readings: Array,
    seen_at: Array,
    sign: float,
    accuracy: float,
) -> HandFit:
    """Fit zeros, lengths and where the instrument stands to measured positions.

    Parameters
    ----------
    parameters : sequence of Parameter
        What is believed before.
    readings : ndarray, shape (n, 6)
        Joints, directions corrected, rad.
    seen_at : ndarray, shape (n, 3)
        The marker, m.
    sign : float
        The geometry's `wrist_sign`.
    accuracy : float
        Stated standard uncertainty of a coordinate, m.

    Raises
    ------
    CalibrationRefused
        There are too few poses, or they are too much alike.
    """
    from scipy.optimize import least_squares

    start = np.array([parameter.value for parameter in parameters])
    if any(parameter.known > 0.0 for parameter in parameters if parameter.name in FRAME):
        rotation, place = align(seen_at, marker_positions(start, readings, sign))
        start[-6:-3], start[-3:] = angles_of(rotation), place
    seen, notes = find_unseen(parameters, jacobian(parameters, start, readings, sign), accuracy)
    free = np.array(seen)
    believed = [k for k in range(len(seen)) if seen[k] and np.isfinite(parameters[k].known)]
    freedom = 3 * len(readings) - int(free.sum()) + len(believed)
    if freedom < 3:
        raise CalibrationRefused(
            f"{len(readings)} poses are {3 * len(readings)} numbers for {int(free.sum())} "
            f"unknowns: measure at least {-(-(int(free.sum()) - len(believed) + 3) // 3)}"
        )
    scales = np.array([parameter.scale for parameter in parameters])
    before = np.array([parameters[k].value for k in believed])
    weights = np.array([1.0 / parameters[k].known for k in believed])

    def values_of(x: Array) -> Array:
        values = start.copy()
        values[free] += scales[free] * x
        return values

    def misfit(x: Array, spread: float) -> Array:
        values = values_of(x)
        off = (seen_at - marker_positions(values, readings, sign)).ravel() / spread
        return np.concatenate((off, weights * (before - values[believed])))

    spread, x = accuracy, np.zeros(int(free.sum()))
    for _ in range(2):  # the second time with the spread that the first has shown
        found = least_squares(misfit, x, args=(spread,), x_scale="jac", max_nfev=_EVALUATIONS)
        x = found.x
        residuals = found.fun[: seen_at.size] * spread
        spread = max(float(np.sqrt(residuals @ residuals / freedom)), 1e-9)
    covariance = np.zeros((len(parameters), len(parameters)))
    inside = np.linalg.inv(found.jac.T @ found.jac) * np.outer(scales[free], scales[free])
    covariance[np.ix_(free, free)] = inside
    return HandFit(
        values_of(found.x), covariance, seen, notes, float(freedom), residuals.reshape(-1, 3)
    )


def find_directions(
    parameters: Sequence[Parameter],
    readings: Array,
    seen_at: Array,
    sign: float,
    accuracy: float,
) -> Directions:
    """Return of each joint whether it turns as the profile says, +1, or the other way, -1.

    Every combination is compared with all poses, zeros and lengths as they were believed before;
    those that come nearest are fitted.

    Parameters
    ----------
    parameters, readings, seen_at, sign, accuracy
        See `fit_hand`; the joints as the profile has them.

    Raises
    ------
    CalibrationRefused
        The hand moved too little to tell, or not as the joints did.
    """
    start = np.array([parameter.value for parameter in parameters])
    is_free = any(p.known > 0.0 for p in parameters if p.name in FRAME)

    def distance(directions: Directions) -> float:
        modelled = marker_positions(start, np.array(directions) * readings, sign)
        if is_free:
            rotation, place = align(seen_at, modelled)
            return float(np.mean((seen_at - modelled @ rotation.T - place) ** 2))
        return float(np.var(seen_at - modelled, axis=0).sum())

    every = sorted(itertools.product((1.0, -1.0), repeat=len(JOINTS)), key=distance)
    fits: list[tuple[float, Directions, HandFit]] = []
    refusal: CalibrationRefused | None = None
    for directions in every[:_NEAREST]:
        try:
            fit = fit_hand(parameters, np.array(directions) * readings, seen_at, sign, accuracy)
        except CalibrationRefused as error:
            refusal = refusal or error
            continue
        # Turned by half a turn, and a length negative, the other direction is the same arm.
        moved = np.abs(fit.values - start)[: len(JOINTS) + len(LENGTHS)]
        if np.all(moved < _FARTHEST):
            fits.append((float(np.sqrt(np.mean(fit.residuals**2))), directions, fit))
    if not fits:
        raise refusal or CalibrationRefused(
            "the hand did not move as the joints did: are poses mixed up, or a unit?"
        )
    fits.sort(key=lambda entry: entry[0])
    left, best, found = fits[0]
    # The direction of q1 shows even where its zero does not: the instrument's own placing may hide
    # a constant angle, not a motion.
    design = jacobian(parameters, found.values, np.array(best) * readings, sign)
    shows = np.sqrt(np.mean(np.sum(design[:, :, : len(JOINTS)] ** 2, axis=1), axis=0)) > accuracy
    # What moves the marker less than it is measured turns as the profile says.
    best = tuple(d if shows[j] else 1.0 for j, d in enumerate(best))
    for other_left, other, _ in fits[1:]:
        unlike = [j for j in range(len(JOINTS)) if best[j] != other[j] and shows[j]]
        if unlike and other_left < _CLEARLY * left:
            names = ", ".join(JOINTS[j] for j in unlike)
            raise CalibrationRefused(
                f"the hand's motion does not tell which way {names} turns: with it reversed the "
                f"positions fit to {1e3 * other_left:.2g} mm, else to {1e3 * left:.2g} mm"
            )
    return best
