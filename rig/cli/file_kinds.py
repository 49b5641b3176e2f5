"""Whether a file is a rig's or an experiment's: told before it is loaded, errors and all."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

# Keys that only one of the two kinds of file has; the text is looked at, not parsed, so that
# a file with an error in it is still taken for what it is.
_PROFILE_KEY = re.compile(r"^(mechanism|loop|buses|devices|controllers|plant)\s*:", re.MULTILINE)
_EXPERIMENT_KEY = re.compile(r"^(rig|reference|metrics|controller|approach)\s*:", re.MULTILINE)
_BASE = re.compile(r"^extends\s*:\s*([^\s#]+)", re.MULTILINE)


def is_experiment(source: str, search: Sequence[Path]) -> bool:
    """Return whether a name or file is an experiment's and not a profile's.

    Raises
    ------
    ConfigurationError
        Nothing is called so; with the nearest name.
    """
    from rig.config.names import hint_of_name, is_path, list_files
    from rig.hal import ConfigurationError
    from rig.hal.files import is_file

    if is_path(source):
        text = _text_of(source)
        ours, others = _EXPERIMENT_KEY.findall(text), _PROFILE_KEY.findall(text)
        if len(ours) == len(others):  # a file that extends another may have neither
            base = _BASE.search(text)
            if base is not None and base[1] in list_files("experiments", search):
                return True
            return Path(os.path.realpath(source)).parent.name == "experiments"
        return len(ours) > len(others)
    rigs, experiments = list_files("rigs", search), list_files("experiments", search)
    if source in rigs:
        return False
    if source in experiments:
        return True
    if is_file(Path(f"{source}.yaml")):
        message = f"no rig or experiment is called {source!r}; did you mean the file {source}.yaml?"
        raise ConfigurationError(message)
    known = {**rigs, **experiments}
    hint = hint_of_name(source, ("rigs", "experiments"), search, known) or "there are none"
    raise ConfigurationError(f"no rig or experiment is called {source!r}; {hint}")


def experiment_of_same_name(source: str, search: Sequence[Path]) -> Path | None:
    """Return the file of the experiment that is called as a rig is; None: it is no name of both."""
    from rig.config.names import list_files

    both = source in list_files("rigs", search)
    return list_files("experiments", search).get(source) if both else None


def asks_of_experiment(overrides: Sequence[str]) -> bool:
    """Return whether a setting that is to be overridden is one that only experiments have."""
    keys = (re.split(r"[.=]", override, maxsplit=1)[0] for override in overrides)
    return any(_EXPERIMENT_KEY.match(f"{key}:") for key in keys)


def is_rig(source: str, search: Sequence[Path]) -> bool:
    """Return whether a text surely means a rig: by its name, or by a file with keys of one."""
    from rig.config.names import is_path, list_files

    rigs, experiments = list_files("rigs", search), list_files("experiments", search)
    if not is_path(source):
        return source in rigs and source not in experiments
    text = _text_of(source)
    if _EXPERIMENT_KEY.search(text):
        return False
    base = _BASE.search(text)
    extends_rig = base is not None and base[1] in rigs and base[1] not in experiments
    return extends_rig or _PROFILE_KEY.search(text) is not None


def refuse_rig(source: str, search: Sequence[Path], instead: str) -> None:
    """Refuse a rig where a command takes something else; `instead` is what to say.

    Raises
    ------
    ConfigurationError
        It is one.
    """
    from rig.hal import ConfigurationError

    if is_rig(source, search):
        raise ConfigurationError(f"{source} is a rig; {instead}")


def _text_of(source: str) -> str:
    from rig.config.yaml_loader import read_source
    from rig.hal import ConfigurationError

    try:
        return read_source(Path(source)).text
    except ConfigurationError:
        return ""  # the loader says what is wrong with it
