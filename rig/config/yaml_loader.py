"""Read a strict subset of YAML into values that know their place.

The subset is mappings, lists and scalars. Refused are anchors, aliases, merge keys, tags,
directives, several documents in a file, duplicate keys and tabs. Plain scalars are

- ``null``, ``~`` or nothing;
- ``true`` and ``false``, in this spelling only: ``yes``, ``no``, ``on``, ``off`` are text;
- decimal integers and ``0x`` hexadecimal ones; a leading zero is refused, since YAML 1.1 reads
  it as octal and YAML 1.2 does not;
- decimal numbers with or without point and exponent (``1e-3`` too), ``.inf`` and ``.nan``,
  which no field takes;
- else text: dates, ``12:30`` and ``1_000`` among it.

Keys are text as they are written.
"""

import os
import re
from pathlib import Path
from typing import Final

import yaml
from yaml.events import (
    AliasEvent,
    CollectionStartEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
    StreamStartEvent,
)

from rig.config.diagnostics import Diagnostic, Problems, ProfileError
from rig.config.located import BROKEN, Mark, Node, Plain, Scalar, Source
from rig.hal.errors import ConfigurationError
from rig.hal.files import read_regular

MAX_BYTES: Final = 1 << 20
"""Largest file that is read; a profile has some thousand bytes."""

MAX_DEPTH: Final = 24
"""Deepest nesting; a profile has five levels."""

_UNREADABLE: Final = re.compile(
    "[^\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
)
_UNREADABLE_IN_TEXT: Final = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
_INTEGER: Final = re.compile(r"[-+]?[0-9]+")
_HEXADECIMAL: Final = re.compile(r"0x[0-9a-fA-F]{1,16}")
_FLOAT: Final = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_LEADING_ZERO: Final = re.compile(r"[-+]?0[0-9]+")
_WORDS: Final[dict[str, Scalar]] = {
    "": None,
    "~": None,
    "null": None,
    "true": True,
    "false": False,
    ".inf": float("inf"),
    "-.inf": float("-inf"),
    ".nan": float("nan"),
}
_EXACT_DIGITS: Final = 18
"""Integers of more digits become floats: none is an identifier, and none overflows later."""

try:  # The parser in C is ten times as fast and marks the same places.
    from yaml import CSafeLoader as SafeLoader
except ImportError:
    from yaml import SafeLoader  # type: ignore[assignment]


