"""Errors of configuration files: where, what, and the nearest valid name."""

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rig.config.located import Mark, Source
from rig.config.unitless import Unitless
from rig.hal import ConfigurationError

_WIDTH = 96
"""Longest excerpt of a line that is shown, characters."""

_SHOWN = 100
"""Most errors that are written out: a file with more is no profile at all."""


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One error at one place.

    Parameters
    ----------
    mark : Mark
        Where.
    message : str
        What is wrong, with the value and the bound that it broke.
    hint : str, optional
        What would be right.
    """

    mark: Mark
    message: str
    hint: str | None = None

    def __str__(self) -> str:
        parts = [f"{self.mark}: {self.message}", *_excerpt(self.mark)]
        if self.hint:
            parts.append(f"    {self.hint}")
        return "\n".join(parts)


class ProfileError(ConfigurationError):
    """A profile, experiment or calibration is not valid; all of its errors at once.

    Parameters
    ----------
    diagnostics : sequence of Diagnostic
        Those with a place of their own.
    besides : sequence of str
        What is wrong with one part of the file beside another, after all of those.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic], besides: Sequence[str] = ()) -> None:
        self.diagnostics = tuple(diagnostics)
        told = [*map(str, self.diagnostics), *besides]
        count, parts = len(told), told[:_SHOWN]
        if count > _SHOWN:
            parts.append(f"… and {count - _SHOWN} more")
        if count > 1:
            parts.append(f"{count} errors")
        super().__init__("\n".join(parts))


class Problems:
    """The errors found so far in one document and the files that it draws in."""

    def __init__(self) -> None:
        self._found: dict[tuple[Mark, str], Diagnostic] = {}
        self._broken: set[Mark] = set()
        self._partial: set[Source] = set()
        self.unitless: dict[Unitless, None] = {}
        """Numbers without a unit, which are no errors; each once, in their order."""

    def __bool__(self) -> bool:
        return bool(self._found)

    @property
    def are_many(self) -> bool:
        """Whether no more of them will be written out, nor what would help with one."""
        return len(self._found) > _SHOWN

    def add(self, mark: Mark, message: str, hint: str | None = None) -> None:
        """Note an error, unless the value there is known to be unreadable."""
        missing = mark.source in self._partial and message.endswith(" is missing")
        if mark not in self._broken and not missing:
            self._found.setdefault((mark, message), Diagnostic(mark, message, hint))

    def add_broken(self, mark: Mark, message: str, hint: str | None = None) -> None:
        """Note an error that makes the value there unreadable: others there would be noise."""
        self.add(mark, message, hint)
        self._broken.add(mark)

    def hush_missing(self, source: Source) -> None:
        """Take no error that a key is missing in a file: it is known to be a part of the whole."""
        self._partial.add(source)

    def error(self) -> ProfileError:
        """Return everything as one exception, in the order of the files and lines."""
        order = {source: i for i, source in enumerate(m.source for m, _ in self._found)}
        ordered = sorted(
            self._found.values(),
            key=lambda d: (order[d.mark.source], d.mark.line, d.mark.column),
        )
        return ProfileError(ordered)

    def raise_if_any(self) -> None:
        """Raise what was found.

        Raises
        ------
        ProfileError
            Something was found.
        """
        if self._found:
            raise self.error()


def nearest(name: str, names: Iterable[str]) -> str | None:
    """Return a hint: the name most like a wrong one, or what there is where none is like it."""
    valid = sorted(set(names))
    if not valid:
        return None
    close = difflib.get_close_matches(name[:64], valid, n=1, cutoff=0.6)
    return f"did you mean {close[0]}?" if close else f"there are: {', '.join(valid)}"


def shown(value: object) -> str:
    """Describe a plain value as a file's author knows it."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return repr(value if len(value) <= 40 else value[:39] + "…")
    if isinstance(value, int | float):
        return f"{value:g}" if isinstance(value, float) else str(value)
    return "a mapping" if isinstance(value, dict) else "a list"


def _excerpt(mark: Mark) -> list[str]:
    """Return the marked line and a caret below the column, cut to a width."""
    lines = mark.source.lines
    if mark.source.is_whole or not 1 <= mark.line <= len(lines):
        return []
    line = "".join(
        char if char.isprintable() else "\N{REPLACEMENT CHARACTER}" for char in lines[mark.line - 1]
    )
    column = min(mark.column - 1, len(line))
    start = max(0, column - _WIDTH * 2 // 3) if len(line) > _WIDTH else 0
    return [
        f"    {line[start : start + _WIDTH].rstrip()}",
        f"    {' ' * (column - start)}^",
    ]
