"""Mutants that no test can tell from the file itself, each with the reason."""

from typing import NamedTuple


class Equivalent(NamedTuple):
    """One such mutant.

    Parameters
    ----------
    path : str
        The file.
    line : str
        Its line, without the spaces around it.
    change : str
        The code before and after.
    why : str
        Nothing that can be seen differs.
    """

    path: str
    line: str
    change: str
    why: str


EQUIVALENTS: tuple[Equivalent, ...] = ()
