"""The seam between `rig watch` and a mechanism: what a screen shows of it."""

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Points = NDArray[np.float64]
    """Shape (n, points, 3), m: where the points of a shape are in each of n rows."""
    ColumnOf = Callable[[str], NDArray[np.float64]]

Kind = Literal["line", "loop", "dot"]
"""A chain of points, one that is closed, or single points."""
Role = Literal["body", "part", "reading", "reference", "ghost", "limit", "ground", "tone"]
"""What a shape stands for, by which a screen chooses its colour."""


class Shape(NamedTuple):
    """One thing of a scene, whose points move and whose number of points does not.

    Parameters
    ----------
    name : str
        For people; shapes of one name are one entry of the legend.
    kind : str
        Of `Kind`.
    role : str
        Of `Role`; ``"tone"``: coloured by the values of a column.
    points : int
        How many.
    width : float
        Of a line, or diameter of a dot, pixels.
    radius : float
        Of a dot that is a ball, m; 0: `width` says how large it is.
    trail : float
        For how long the way of its points stays drawn, s.
    tone : str
        That column.
    tone_range : tuple of float
        Its values at both ends of the scale of colours.
    """

    name: str
    kind: Kind
    role: Role
    points: int
    width: float = 2.0
    radius: float = 0.0
    trail: float = 0.0
    tone: str = ""
    tone_range: tuple[float, float] = (0.0, 1.0)


class Pane(NamedTuple):
    """One pane of the scope.

    Parameters
    ----------
    title : str
        For people.
    columns : tuple of str
        Of the log; of one unit. Those that a log lacks are left out.
    """

    title: str
    columns: tuple[str, ...]


def beside_reference(names: Iterable[str]) -> tuple[str, ...]:
    """Return the columns of readings, each before that of its reference."""
    return tuple(f"{kind}.{name}" for name in names for kind in ("reading", "reference"))


Bounds = Mapping[str, tuple[float, float]]
"""Least and greatest permitted value of columns, SI; infinite where there is no limit."""


class Scene(Protocol):
    """A picture of a mechanism, computed from its settings and its log.

    Inherit it. Named in the mechanism's row (`rig.hal.parts.MechanismParts.scene`), made as
    ``Class(settings)`` in the process that serves the page, never in the loop's.

    Attributes
    ----------
    shapes : sequence of Shape
        What is drawn; the first ones lie behind.
    centre : tuple of float
        Where the camera looks, m.
    size : float
        Radius of the sphere that it shows, m.
    follows : str
        Name of a shape that the camera goes along with; empty: it stays.
    panes : sequence of Pane
        What the scope shows at first.
    bounds : mapping
        Limits, which the scope draws as lines.
    """

    shapes: Sequence[Shape] = ()
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: float = 1.0
    follows: str = ""
    panes: Sequence[Pane] = ()
    bounds: Bounds = MappingProxyType({})

    @abstractmethod
    def __init__(self, settings: object) -> None:
        """Take the mechanism's section of the profile."""

    def place(self, column: "ColumnOf") -> "Sequence[Points]":
        """Return the points of each shape in some rows of a log, in the order of `shapes`.

        Parameters
        ----------
        column : callable
            ``column(name)`` is an array of shape (n,), SI; KeyError if the log has none.
        """
        return ()
