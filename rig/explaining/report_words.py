"""Words that reports, tables, messages and options have, and no file: what each means."""

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import cast

from rig.config.yaml_loader import read_plain

_FILE = Path(__file__).with_name("words.yaml")
_BESIDE = re.compile(r"(?: \(.*\)|: ?\S*|(?<=[A-Z])\d+)$")
"""Behind a word: a unit, what it is of (``calibrated: encoders``), a number (``TPDO1``)."""


@cache
def report_words() -> Mapping[str, str]:
    """Return what each word means."""
    return cast("Mapping[str, str]", read_plain(_FILE))


def report_word(text: str) -> str | None:
    """Return the word that somebody means, as it is written here, or None.

    Capitals do not matter, and neither does what a heading has behind it.
    """
    known = {word.lower(): word for word in report_words()}
    asked = text.strip()
    return known.get(asked.lower()) or known.get(_BESIDE.sub("", asked).lower())
