"""What `rig.sweep` may be given, checked by its kind before anything is read."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Final

import numpy as np

from rig.hal import ConfigurationError

_TEXT: Final = (str | NoneType, "a text")
_PATH: Final = (str | Path | NoneType, "a path")
_COUNT: Final = (int | NoneType, "a whole number")
_KINDS: Final[Mapping[str, tuple[UnionType | type, str]]] = {
    "experiment": (str | Path, "a name or a path"),
    "vary": (Mapping | NoneType, "a mapping of settings to their values"),
    "seeds": (str | Sequence | np.ndarray | NoneType, 'a text such as "0:20", or whole numbers'),
    "on": (str, "a backend"),
    "rig": _TEXT,
    "set": (Mapping | NoneType, "a mapping of settings to values"),
    "workers": _COUNT,
    "dask": _TEXT,
    "out": _PATH,
    "configs": _PATH,
    "stop_when": _TEXT,
    "budget": _TEXT,
    "metric": _TEXT,
    "keep": (int, "a whole number"),
    "draw_seed": (int, "a whole number"),
    "quiet": (bool, "True or False"),
}


def check_arguments(given: Mapping[str, object]) -> None:
    """Refuse what is of another kind than it must be.

    Parameters
    ----------
    given : mapping
        The arguments of `rig.sweep` by their names.

    Raises
    ------
    ConfigurationError
        With the argument, and what it must be.
    """
    for name, (kind, what) in _KINDS.items():
        value = given[name]
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise ConfigurationError(f"{name} is {value!r}, and must be {what}")
    for name in ("vary", "set"):
        for key in given[name] or ():  # type: ignore[attr-defined]  # it is a mapping by now
            if not isinstance(key, str):
                raise ConfigurationError(f"{name}: {key!r} is no name of a setting")
