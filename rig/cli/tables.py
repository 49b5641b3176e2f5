"""Tables on stdout: drawn by rich for a person at a terminal, plain columns for a pipe."""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Final, NamedTuple

import click

from rig.terminals import is_terminal

_OBEYED: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters but line feed and tab, what turns the direction of a text, half characters."""
_LONGEST_LINE: Final = 5000
"""Characters: a path has 4095 at most."""


class Table(NamedTuple):
    """Rows of text under a title.

    Parameters
    ----------
    title : str
        One word or a short sentence.
    header : tuple of str
        Names of the columns.
    rows : sequence of tuple of str
        As wide as `header`.
    """

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def visible(text: str) -> str:
    """Return a text without what a terminal would obey: files and devices of others say it too."""
    return _OBEYED.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def brief(text: str) -> str:
    """Return a text with the middle left out of lines that nobody reads to their end."""
    return "\n".join(
        line if len(line) <= _LONGEST_LINE else f"{line[: _LONGEST_LINE - 200]} … {line[-200:]}"
        for line in text.split("\n")
    )


def print_tables(tables: Sequence[Table]) -> None:
    """Print tables that have rows, one below the other."""
    shown = [
        Table(visible(t.title), t.header, [tuple(map(visible, row)) for row in t.rows])
        for t in tables
        if t.rows
    ]
    if not shown:
        return
    if is_terminal(sys.stdout):
        _draw(shown)
    else:
        print_data("\n\n".join(_plain(table) for table in shown))


_printed: list[int] = []
"""Lengths of all that was printed: whether anything was is asked after an error."""


def printed_so_far() -> int:
    """Return how often data have been printed by this process."""
    return len(_printed)


def print_data(text: str) -> None:
    """Print text on stdout; a reader that has had enough (`rig list | head`) is no error."""
    _printed.append(len(text))
    try:
        click.echo(visible(text))
        sys.stdout.flush()
    except BrokenPipeError:
        abandon_stdout()


def print_json(content: object) -> None:
    """Print data as JSON on stdout: what is no finite number is null, as JSON knows no other."""
    print_data(json.dumps(finite(content), indent=2, ensure_ascii=False, allow_nan=False))


def finite(content: object) -> object:
    """Return data as JSON can have them: paths as text, and no number that is not finite."""
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, Mapping):
        return {str(key): finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [finite(value) for value in content]
    return str(content) if isinstance(content, PurePath) else content


def abandon_stdout() -> None:
    """Say nothing more on stdout, whose reader has gone.

    click would exit with 1, which here means a missed bound. What is still in the buffer goes
    nowhere, or the interpreter would complain at its exit.
    """
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def _draw(tables: Sequence[Table]) -> None:
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table as Drawing

    console = Console(highlight=False)
    for table in tables:
        drawing = Drawing(
            title=escape(table.title), title_justify="left", title_style="bold", box=box.SIMPLE_HEAD
        )
        for name in table.header:
            drawing.add_column(escape(name), overflow="fold")
        for row in table.rows:
            drawing.add_row(*(escape(cell) for cell in row))
        console.print(drawing)


def _plain(table: Table) -> str:
    lines = [table.header, *table.rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(table.header))]
    texts = [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    ]
    return "\n".join([f"# {table.title}", *texts])
