"""Which runs somebody asks for: ``marker_rms < 0.2 mm and rig = joint``."""

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

from rig.config.diagnostics import nearest
from rig.config.quantities import parse_quantity
from rig.hal import ConfigurationError
from rig.run_facts import RunStatus

NAMES: Final = ("status", "rig", "experiment", "law", "backend", "name")
"""What a run is asked for by beside its metrics: words, compared for equality."""

_COMPARE: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "<=": operator.le, ">=": operator.ge, "!=": operator.ne, "==": operator.eq,
    "<": operator.lt, ">": operator.gt, "=": operator.eq,
}  # fmt: skip
_TERM: Final = re.compile(r"\s*([A-Za-z][\w.-]*)\s*(<=|>=|!=|==|=|<|>)\s*(.*?)\s*", re.DOTALL)
_AND: Final = re.compile(r"\s+and\s+")


class Candidate(NamedTuple):
    """A run, as it is asked for.

    Parameters
    ----------
    words : mapping
        Its values of `NAMES`.
    metrics : mapping
        Value (SI) and unit of its metrics; NaN of one that has no value.
    """

    words: Mapping[str, object]
    metrics: Mapping[str, tuple[float, str]]


class Term(NamedTuple):
    """One comparison.

    Parameters
    ----------
    name : str
        A metric, or one of `NAMES`.
    sign : str
        How it is compared.
    text : str
        With what: a word, or a number with its unit.
    """

    name: str
    sign: str
    text: str

    def holds(self, words: Mapping[str, object], metrics: Mapping[str, tuple[float, str]]) -> bool:
        """Return whether it is true of a run.

        Parameters
        ----------
        words : mapping
            Its values of `NAMES`.
        metrics : mapping
            Value (SI) and unit of its metrics. A run that has no such metric is not found.

        Raises
        ------
        ConfigurationError
            The metric has another unit.
        """
        if self.name in NAMES:
            return (words.get(self.name) == self.text) is (self.sign != "!=")
        if self.name not in metrics:
            return False
        value, unit = metrics[self.name]
        try:
            asked = parse_quantity(self.text, unit or "1")
        except ValueError as error:
            raise ConfigurationError(f"--where: {self.name}: {error}") from error
        return not math.isnan(value) and _COMPARE[self.sign](value, asked)


def choose(where: str, runs: Sequence[Candidate]) -> list[bool]:
    """Return of each run whether all that is asked is true of it.

    Parameters
    ----------
    where : str
        See `parse_query`.
    runs : sequence of Candidate
        The runs. A metric that none of them has is a slip of the pen, and no answer.

    Raises
    ------
    ConfigurationError
        It is no question, or asks for a status or a metric that there is not.
    """
    terms = parse_query(where)
    metrics = sorted({name for run in runs for name in run.metrics})
    statuses = list(dict.fromkeys([*RunStatus, *(str(run.words.get("status")) for run in runs)]))
    for term in terms:
        if term.name == "status" and term.text not in statuses:
            raise ConfigurationError(
                f"--where: no run has the status {term.text!r}; {nearest(term.text, statuses)}"
            )
        if runs and term.name not in (*NAMES, *metrics):
            raise ConfigurationError(
                f"--where: no run here has a metric {term.name!r}; "
                f"{nearest(term.name, (*NAMES, *metrics))}"
            )
    return [all(term.holds(*run) for term in terms) for run in runs]


def parse_query(text: str) -> tuple[Term, ...]:
    """Return the comparisons of which all have to be true.

    Raises
    ------
    ConfigurationError
        It is not ``name < number unit``, joined by ``and``.
    """
    terms = []
    for part in _AND.split(text):
        found = _TERM.fullmatch(part)
        if found is None or not found[3]:
            raise ConfigurationError(
                f"--where: {part.strip()!r} is no comparison such as marker_rms < 0.2 mm, or "
                "status = ok; several are joined by and"
            )
        name, sign, value = found.groups()
        if name in NAMES and sign not in ("=", "==", "!="):
            raise ConfigurationError(f"--where: {name} is a word, and is compared with = or !=")
        terms.append(Term(name, sign, value.strip("'\"") if name in NAMES else value))
    return tuple(terms)
