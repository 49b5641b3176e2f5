"""The text of code that no package holds, for the run folder."""

import inspect
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
