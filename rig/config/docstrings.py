"""Read descriptions of parameters from NumPy docstrings, for the schema of an editor."""

import inspect
import re
from functools import lru_cache

_NAMES = re.compile(r"(\w+(?:, \w+)*)(?: :.*)?")


@lru_cache(maxsize=256)
def parameter_texts(documented: type) -> dict[str, str]:
    """Return the text of every parameter by name; parameters described together share it.

    What a class takes over from its bases is described there.
    """
    inherited: dict[str, str] = {}
    for base in reversed(documented.__bases__):
        inherited |= {} if base is object else parameter_texts(base)
    lines = inspect.cleandoc(documented.__doc__ or "").splitlines()
    found: dict[str, list[str]] = {}
    names: list[str] = []
    inside = False
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if following and not following.strip("-"):
            inside, names = line == "Parameters", []
        elif inside and line and not line.startswith((" ", "-")):
            match = _NAMES.fullmatch(line)
            names = match.group(1).split(", ") if match else []
        elif line.startswith(" "):
            for name in names:
                found.setdefault(name, []).append(line.strip())
    return inherited | {name: " ".join(text) for name, text in found.items()}
