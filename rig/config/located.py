"""Values with the place where they were written: sources, marks and nodes."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final, NamedTuple, TypeAlias

Path: TypeAlias = tuple[str | int, ...]
"""Keys and list positions from the root of a document to a value."""

_DOTTED: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
_MOST_PLACES: Final = 6
_LINE_BREAK: Final = re.compile("\r\n|[\n\r\x85\u2028\u2029]")  # what YAML 1.1 calls one


class Source:
    """A named text: a file, or the text of an option.

    Parameters
    ----------
    name : str
        What an error message calls it: the file's path, or ``--set``.
    text : str
        All of it.
    seen : str, optional
        What is shown of it in an error; default: the text.
    is_whole : bool
        The name says all of it: an error names no place in it, and shows no more.
    """

    def __init__(
        self, name: str, text: str, seen: str | None = None, *, is_whole: bool = False
    ) -> None:
        self.name = name
        self.text = text
        self.is_whole = is_whole
        self._seen = text if seen is None else seen

    @property
    def option(self) -> str:
        """The option as it was written, if this is the text of one; else nothing."""
        if self.is_whole:
            return self.name
        return f"{self.name} {self._seen}" if self.name.startswith("--") else ""

    @cached_property
    def lines(self) -> list[str]:
        """The lines that are shown, without their ends."""
        return _LINE_BREAK.split(self._seen)

    def mark_at(self, offset: int) -> "Mark":
        """Return the place of the character at an offset."""
        before = _LINE_BREAK.split(self.text[:offset])
        return Mark(self, len(before), len(before[-1]) + 1)


class Mark(NamedTuple):
    """A place in a source; line and column count from 1."""

    source: Source
    line: int
    column: int

    def __str__(self) -> str:
        source = self.source
        return source.name if source.is_whole else f"{source.name}:{self.line}:{self.column}"

    @property
    def told(self) -> str:
        """The place in words, where no line of it is shown: an option is its own text."""
        return self.source.option or str(self)


class Broken:
    """A value that the loader has already complained about."""


BROKEN: Final = Broken()

Scalar: TypeAlias = str | int | float | bool | Broken | None
Plain: TypeAlias = Scalar | list["Plain"] | dict[str, "Plain"]


@dataclass(frozen=True, slots=True)
class Node:
    """A value and where it was written.

    Parameters
    ----------
    value : dict, list or scalar
        Nodes below a mapping's keys or in a list, or the scalar itself.
    mark : Mark
        Where the value starts.
    key : Mark, optional
        Where the key of the value stands, if it is in a mapping.
    """

    value: "dict[str, Node] | list[Node] | Scalar"
    mark: Mark
    key: Mark | None = None

    @property
    def heading(self) -> Mark:
        """Where a reader looks for the whole value: its key, else its start."""
        return self.key or self.mark

    def plain(self) -> Plain:
        """Return the value as plain dicts, lists and scalars."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value

    def descend(self, path: Sequence[str | int]) -> "tuple[Node, Path]":
        """Follow a path as far as it goes.

        Parts that lead nowhere are skipped: a validator's path also names the alternatives of
        a union, which are not in the document.

        Returns
        -------
        node : Node
            The last node that was reached.
        path : tuple
            The parts that led there.
        """
        node, taken = self, []
        for part in path:
            below = node.get(part)
            if below is not None:
                node = below
                taken.append(part)
        return node, tuple(taken)

    def get(self, part: str | int) -> "Node | None":
        """Return the node below a key or list position, None if there is none."""
        if isinstance(self.value, dict) and isinstance(part, str):
            return self.value.get(part)
        if isinstance(self.value, list) and isinstance(part, int) and part < len(self.value):
            return self.value[part]
        return None

    def with_items(self, items: "dict[str, Node]") -> "Node":
        """Return the same place with other content."""
        return replace(self, value=items)


def places_of(node: Node, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield the dotted name of every key below a node, and where it stands."""
    if isinstance(node.value, dict):
        for key, below in node.value.items():
            dotted = f"{name}.{key}" if name else key
            yield dotted, below.heading.told
            yield from places_of(below, dotted)


def places_named(
    message: str,
    places: Mapping[str, str],
    others: Mapping[str, str] = MappingProxyType({}),
    section: str = "",
) -> str:
    """Return a message with the place of each setting and each device that it names.

    Parameters
    ----------
    message : str
        Of a rule that holds one part of a file against another.
    places : mapping of str to str
        Where each key stands, by its dotted name.
    others : mapping of str to str
        The same of another file; its keys are meant by names with a dot only …
    section : str
        … and those of this section of it by theirs alone.
    """
    said = message.partition("; there are ")[0]  # what else there is has no part in it
    words = {word.strip(".") for word in _DOTTED.findall(said)}
    named = {
        f"    {key}: {place}"
        for key, place in places.items()
        for word in words
        if (key == word or key.endswith(f".{word}")) and ("." in word or key.count(".") == 1)
    }
    named |= {
        f"    {key}: {place}"
        for key, place in others.items()
        for word in words
        if ("." in word and (key == word or key.endswith(f".{word}"))) or key == f"{section}.{word}"
    }
    return "\n".join([message, *sorted(named)[:_MOST_PLACES]])
