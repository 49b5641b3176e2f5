"""The sizes that quantities of a laboratory rig can have: a slip of a unit or a digit is refused.

Every number of a file that has a unit is held against the least and the greatest of that unit,
unless its own field says something narrower. They are wide: what is beyond is not of this size of
machine, and a limit beyond switches its alarm off.
"""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from annotated_types import Ge, GroupedMetadata, Gt, Le, Lt


class Span(NamedTuple):
    """The least number but zero, and the greatest, SI."""

    least: float
    greatest: float


_OF_A_UNIT: Final[Mapping[str, Span]] = {
    "1": Span(1e-9, 1e9),
    "s": Span(1e-7, 86_400.0),  # a day
    "Hz": Span(1e-6, 1e6),
    "1/s": Span(1e-6, 1e6),
    "m": Span(1e-9, 10.0),
    "m/s": Span(1e-7, 50.0),
    "m/s^2": Span(1e-6, 1e4),
    "m^2": Span(1e-9, 10.0),
    "m^3": Span(1e-10, 1.0),
    "rad": Span(1e-9, 1e4),  # 1600 turns
    "rad/s": Span(1e-6, 1e5),
    "rad/s^2": Span(1e-6, 1e6),
    "kg": Span(1e-6, 1e3),
    "kg m^2": Span(1e-9, 1e3),
    "N": Span(1e-6, 1e5),
    "N/s": Span(1e-6, 1e7),
    "N/m": Span(1e-3, 1e9),
    "N/(m s)": Span(1e-3, 1e10),
    "N s/m": Span(1e-6, 1e7),
    "N m": Span(1e-9, 1e5),
    "N m s": Span(1e-9, 1e5),
    "N m/rad": Span(1e-6, 1e8),
    "N m s/rad": Span(1e-9, 1e5),
    "J": Span(1e-9, 1e6),
    "Pa": Span(1e-3, 1e7),  # 100 bar
    "Pa/s": Span(1.0, 1e11),
    "Pa/m": Span(1e-3, 1e11),
    "Pa/(m s)": Span(1e-3, 1e11),
    "Pa s/m": Span(1e-3, 1e10),
    "m^3/(s Pa)": Span(1e-13, 1e-4),  # sonic conductance; a large valve has 1e-6
    "V": Span(1e-6, 1e3),
    "A": Span(1e-6, 1e4),
    "K": Span(1.0, 1e4),
}
_ELSE: Final = Span(1e-12, 1e12)


def span_of(unit: str | None) -> Span:
    """Return the span of a unit; a number without one is a ratio."""
    return _OF_A_UNIT.get(unit or "1", _ELSE)


def bounded(metadata: Sequence[object], unit: str | None) -> list[object]:
    """Return the constraints of a number, with those of its unit where it has none of its own.

    Parameters
    ----------
    metadata : sequence
        Of its annotation.
    unit : str, optional
        SI.
    """
    span = span_of(unit)
    flat: list[object] = []
    for item in metadata:
        flat += item if isinstance(item, GroupedMetadata) else [item]
    made = [Ge(span.least) if item == Gt(0) else item for item in flat]
    if not any(isinstance(item, Le | Lt) for item in made):
        made.append(Le(span.greatest))
    if not any(isinstance(item, Ge | Gt) for item in made):
        made.append(Ge(-span.greatest))
    return made
