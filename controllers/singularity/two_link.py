"""A chain of two links in its plane: the elbow of an arm, the knee of a leg.

Both are singular where they are straight, ``S = sin(bend) = 0``. The rates that carry the tip
along v are found in two parts, of which only one is singular::

    q' = (swing, 0) + (stretch, fold) / S

What is free to scale with a number b therefore goes through ``S = 0`` wherever ``b / S`` stays
finite: ``b = S`` is the ray (adj(J) v, det J), up to the constant ``first * second``, and b that
follows S in a region around zero is an arm's law.

References
----------
Nenchev, Tsumaki and Uchiyama, "Singularity-consistent parameterization of robot motion and
control", Int. J. Robotics Research 19(2), 2000: the ray.
Miyata et al., eq. (5) and (6): the parts for links of one length.
"""

import math
from typing import NamedTuple

from controllers.compiled import inlined


class TipFrame(NamedTuple):
    """The place of the tip, and what moving it along its radius costs.

    Parameters
    ----------
    sine, cosine : float
        Of the direction from base to tip, from the vertical.
    radius : float
        m. With links of one length it is signed, ``2 a cos(bend / 2)``, so that the direction does
        not jump where the tip passes through the base.
    lever : float
        m: the first joint turns by ``lever / radius`` of what the second turns back.
    """

    sine: float
    cosine: float
    radius: float
    lever: float


@inlined
def two_link_frame(first: float, second: float, lean: float, bend: float) -> TipFrame:
    """Return the frame of the tip.

    Parameters
    ----------
    first, second : float
        Lengths, m.
    lean, bend : float
        Of the first link from the vertical and of the second from the first, rad.
    """
    half = 0.5 * bend
    c = math.cos(half)
    if first == second:  # exact where the tip passes through the base
        return TipFrame(math.sin(lean + half), math.cos(lean + half), 2.0 * second * c, second * c)
    x = first * math.sin(lean) + second * math.sin(lean + bend)
    z = first * math.cos(lean) + second * math.cos(lean + bend)
    short = first - second
    radius = math.sqrt(short * short + 4.0 * first * second * c * c)
    lever = second * (first * (2.0 * c * c - 1.0) + second) / radius
    return TipFrame(x / radius, z / radius, radius, lever)


@inlined
def two_link_parts(
    first: float, second: float, frame: TipFrame, x: float, z: float
) -> tuple[float, float, float]:
    """Return ``swing``, ``stretch`` and ``fold`` of the rates that carry the tip along (x, z).

    Parameters
    ----------
    first, second : float
        Lengths, m.
    frame : TipFrame
        Of the tip.
    x, z : float
        Velocity of the tip, horizontal and up, m/s.

    Notes
    -----
    The third entry of Miyata's eq. (6) reads ``-r``; with the signed radius it is the inverse.
    Swing is 0 where the tip is in the base: nothing swings it there.
    """
    sine, cosine, radius, lever = frame
    across = cosine * x - sine * z
    radial = (sine * x + cosine * z) / (first * second)
    swing = across / radius if radius != 0.0 else 0.0
    return swing, lever * radial, -radius * radial
