"""Numbers without a unit where people write one: valid, and read as SI, which not everybody means.

Gains and the like are left out: their units are long, and nobody has a second one for them.
"""

from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from rig.config.located import Node
from rig.config.type_hints import hint_at, unit_of

_TAKEN_FOR_ANOTHER: Final = frozenset({"m", "Pa", "rad", "s", "kg", "N", "m/s", "V", "A"})
"""SI units beside which data sheets and rulers have others: mm, kPa, bar, deg, ms, g, mA."""


class Unitless(NamedTuple):
    """A number without its unit.

    Parameters
    ----------
    key : str
        Where the key of it stands, ``file:line:column``.
    place : str
        Where it stands itself.
    number : float
        What is written.
    unit : str
        The SI unit that it is read in.
    """

    key: str
    place: str
    number: float
    unit: str


def find_unitless(settings: type, node: Node) -> Iterator[Unitless]:
    """Yield the numbers in a mapping of settings that have no unit and could have another.

    Parameters
    ----------
    settings : type
        The dataclass.
    node : Node
        The mapping. Zero is the same in any unit.
    """
    yield from _below(settings, node, (), node.heading.told)


def _below(settings: type, node: Node, path: tuple[str | int, ...], key: str) -> Iterator[Unitless]:
    if isinstance(node.value, dict):
        for name, below in node.value.items():
            yield from _below(settings, below, (*path, name), below.heading.told)
    elif isinstance(node.value, list):
        for number, below in enumerate(node.value):
            yield from _below(settings, below, (*path, number), key)
    elif isinstance(node.value, int | float) and not isinstance(node.value, bool) and node.value:
        unit = unit_of(hint_at(settings, path))
        if unit in _TAKEN_FOR_ANOTHER:
            yield Unitless(key, node.mark.told, node.value, unit)


def say_unitless(found: Mapping[Unitless, None], places: Mapping[str, str]) -> tuple[str, ...]:
    """Return a sentence for each number that a file of a profile has, and no calibration.

    Parameters
    ----------
    found : mapping of Unitless
        Each once, in their order.
    places : mapping of str to str
        Where each key of the profile stands, by its dotted name, without calibrations.
    """
    names = {place: name for name, place in places.items()}
    return tuple(
        f"{names[its.key]}: {its.number:g} has no unit and is read as {its.number:g} {its.unit} "
        f"({its.place})"
        for its in found
        if its.key in names
    )
