"""A table of text out of a CSV or a YAML file, whose cells know where they stand.

Both say the same: a header that names each column with its unit, and rows of numbers.

    x (mm), y (mm), z (mm)          columns: [x (mm), y (mm), z (mm)]
    100, 0, 20                      rows:
    120, 0, 25                        - [100, 0, 20]
                                      - [120, 0, 25]
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

from controllers.motion import InfeasibleMotion
from controllers.text_file import read_lines, read_table

_MOST: Final = 1 << 20
"""Characters of a YAML file, whose parser is slower than that of CSV by two orders."""
_SUFFIXES: Final = (".yaml", ".yml")
_COLUMNS, _ROWS = "columns", "rows"
_KEYS: Final = (_COLUMNS, _ROWS)


class TextCell(NamedTuple):
    """A piece of text and its place: of CSV the line and the cell's number, else the character's.

    Parameters
    ----------
    text : str
        Without blanks around it.
    line, column : int
        From 1.
    """

    text: str
    line: int
    column: int

    @property
    def where(self) -> str:
        """The place in words."""
        return f"line {self.line}, column {self.column}"


class TextRow(NamedTuple):
    """The cells of a row, and the line in which it begins."""

    line: int
    cells: list[TextCell]


class TextTable(NamedTuple):
    """The header of a file, and the rows below it that are not empty."""

    header: TextRow
    rows: list[TextRow]


def read_cells(path: Path) -> TextTable:
    """Return a file's table: YAML if it is called so, else CSV.

    Raises
    ------
    InfeasibleMotion
        It cannot be read, or is no table; with the line and what is wrong there.
    """
    return _yaml(path) if path.suffix.lower() in _SUFFIXES else _csv(path)


def _csv(path: Path) -> TextTable:
    rows = [
        TextRow(line, [TextCell(text, line, column) for column, text in enumerate(cells, 1)])
        for line, cells in read_table(path)
    ]
    return TextTable(rows[0] if rows else TextRow(1, []), rows[1:])


def _yaml(path: Path) -> TextTable:
    text = "\n".join(read_lines(path))
    if len(text) > _MOST:
        raise InfeasibleMotion(f"{path}: it has more than {_MOST} characters; CSV may have more.")
    import yaml  # an arm that reads no file does without

    try:
        return _Document(path, _events(text)).table()
    except InfeasibleMotion:
        raise
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise InfeasibleMotion(f"{path}{where}: {error.problem or 'it is not YAML'}.") from error
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        said = " ".join(str(error).split())
        raise InfeasibleMotion(f"{path}: it is not YAML: {said}.") from error


class _Event(NamedTuple):
    """A find of the parser: the name of its kind, the text of a scalar, and its place."""

    kind: str
    cell: TextCell


def _events(text: str) -> Iterator[_Event]:
    """Yield what is in a document, as far as this subset of YAML knows it."""
    import yaml
    from yaml.events import DocumentStartEvent, NodeEvent, StreamStartEvent

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    for event in yaml.parse(text, Loader=loader):
        if isinstance(event, StreamStartEvent | DocumentStartEvent):
            continue
        mark = event.start_mark
        assert mark is not None
        cell = TextCell(str(getattr(event, "value", "")).strip(), mark.line + 1, mark.column + 1)
        named = isinstance(event, NodeEvent) and (event.anchor or getattr(event, "tag", None))
        yield _Event("Name" if named else type(event).__name__.removesuffix("Event"), cell)


class _Document:
    """The reader of one document: a mapping of `columns` and `rows`."""

    def __init__(self, path: Path, events: Iterator[_Event]) -> None:
        self._path, self._events = path, events

    def table(self) -> TextTable:
        """Return what the document says."""
        event = next(self._events)
        if event.kind == "StreamEnd":
            raise InfeasibleMotion(f"{self._path}: the file is empty; it has columns and rows.")
        self._expect(event, "MappingStart", "the document has to be a mapping of columns and rows")
        header: TextRow | None = None
        rows: list[TextRow] | None = None
        while (key := next(self._events)).kind != "MappingEnd":
            self._expect(key, "Scalar", "a key has to be text")
            name = key.cell.text
            if name not in _KEYS:
                raise self._wrong(key.cell, f"{name[:40]!r} is no key; there are columns and rows")
            if (header if name == _COLUMNS else rows) is not None:
                raise self._wrong(key.cell, f"{name} is there already")
            start = next(self._events)
            if name == _COLUMNS:
                header = self._row(start, "columns has to be a list of names with their units")
            else:
                rows = self._rows(start)
        end = next(self._events)
        after = next(self._events)
        if after.kind != "StreamEnd":
            raise self._wrong(after.cell, "a second document in one file")
        if header is None or rows is None:
            missing = _COLUMNS if header is None else _ROWS
            raise self._wrong(end.cell, f"the file has no {missing}")
        return TextTable(header, rows)

    def _rows(self, start: _Event) -> list[TextRow]:
        self._expect(start, "SequenceStart", "rows has to be a list of lists of numbers")
        rows = []
        while (event := next(self._events)).kind != "SequenceEnd":
            rows.append(self._row(event, "a row has to be a list of numbers"))
        return rows

    def _row(self, start: _Event, wanted: str) -> TextRow:
        self._expect(start, "SequenceStart", wanted)
        cells = []
        while (event := next(self._events)).kind != "SequenceEnd":
            self._expect(event, "Scalar", wanted)
            cells.append(event.cell)
        return TextRow(start.cell.line, cells)

    def _expect(self, event: _Event, kind: str, wanted: str) -> None:
        if event.kind in ("Name", "Alias"):
            raise self._wrong(event.cell, "anchors, aliases and tags have no place in this file")
        if event.kind != kind:
            raise self._wrong(event.cell, wanted)

    def _wrong(self, cell: TextCell, what: str) -> InfeasibleMotion:
        return InfeasibleMotion(f"{self._path}, {cell.where}: {what}.")
