"""The forms in which steps take answers: each says what it expects of one that is none."""

from collections.abc import Callable, Sequence
from math import inf

from rig.config.quantities import UnitError, parse_reading

Form = Callable[[str], str]
"""Returns what is expected in the place of an answer; empty: the answer will do."""


def anything(answer: str) -> str:
    """Take any text."""
    return ""


def one_of(*words: str) -> Form:
    """Return a form that takes a few words; of ``yes`` and ``no`` their first letters, too."""
    taken = {*words, *(word[0] for word in words if word in ("yes", "no"))}

    def check(answer: str) -> str:
        return "" if answer.strip().lower() in taken else " or ".join(words)

    return check


def reading(unit: str, example: str, least: float = -inf) -> Form:
    """Return a form that takes what an instrument shows.

    Parameters
    ----------
    unit : str
        Of SI.
    example : str
        As somebody would write it.
    least : float, optional
        Less tells nothing, SI.
    """

    def check(answer: str) -> str:
        try:
            value = parse_reading(answer, unit)
        except UnitError as error:
            return f"a reading as {example}: {error}"
        return "" if value >= least else f"at least {least:.3g} {unit}"

    return check


def whose_reading(names: Sequence[str], unit: str, example: str, *, or_none: bool = False) -> Form:
    """Return a form that takes which of several instruments shows most, and how much.

    Parameters
    ----------
    names : sequence of str
        Of the instruments.
    unit, example : str
        As for `reading`; the example without a name.
    or_none : bool
        It may be ``none``.
    """
    told = reading(unit, f"{names[0]} {example}")

    def check(answer: str) -> str:
        whose, _, shown = answer.strip().partition(" ")
        if or_none and whose.lower() in ("", "none"):
            return ""
        if whose not in names:
            return f"one of {', '.join(names)} and what it shows, as {names[0]} {example}"
        return told(shown)

    return check
