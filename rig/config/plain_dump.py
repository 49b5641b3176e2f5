"""Write plain data as YAML that the strict loader reads back as it was."""

import re
from collections.abc import Mapping
from typing import Final

import yaml

_LIKE_A_NUMBER: Final = re.compile(r"[-+]?(0x[0-9a-fA-F]+|[0-9]*\.?[0-9]*([eE][-+]?[0-9]+)?)")
"""PyYAML takes `178e9576` for text and leaves its quotes out; the strict loader reads a number."""


class _Dumper(yaml.SafeDumper):
    """Quotes every text that may be read as a number."""


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = '"' if _LIKE_A_NUMBER.fullmatch(text) else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent_text)


def dump_plain(content: Mapping[str, object]) -> str:
    """Return plain data as YAML text, its keys in their order.

    Parameters
    ----------
    content : mapping
        Texts, numbers, truth values, and lists and mappings of them.

    Returns
    -------
    str
    """
    return yaml.dump(dict(content), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)


def plain_text(text: str) -> str:
    """Return a text as a value in YAML: quoted where it would be read as something else.

    Parameters
    ----------
    text : str
        Of one line: a name or a path.

    Returns
    -------
    str
        ``crank``, but ``'null'``.
    """
    line = yaml.dump(text, Dumper=_Dumper, allow_unicode=True, width=float("inf"))
    return line.removesuffix("...\n").removesuffix("\n")
