"""What legs feel: what each foot bears and where, and how the waist leans and turns."""

from collections.abc import Sequence
from typing import NamedTuple


class FootLoad(NamedTuple):
    """The load that a foot bears.

    Parameters
    ----------
    force : float
        Across its sole, N.
    moments : tuple of float
        The force times how far ahead of, and to the left of, the point under the ankle it
        acts, N m.
    """

    force: float
    moments: tuple[float, float]


class Sensing(NamedTuple):
    """Measurements of the sensors that a pair of legs need not have.

    Parameters
    ----------
    feet : tuple of FootLoad
        Right and left.
    lean : tuple of float
        Roll and pitch of the waist against the vertical, rad.
    turning : tuple of float
        Its rates about its own x and y, rad/s.
    """

    feet: tuple[FootLoad, FootLoad]
    lean: tuple[float, float]
    turning: tuple[float, float]


def weighed_point(
    sensing: Sensing, feet: Sequence[Sequence[float]], least: float
) -> tuple[float, float] | None:
    """Return where on the ground both feet together are pressed, m; None: they hardly are.

    Parameters
    ----------
    sensing : Sensing
        What they bear.
    feet : sequence of sequence of float
        Where each is, as the plan has it, m.
    least : float
        Below so much force there is no such point, N.

    Notes
    -----
    The soles are taken to lie as the plan has them, level and straight ahead: a heading of 20
    degrees moves the point by a fifteenth of its distance from the ankle.
    """
    total = sensing.feet[0].force + sensing.feet[1].force
    if total < least:
        return None
    x = y = 0.0
    for load, foot in zip(sensing.feet, feet, strict=True):
        x += load.force * foot[0] + load.moments[0]
        y += load.force * foot[1] + load.moments[1]
    return x / total, y / total
