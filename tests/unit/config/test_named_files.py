"""Files that settings name are found beside the file that says them, however deep they stand."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest
from annotated_types import Ge

from rig.config.diagnostics import Problems, ProfileError
from rig.config.document import parse_mapping
from rig.config.located import Source
from rig.config.settings import build


@dataclass(frozen=True)
class Inner:
    """Named by the others."""

    file: Path | None = None
    count: Annotated[int, Ge(0)] = 0


@dataclass(frozen=True)
class InMapping:
    """A file under any key."""

    parts: dict[str, Inner]


@dataclass(frozen=True)
class InList:
    """A file at any position."""

    parts: tuple[Inner, ...]


@dataclass(frozen=True)
class InChoice:
    """A file in one of two alternatives."""

    parts: Annotated[float, Ge(0)] | Inner


@dataclass(frozen=True)
class InNone:
    """No file, though a text."""

    parts: str


def built(settings, folder, content):
    path = folder / "rig.yaml"
    path.write_text(content)
    problems = Problems()
    made = build(settings, parse_mapping(Source(str(path), content), problems), problems)
    problems.raise_if_any()
    return made


@pytest.mark.parametrize(
    ("settings", "content", "found"),
    [
        (InMapping, "parts: {a: {file: curve.csv}}", lambda made: made.parts["a"].file),
        (InList, "parts: [{}, {file: curve.csv}]", lambda made: made.parts[1].file),
        (InChoice, "parts: {file: curve.csv}", lambda made: made.parts.file),
    ],
    ids=("in a mapping", "in a list", "in a choice"),
)
def test_a_file_is_found_beside_what_names_it(tmp_path, settings, content, found):
    assert found(built(settings, tmp_path, content)) == tmp_path / "curve.csv"


def test_what_is_no_file_stays_as_it_is(tmp_path):
    assert built(InNone, tmp_path, "parts: curve.csv").parts == "curve.csv"


def test_a_text_that_is_read_again_is_what_it_is_now(tmp_path):
    assert [built(InNone, tmp_path, f"parts: {text}").parts for text in "aba"] == ["a", "b", "a"]


def test_the_same_text_in_another_folder_names_another_file(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        made = built(InList, tmp_path / name, "parts: [{file: curve.csv}]")
        assert made.parts[0].file == tmp_path / name / "curve.csv"


def test_what_is_wrong_is_told_each_time_it_is_read(tmp_path):
    for _ in range(2):
        with pytest.raises(ProfileError, match=r"rig\.yaml:2:1: parts is here twice"):
            built(InNone, tmp_path, "parts: a\nparts: b\n")
