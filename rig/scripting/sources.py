"""The code that no package holds: its text, for the run folder, and its lines, for messages."""

import inspect
import traceback
from pathlib import Path
from types import FunctionType


def keep_source(given: object, sources: dict[str, str]) -> str:
    """Keep the text of an object's code; return the object's name.

    Parameters
    ----------
    given : object
        A function, a class or an instance of one.
    sources : dict
        Takes the text, by its path in the run folder: of the whole file, or of the cell.
    """
    named = given if isinstance(given, type | FunctionType) else type(given)
    name = "".join(c if c.isalnum() else "-" for c in named.__name__).strip("-") or "given"
    try:
        file = inspect.getsourcefile(named)
        whole = Path(file).read_text(encoding="utf-8") if file and Path(file).is_file() else ""
        text = whole or inspect.getsource(named)
    except (OSError, TypeError):
        text = f"# {named!r}: its source cannot be had\n"
    sources[f"code/{name}.py"] = text
    return name


def line_of(error: BaseException) -> str:
    """Return the file and line of somebody's code that an error came from, as messages say it.

    Of the code that was called where the error is caught; what it called in turn is not said.
    """
    called = traceback.extract_tb(error.__traceback__)[1:]
    own = [frame for frame in called if frame.filename == called[0].filename]
    return f" ({own[-1].filename}, line {own[-1].lineno})" if own else ""


def first_line_of(function: object) -> str:
    """Return the file and first line of a function, as messages say it; empty of what has none."""
    code = getattr(inspect.unwrap(function) if callable(function) else function, "__code__", None)
    return f" ({code.co_filename}, line {code.co_firstlineno})" if code is not None else ""
