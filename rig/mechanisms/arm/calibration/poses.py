"""Which poses an arm is measured in: within its limits, clear of itself, and telling the most."""

import functools
import math
from typing import Final

import numpy as np

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, link_points, singularity_indices
from rig.mechanisms.arm.calibration.hand_fit import find_unseen, jacobian
from rig.mechanisms.arm.calibration.hand_model import parameters_of
from rig.mechanisms.arm.settings import HandMetrology

Pose = tuple[float, ...]

AMPLITUDE: Final = 0.5
"""How far a joint goes from where it stands while nothing is known of the arm, rad."""

_SHARE: Final = 0.8
"""Of each joint's range that is used."""
_WIDEST: Final = (2.4, 1.4, 2.2, 2.6, 1.9, 2.6)
"""No further than this from zero, rad: nothing is gained, and the arm would meet itself."""
_CANDIDATES: Final = 500
_FROM_AXIS, _BENT = 0.15, 0.25
"""Wrist and hand from the axis of q1, m; sines of elbow and wrist: clear of singularities."""
_OVER: Final = 0.03
"""Elbow, wrist and hand stay this far over the shoulder's height, m."""

HOME: Final[Pose] = (0.0, 0.3, 1.2, 0.0, 0.8, 0.0)
"""Where wide poses start, and by which they go if the straight way is not clear, rad."""


def near_poses() -> tuple[tuple[str, Pose], ...]:
    """Return poses around where the arm stands, as far to either side.

    Nothing is known yet, not even which way a joint turns; so each joint moves alone first, and
    what is permitted to one side must be permitted to the other.
    """
    still = (0.0,) * 6
    poses: list[tuple[str, Pose]] = [("home", still)]
    for k in range(6):
        poses.append((f"q{k + 1} alone", tuple(0.6 * AMPLITUDE * (j == k) for j in range(6))))
    rng = np.random.default_rng(7)
    for k in range(9):  # each with its opposite: what bends a line shows
        signs = rng.choice((-1.0, 1.0), 6) * rng.choice((0.5, 1.0), 6)
        poses.append((f"near {2 * k + 1}", tuple((AMPLITUDE * signs).tolist())))
        poses.append((f"near {2 * k + 2}", tuple((-AMPLITUDE * signs).tolist())))
    return tuple(poses)


@functools.lru_cache(maxsize=8)
def wide_poses(geometry: ArmGeometry, metrology: HandMetrology) -> tuple[tuple[str, Pose], ...]:
    """Return poses that determine zeros and lengths best, in an order that is clear to go.

    From candidates within the limits, clear of singularities and of the arm itself, the next is
    always the one that shrinks the volume of the fit's uncertainty most. Poses without a name
    are passed on the way.

    Parameters
    ----------
    geometry : ArmGeometry
        The profile's.
    metrology : HandMetrology
        How many poses, how well measured.

    Raises
    ------
    ValueError
        The limits leave too little room.

    References
    ----------
    J.-H. Borm and C.-H. Menq, "Determination of optimal measurement configurations for robot
    calibration based on observability measure", International Journal of Robotics Research
    10(1), 1991.
    """
    candidates = [
        pose
        for pose in _drawn(geometry)
        if is_clear(geometry, pose) and _is_way_clear(geometry, HOME, pose)
    ][:_CANDIDATES]
    if len(candidates) < 3 * metrology.poses:
        raise ValueError("the joints' limits leave too little room to calibrate the arm.")
    parameters = parameters_of(geometry, metrology)
    readings = np.array(candidates)
    start = np.array([parameter.value for parameter in parameters])
    design = jacobian(parameters, start, readings, float(geometry.wrist_sign))
    seen, _ = find_unseen(parameters, design, metrology.accuracy)
    rows = design[:, :, np.array(seen)] / metrology.accuracy
    believed = [
        parameter.scale / parameter.known
        for parameter, is_seen in zip(parameters, seen, strict=True)
        if is_seen
    ]
    information = np.diag(np.maximum(believed, 1e-3)) ** 2
    left, chosen = list(range(len(candidates))), []
    for _ in range(metrology.poses):
        inverse = np.linalg.inv(information)
        spreads = np.eye(3) + rows[left] @ inverse @ rows[left].transpose(0, 2, 1)
        best = left.pop(int(np.argmax(np.linalg.slogdet(spreads)[1])))
        information += rows[best].T @ rows[best]
        chosen.append(candidates[best])
    return _in_order(geometry, chosen)


def is_clear(geometry: ArmGeometry, pose: Pose) -> bool:
    """Return whether a pose is clear of singularities, of the base and of what it stands on."""
    arm = dimensions_of(geometry)
    q = tuple(pose)
    indices = singularity_indices(arm, q)  # type: ignore[arg-type]
    if min(abs(indices.elbow), abs(indices.wrist)) < _BENT or abs(indices.shoulder) < _FROM_AXIS:
        return False
    return _is_over(geometry, pose)


def _is_over(geometry: ArmGeometry, pose: Pose) -> bool:
    _, shoulder, elbow, wrist, hand = link_points(dimensions_of(geometry), tuple(pose))  # type: ignore[arg-type]
    marker = math.dist((0.0, 0.0, 0.0), geometry.marker)
    lowest = min(elbow[2], wrist[2], hand[2] - marker)
    return lowest > shoulder[2] + _OVER and math.hypot(hand[0], hand[1]) > _FROM_AXIS


def _drawn(geometry: ArmGeometry) -> list[Pose]:
    rng = np.random.default_rng(11)
    low = np.maximum(_SHARE * np.array(geometry.position_min), -np.array(_WIDEST))
    high = np.minimum(_SHARE * np.array(geometry.position_max), np.array(_WIDEST))
    drawn = rng.uniform(low, high, (6 * _CANDIDATES, 6))
    return [tuple(row) for row in drawn.tolist()]


def _in_order(geometry: ArmGeometry, poses: list[Pose]) -> tuple[tuple[str, Pose], ...]:
    here, left = HOME, list(poses)
    order: list[tuple[str, Pose]] = [("", HOME)]
    while left:
        left.sort(key=lambda pose: _duration(geometry, here, pose))
        clear = [pose for pose in left if _is_way_clear(geometry, here, pose)]
        if not clear:  # from home every one can be reached
            order.append(("", HOME))
            here = HOME
            continue
        left.remove(clear[0])
        order.append((f"pose {len(poses) - len(left)}", clear[0]))
        here = clear[0]
    return tuple(order)


def _duration(geometry: ArmGeometry, here: Pose, there: Pose) -> float:
    return max(
        abs(a - b) / rate for a, b, rate in zip(here, there, geometry.rate_limits, strict=True)
    )


def _is_way_clear(geometry: ArmGeometry, here: Pose, there: Pose) -> bool:
    shares = [k / 12.0 for k in range(1, 12)]
    ways = [tuple(a + s * (b - a) for a, b in zip(here, there, strict=True)) for s in shares]
    return all(_is_over(geometry, way) for way in ways)
