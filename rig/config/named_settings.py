"""The names that a file may use for code, and the settings that belong to each."""

from typing import Literal, Protocol

Kind = Literal["bus", "driver", "controller", "mechanism", "plant", "reference"]


class Registry(Protocol):
    """Names that a file may use, and the settings dataclass behind each.

    The loader stays free of concrete drivers and controllers: `rig.assembly` implements
    this from its table and from entry points.
    """

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted; also of code that no file has named yet."""

    def imported(self, kind: Kind) -> tuple[str, ...]:
        """Return the names of a kind whose settings may be asked for: ours, and what was named."""

    def admit(self, additions: str) -> None:
        """Let additions of another package take part, which a profile names.

        Raises
        ------
        KeyError
            No package offers any of that name.
        ConfigurationError
            They cannot be used.
        """

    def unnamed(self) -> tuple[str, ...]:
        """Return the additions that packages offer and no file has named."""

    def settings(self, kind: Kind, name: str) -> type[object]:
        """Return the settings dataclass of a name.

        Raises
        ------
        KeyError
            There is no such name.
        """

    def references(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the references that a mechanism follows."""


def controller_key(registry: Registry, mechanism: str, name: str) -> str:
    """Return the registry's name of a controller that a mechanism's profile calls `name`.

    Laws of different mechanisms may have one name, ``inverse``; the registry tells them apart
    as ``arm/inverse`` and ``legs/inverse``.
    """
    own = f"{mechanism}/{name}"
    return own if own in registry.names("controller") else name


def controller_names(registry: Registry, mechanism: str | None = None) -> tuple[str, ...]:
    """Return the names that profiles may give controllers: of one mechanism, or of any."""
    scoped = (name.rpartition("/") for name in registry.names("controller"))
    return tuple(
        sorted({name for scope, _, name in scoped if mechanism is None or scope in ("", mechanism)})
    )
