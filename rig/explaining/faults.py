"""What may stop a run, or keep it from beginning: what it means, its causes, what mends it."""

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple, TypedDict, cast

from rig.config.yaml_loader import read_plain

_HERE = Path(__file__).parent


class _Entry(TypedDict):
    """A topic as the file has it."""

    says: list[str]
    means: str
    causes: str
    check: str
    mend: str


class FaultTopic(NamedTuple):
    """A kind of fault, for people.

    Parameters
    ----------
    name : str
        What `rig explain` calls it.
    says : tuple of re.Pattern
        What its messages say.
    means, causes, check, mend : str
        A sentence or two each. RIG, RUN and EXPERIMENT stand for the user's.
    """

    name: str
    says: tuple[re.Pattern[str], ...]
    means: str
    causes: str
    check: str
    mend: str

    def remarks(self) -> list[tuple[str, str]]:
        """Return labels and texts, in the order in which they are told."""
        labels = ("means", "causes", "check", "mend")
        return [("kind", self.name), *((label, getattr(self, label)) for label in labels)]


@cache
def fault_topics() -> tuple[FaultTopic, ...]:
    """Return every kind of fault, in the order in which a message is held against them."""
    return _topics_in(_HERE / "faults.yaml")


@cache
def refusal_topics() -> tuple[FaultTopic, ...]:
    """Return every kind of refusal before anything moves, in that order."""
    return _topics_in(_HERE / "refusals.yaml")


def _topics_in(path: Path) -> tuple[FaultTopic, ...]:
    entries = cast("dict[str, _Entry]", read_plain(path))
    return tuple(
        FaultTopic(
            name,
            tuple(re.compile(pattern, re.IGNORECASE) for pattern in entry["says"]),
            entry["means"],
            entry["causes"],
            entry["check"],
            entry["mend"],
        )
        for name, entry in entries.items()
    )


def topic_of(message: str) -> FaultTopic | None:
    """Return the kind of fault that a message tells of; None if no topic knows it."""
    return _told_by(message, fault_topics())


def refusal_of(message: str) -> FaultTopic | None:
    """Return the kind of refusal that a message tells of; None if no topic knows it."""
    return _told_by(message, refusal_topics())


def _told_by(message: str, topics: tuple[FaultTopic, ...]) -> FaultTopic | None:
    for topic in topics:
        if any(pattern.search(message) for pattern in topic.says):
            return topic
    return None
