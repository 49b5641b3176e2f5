"""Limits that a rig has from a profile of other cylinders, and what they mean on its own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rig.config.models import Settings

SIZES = ("bore", "rod", "stroke")
"""Dimensions of a cylinder on which a limit may rest."""

_FORCES = ("pair_force", "tension")
_POSITION = "position"


def limits_that_rest_on(settings: Settings, others: set[str]) -> Iterator[tuple[str, str]]:
    """Yield the limits for which a dimension counts, and what each comes to on this rig.

    Parameters
    ----------
    settings : dataclass
        Those of a mechanism.
    others : set of str
        The dimensions that are others where the limits were written.
    """
    from rig.assembly.same_geometry import number_at
    from rig.hal.formats import format_quantity

    limits, area = getattr(settings, "limits", None), getattr(settings, "area", None)
    for name in _FORCES if others & {"bore", "rod"} else ():
        force = getattr(limits, name, None)
        if isinstance(force, tuple):
            force = max(force)
        if isinstance(force, float) and isinstance(area, float):
            pressure = format_quantity(force / area, "Pa")
            told = f"{name} {format_quantity(force, 'N')} is {pressure} on this bore"
            yield f"limits.{name}", told
    stroke, home = number_at(settings, "stroke"), number_at(settings, "home")
    position = getattr(limits, _POSITION, None)
    if "stroke" not in others or stroke is None or home is None:
        return
    if isinstance(position, tuple) and len(position) == 2:
        permitted = " … ".join(format_quantity(end, "m") for end in position)
        reach = format_quantity(min(home, stroke - home), "m")
        yield f"limits.{_POSITION}", f"{_POSITION} {permitted}, the stroke allows ±{reach}"
