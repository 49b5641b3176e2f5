"""A name in the three forms that files need."""

import keyword
import re
import sys
from importlib import metadata, util
from typing import Final, NamedTuple

from rig.hal import ConfigurationError

_NAME: Final = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_LONGEST: Final = 40


class Spelling(NamedTuple):
    """A name as profiles, modules and classes have it.

    Parameters
    ----------
    dashed, module, class_name : str
        ``fast-pi``, ``fast_pi``, ``FastPi``.
    """

    dashed: str
    module: str
    class_name: str


def spell(name: str) -> Spelling:
    """Return a name in its three forms.

    Raises
    ------
    ConfigurationError
        Files, modules or classes cannot be called so.
    """
    module = name.replace("-", "_")
    if keyword.iskeyword(module):
        raise ConfigurationError(f"{name} is a word of Python's own; choose another name")
    if not _NAME.fullmatch(name) or len(name) > _LONGEST:
        raise ConfigurationError(
            f"{name!r} is no name for files and modules: small letters and digits, words apart by "
            f"dashes, at most {_LONGEST} characters, as in fast-pi"
        )
    return Spelling(name, module, "".join(part.capitalize() for part in name.split("-")))


def refuse_taken(name: str) -> None:
    """Refuse a package's name that an import or pip would mean something else by.

    Raises
    ------
    ConfigurationError
        The standard library or an installed package is called so.
    """
    module = spell(name).module
    if module in sys.stdlib_module_names:
        raise ConfigurationError(f"{module} is a module of Python's own; choose another name")
    spec = util.find_spec(module)
    # A folder without __init__.py, which the working directory may have, is no package.
    if spec is not None and spec.origin is not None:
        raise ConfigurationError(f"a package {module} is installed already; choose another name")
    try:
        metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return
    raise ConfigurationError(f"a package {name} is installed already; choose another name")
