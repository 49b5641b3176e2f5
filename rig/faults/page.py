"""The page of a campaign: the reaction table, and every case in which something is wrong."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from rig.faults.table import CASE_HEADER, HEADER, SUM, Row, case_cells, used_columns
from rig.faults.uncounted import say_uncounted
from rig.faults.verdict import Verdict
from rig.report.markup import NOTHING, Html, element, join, page, section, table
from rig.whole_file import write_whole

MOST_CASES = 100
"""Of more than so many, the page lists only what needs a look."""


def write_page(path: Path, title: str, rows: Sequence[Row], verdicts: Sequence[Verdict]) -> None:
    """Write the page; it needs no network and runs nothing."""
    failed = [verdict for verdict in verdicts if verdict.failed]
    verdict = f"{len(failed)} of {len(verdicts)} cases went wrong" if failed else "nothing is wrong"
    left = say_uncounted(verdicts)
    notes = [element("p", f"{note}.") for note in (verdict, left) if note]
    header = element("header", element("h1", title), *notes)
    write_whole(
        path, page(title, header, _table(rows), _failures(failed), _cases(verdicts), width="90rem")
    )


def _table(rows: Sequence[Row]) -> Html:
    sums_first = sorted(rows, key=lambda row: row.fault != SUM)
    cells = [row.cells() for row in sums_first]
    styles = ["fail" if any(row.wrongs) else "" for row in sums_first]
    told = "A phase shows its cases, and after an exclamation mark those that went wrong."
    used, empty = used_columns(rows)
    none = f" None: {', '.join(empty)}." if empty else ""
    head = [_breakable(HEADER[k]) for k in used]
    body = [[_breakable(row[k]) for k in used] for row in cells]
    shown = table("Reactions", head, body, styles=styles)
    return section("Reactions", element("p", told + none), shown)


def _breakable(text: str) -> Html:
    """Return a name or three times that go on in the next line where a cell is too narrow."""
    return join(re.split(r"(?<=[_/])", text), "<wbr>")


def _failures(failed: Iterable[Verdict]) -> Html:
    parts = [part for verdict in failed for part in _failure(verdict)]
    return section("What went wrong", *parts) if parts else NOTHING


def _cases(verdicts: Sequence[Verdict]) -> Html:
    """Return what came of each case, those first that ended in a hazard; of many, only of those."""
    shown = verdicts if len(verdicts) <= MOST_CASES else [v for v in verdicts if v.ending.excused]
    ordered = sorted(shown, key=lambda one: (not one.failed, not one.ending.excused))
    if not ordered:
        return NOTHING
    few = "" if shown is verdicts else " with a hazard that is not counted"
    cells = [[*map(_breakable, case_cells(one)), "; ".join(one.uncounted())] for one in ordered]
    head = [*CASE_HEADER, "not counted"]
    styles = ["fail" if one.failed else "" for one in ordered]
    title = f"What came of each case{few}"
    return section(title, table("Cases", head, cells, styles=styles))


def _failure(verdict: Verdict) -> Iterable[Html]:
    case = verdict.case
    places = " + ".join(item.where for item in case.breaks)
    yield element("h3", f"{' + '.join(case.kinds)} at {places}, {case.moment}")
    for wrong in verdict.wrongs():
        yield element("p", wrong)
    yield element("pre", case.command)
