"""Denavit-Hartenberg parameters from a YAML file, in either convention."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, Interval, Unit

from rig.config.diagnostics import Problems
from rig.config.document import parse_mapping
from rig.config.settings import build
from rig.config.yaml_loader import read_source
from rig.hal.rising import Rising
from rig.mechanisms.arm.drawing.chain import Array, Chain, DrawnJoint

Length = Annotated[float, Unit("m")]
Angle = Annotated[float, Unit("rad"), Interval(ge=-2.0 * math.pi, le=2.0 * math.pi)]
"""A bare number is rad: what is more than a turn was meant in degrees."""


@dataclass(frozen=True, slots=True)
class DhRow:
    """One joint's parameters.

    Parameters
    ----------
    a, d : float
        Lengths along x and z, m.
    alpha, theta : float
        Turns about x and z, rad; theta is what is added to the joint's own angle.
    range : tuple of float, optional
        Of the joint's own angle, rad. None: half a turn either way of where the laws' arm has its
        zero.
    speed : float
        The joint's greatest, rad/s.
    """

    a: Length = 0.0
    alpha: Angle = 0.0
    d: Length = 0.0
    theta: Angle = 0.0
    range: Annotated[tuple[float, float], Unit("rad"), Rising("range")] | None = None
    speed: Annotated[float, Unit("rad/s"), Gt(0)] | None = None


@dataclass(frozen=True, slots=True)
class DhTable:
    """An arm by its six rows.

    Parameters
    ----------
    convention : str
        ``standard``: a row turns and shifts along z, then along x (Denavit and Hartenberg, 1955;
        Paul). ``modified``: along x first, with a and alpha of the link before (Craig).
    joints : tuple of DhRow
        From the base outwards.
    tool : float
        From the last frame to the tool point, along its z, m.
    """

    convention: Literal["standard", "modified"]
    joints: tuple[DhRow, DhRow, DhRow, DhRow, DhRow, DhRow]
    tool: Length = 0.0


def read_dh(file: Path) -> Chain:
    """Return the arm that a file of Denavit-Hartenberg parameters describes.

    Raises
    ------
    ConfigurationError
        Something in it is wrong; with line and key.
    """
    problems = Problems()
    root = parse_mapping(read_source(file), problems)
    problems.raise_if_any()
    table = build(DhTable, root, problems)
    problems.raise_if_any()
    assert table is not None
    return chain_of(table, str(file))


def chain_of(table: DhTable, source: str) -> Chain:
    """Return the six axes of a table, in the frame before its first row."""
    frame = np.eye(4)
    joints = []
    for number, row in enumerate(table.joints, 1):
        along_x = _screw(0, row.alpha, row.a)
        along_z = _screw(2, row.theta, row.d)
        before = frame @ along_x if table.convention == "modified" else frame
        joints.append(
            DrawnJoint(
                f"row {number}", before[:3, 3], before[:3, 2], *(row.range or (-math.pi, math.pi)),
                row.speed, is_ranged=row.range is not None,
            )
        )  # fmt: skip
        frame = before @ along_z
        if table.convention == "standard":
            frame = frame @ along_x
    tool = frame @ _screw(2, 0.0, table.tool)
    return Chain(source, tuple(joints), "the base", "the tool point", tool[:3, 3], tool[:3, :3])


def _screw(axis: int, angle: float, shift: float) -> Array:
    """Return a turn about x (0) or z (2) and a shift along it."""
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.eye(4)
    matrix[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    matrix[axis, 3] = shift
    return matrix