def read_source(path: Path) -> Source:
    """Read a file as text.

    Parameters
    ----------
    path : Path
        A regular file of at most `MAX_BYTES` of UTF-8.

    Raises
    ------
    ConfigurationError
        The file cannot be read or is not text.
    ProfileError
        It holds a character that has no place in YAML; with its location.
    """
    content = read_regular(path, MAX_BYTES)
    if path.is_symlink() and Path(os.path.realpath(path)).suffix != path.suffix:
        # Errors quote lines of what is read: a link must not have them quote what is no such file.
        raise ConfigurationError(f"cannot read {path}: it is a link to a file of another kind")
    try:
        return Source(str(path), content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        source = Source(str(path), content.decode("utf-8", "replace"))
        before = content[: error.start].decode("utf-8", "replace")
        mark = source.mark_at(len(before))
        message = f"byte 0x{content[error.start]:02X} is not UTF-8 text"
        raise ProfileError([Diagnostic(mark, message)]) from error


def read_plain(path: Path) -> Plain:
    """Return what a file holds, as plain data.

    Raises
    ------
    ConfigurationError
        It cannot be read, or is none of the strict subset.
    """
    return plain_in(read_source(path))


def plain_in(source: Source) -> Plain:
    """Return what a text holds, as plain data.

    Raises
    ------
    ConfigurationError
        It is none of the strict subset.
    """
    problems = Problems()
    root = parse(source, problems)
    problems.raise_if_any()
    return root.plain()


def parse(source: Source, problems: Problems, *, flow_only: bool = False) -> Node:
    """Turn a text into a tree of located values.

    Parameters
    ----------
    source : Source
        The text.
    problems : Problems
        Collects what is refused but does not end the reading.
    flow_only : bool
        Refuse mappings and lists in block style, which make no sense within one line.

    Raises
    ------
    ProfileError
        The text is not YAML at all, or is empty.
    """
    for match in _UNREADABLE.finditer(source.text):
        char = match.group()
        name = "a tab" if char == "\t" else f"character U+{ord(char):04X}"
        instead = "; use spaces" if char == "\t" else ""
        said = f"{name} has no place in this file{instead}"
        problems.add_broken(source.mark_at(match.start()), said)
        if char != "\t":
            raise problems.error()
    problems.raise_if_any()
    loader = StrictLoader(source, problems, flow_only=flow_only)
    try:
        return loader.read_document()
    except yaml.MarkedYAMLError as error:
        mark = _mark_in(source, error.problem_mark or error.context_mark)
        if mark.line > len(source.lines):  # the parser in C counts one line past the end
            mark = Mark(source, len(source.lines), len(source.lines[-1]) + 1)
        start = error.context_mark
        begins = f"it starts in line {start.line + 1}" if start else None
        message = ", ".join(filter(None, (error.context, error.problem))) or "not YAML"
        problems.add(mark, message, begins)
        raise problems.error() from error
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        problems.add(Mark(source, 1, 1), f"not YAML: {error}")
        raise problems.error() from error
    finally:
        loader.dispose()


def _mark_in(source: Source, mark: yaml.Mark | None) -> Mark:
    return Mark(source, mark.line + 1, mark.column + 1) if mark else Mark(source, 1, 1)


class StrictLoader(SafeLoader):
    """PyYAML's safe parser, composed into located values by the rules of this module."""

    def __init__(self, source: Source, problems: Problems, *, flow_only: bool) -> None:
        super().__init__(source.text)
        self._source = source
        self._problems = problems
        self._flow_only = flow_only

    def read_document(self) -> Node:
        """Read the one document of the text."""
        start = self._next()
        if isinstance(start, StreamStartEvent):
            start = self._next()
        if not isinstance(start, DocumentStartEvent):
            raise self._fatal(Mark(self._source, 1, 1), "the file is empty")
        if start.version or start.tags:
            self._problems.add(self._mark(start), "directives are not allowed")
        root = self._node(self._next(), 0)
        self._next()
        end = self._next()
        if not isinstance(end, StreamEndEvent):
            self._problems.add(self._mark(end), "a second document in one file")
        return root

    def _next(self) -> Event:
        event = self.get_event()
        assert event is not None
        return event

    def _mark(self, event: Event) -> Mark:
        start = event.start_mark
        assert start is not None
        return Mark(self._source, start.line + 1, start.column + 1)

    def _fatal(self, mark: Mark, message: str) -> ProfileError:
        self._problems.add(mark, message)
        return self._problems.error()

    def _node(self, event: Event, depth: int, key: Mark | None = None) -> Node:
        mark = self._mark(event)
        if isinstance(event, AliasEvent):
            self._problems.add_broken(mark, f"alias *{event.anchor} is not allowed")
            return Node(BROKEN, mark, key)
        if isinstance(event, NodeEvent) and event.anchor:
            self._problems.add(mark, f"anchor &{event.anchor} is not allowed")
        if isinstance(event, ScalarEvent | CollectionStartEvent) and event.tag:
            self._problems.add_broken(mark, "tags (!…) are not allowed")
        if isinstance(event, ScalarEvent):
            return Node(self._scalar(event, mark), mark, key)
        if depth >= MAX_DEPTH:
            raise self._fatal(mark, f"nested more than {MAX_DEPTH} levels deep")
        block = isinstance(event, CollectionStartEvent) and not event.flow_style
        if self._flow_only and block:
            raise self._fatal(mark, "write a mapping as {a: 1}, a list as [1, 2]")
        if isinstance(event, SequenceStartEvent):
            items: list[Node] = []
            while not isinstance(event := self._next(), SequenceEndEvent):
                items.append(self._node(event, depth + 1))
            return Node(items, mark, key)
        assert isinstance(event, MappingStartEvent)
        return Node(self._mapping(depth), mark, key)

    def _mapping(self, depth: int) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        while not isinstance(event := self._next(), MappingEndEvent):
            mark = self._mark(event)
            if not isinstance(event, ScalarEvent):
                raise self._fatal(mark, "a key must be plain text")
            key: str = event.value
            if event.anchor or event.tag:
                self._problems.add(mark, "anchors and tags are not allowed")
            if not key or _UNREADABLE_IN_TEXT.search(key) or "\n" in key:
                self._problems.add(mark, "a key must be text of one line")
            value = self._node(self._next(), depth + 1, key=mark)
            if key == "<<" and event.implicit[0]:
                self._problems.add(mark, "merge keys (<<) are not allowed", "use extends")
            elif key in entries:
                first = entries[key].heading
                self._problems.add(mark, f"{key} is here twice; first in line {first.line}")
            else:
                entries[key] = value
        return entries

    def _scalar(self, event: ScalarEvent, mark: Mark) -> Scalar:
        text: str = event.value
        if not event.implicit[0]:  # quoted, or a block of text
            if _UNREADABLE_IN_TEXT.search(text):
                self._problems.add_broken(mark, "the text holds a control character")
                return BROKEN
            return text
        if text in _WORDS:
            return _WORDS[text]
        if _LEADING_ZERO.fullmatch(text):
            self._problems.add_broken(
                mark,
                f"{text[:40]} has a leading zero",
                "write the number without it, or quote it if it is text",
            )
            return BROKEN
        if _INTEGER.fullmatch(text) and len(text) <= _EXACT_DIGITS:
            return int(text)
        if _HEXADECIMAL.fullmatch(text):
            return int(text, 16)
        if _FLOAT.fullmatch(text):
            return float(text)
        return text
