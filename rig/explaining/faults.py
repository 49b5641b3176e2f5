"""What may stop a run: what it means, its usual causes, how to tell them apart, what mends it."""

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple, TypedDict, cast

from rig.config.yaml_loader import read_plain

_TOPICS = Path(__file__).with_name("faults.yaml")


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
    entries = cast("dict[str, _Entry]", read_plain(_TOPICS))
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
    for topic in fault_topics():
        if any(pattern.search(message) for pattern in topic.says):
            return topic
    return None
