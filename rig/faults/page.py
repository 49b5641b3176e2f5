"""The page of a campaign: the reaction table, and every case in which something is wrong."""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from rig.faults.table import HEADER, SUM, Row
from rig.faults.verdict import Verdict


def write_page(path: Path, title: str, rows: Sequence[Row], verdicts: Sequence[Verdict]) -> None:
    """Write the page; it needs no network and runs nothing."""
    import rig.report

    css = Path(rig.report.__file__).with_name("report.css").read_text(encoding="utf-8")
    failed = [verdict for verdict in verdicts if verdict.failed]
    verdict = f"{len(failed)} of {len(verdicts)} cases went wrong" if failed else "nothing is wrong"
    path.write_text(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
        "style-src 'unsafe-inline'\">\n"
        f"<title>{escape(title)}</title>\n<style>\n{css}main {{ max-width: 90rem; }}\n</style>\n"
        f"</head>\n<body>\n<main>\n<header><h1>{escape(title)}</h1><p>{escape(verdict)}.</p>"
        f"</header>\n{_table(rows)}\n{_failures(failed)}\n</main>\n</body>\n</html>\n",
        encoding="utf-8",
    )


def _table(rows: Sequence[Row]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in HEADER)
    sums_first = sorted(rows, key=lambda row: row.fault != SUM)
    body = "\n".join(_row(row) for row in sums_first)
    return (
        "<section><h2>Reactions</h2>\n<p>A phase shows its cases, and after an exclamation mark "
        "those that went wrong.</p>\n"
        f'<div class="wide"><table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table>'
        "</div></section>"
    )


def _row(row: Row) -> str:
    style = ' class="fail"' if any(row.wrongs) else ""
    return "<tr>" + "".join(f"<td{style}>{escape(cell)}</td>" for cell in row.cells()) + "</tr>"


def _failures(failed: Iterable[Verdict]) -> str:
    items = "\n".join(
        f"<h3>{escape(' + '.join(v.case.kinds))} at "
        f"{escape(' + '.join(item.where for item in v.case.breaks))}, {v.case.moment}</h3>"
        + "".join(f"<p>{escape(wrong)}</p>" for wrong in v.wrongs())
        + f"<pre>{escape(v.case.command)}</pre>"
        for v in failed
    )
    return f"<section><h2>What went wrong</h2>\n{items}\n</section>" if items else ""
