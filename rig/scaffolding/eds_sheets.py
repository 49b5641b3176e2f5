"""Devices' own EDS files beside who answers on a bus: what they map goes into the profile."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Final, cast

from rig.assembly.registry import REGISTRY
from rig.hal import DriverSettings
from rig.hal.driver import Keys, Scalar
from rig.hal.frames import Found

_READER: Final = "cia401"
"""Whose reading of a file tells the identity; that is the same for every CANopen driver."""


class EdsSheet:
    """An EDS file.

    Parameters
    ----------
    path : Path
        As the profile is to name it.

    Raises
    ------
    ConfigurationError
        It cannot be read, or is none.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        file = REGISTRY.settings("driver", _READER).read_description(path)
        assert file is not None
        self._identity = file.identity()

    def is_of(self, found: Found) -> bool:
        """Return whether a device that answers is what the file describes."""
        own = self._identity
        return (
            own.profile == found.profile
            and own.vendor in (None, found.vendor)
            and own.product in (None, found.product)
        )

    def lines(self, settings: DriverSettings) -> Iterator[str]:
        """Yield the lines of a device's entry that this file makes, by one like it."""
        yield f"eds: {self.path}"
        file = type(settings).read_description(self.path)
        if file is not None:
            yield from _lines(file.mapped(cast("dict[str, object]", _plain(settings))))


def sheet_of(sheets: Sequence[EdsSheet], found: Sequence[Found]) -> EdsSheet | None:
    """Return the first file that is of one of those who answer."""
    return next((sheet for sheet in sheets if any(map(sheet.is_of, found))), None)


def _plain(value: object) -> object:
    """Return settings as a file would have them."""
    if isinstance(value, Mapping):
        return {key: _plain(below) for key, below in value.items()}
    fields = getattr(value, "__dataclass_fields__", None)
    return value if fields is None else {name: _plain(getattr(value, name)) for name in fields}


def _lines(mapped: Mapping[Keys, Scalar]) -> Iterator[str]:
    """Yield settings as YAML: sections of one level on one line."""
    above: Keys = ()
    for section, members in groupby(mapped.items(), lambda item: item[0][:-1]):
        inside = [f"{keys[-1]}: {_said(keys[-1], value)}" for keys, value in members]
        if not section:
            yield from inside
            continue
        shared = next(k for k, key in enumerate(section) if section[: k + 1] != above[: k + 1])
        for depth in range(shared, len(section) - 1):
            yield f"{'  ' * depth}{section[depth]}:"
        yield f"{'  ' * (len(section) - 1)}{section[-1]}: {{{', '.join(inside)}}}"
        above = section


def _said(key: str | int, value: Scalar) -> str:
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    return f"0x{value:04X}" if key == "index" else str(value)
