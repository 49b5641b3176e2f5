"""The seam between files and code: which settings belong to which name."""

from typing import Any, Literal, Protocol

Kind = Literal["bus", "driver", "controller", "mechanism", "plant", "reference"]


class Registry(Protocol):
    """Names that a file may use, and the settings dataclass behind each.

    The loader stays free of concrete drivers and controllers: `rig.assembly` implements
    this from its table and from entry points.
    """

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted."""
        ...

    def settings(self, kind: Kind, name: str) -> type[Any]:
        """Return the settings dataclass of a name.

        Raises
        ------
        KeyError
            There is no such name.
        """
        ...
