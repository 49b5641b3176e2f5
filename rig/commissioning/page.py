"""The page that an acceptance test leaves: every step, its bounds and what was measured."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from rig.commissioning.record import FOLDER, Content
from rig.commissioning.step import AcceptanceStep
from rig.hal import ConfigurationError
from rig.whole_file import write_whole

_STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;color:#222}"
    "td,th{text-align:left;vertical-align:top;padding:.3em .8em .3em 0;border-top:1px solid #ccc}"
    "code{font-size:1.6em}"
)


def write_page(configs: Path, record: Content, steps: Sequence[AcceptanceStep]) -> Path:
    """Write the page of a record beside it.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    rig = record["rig"]
    facts = "".join(
        f"<tr><th>{escape(name)}</th><td>{escape(str(record[key]))}</td></tr>"
        for name, key in (
            ("on", "backend"), ("by", "operator"), ("date", "date"),
            ("until", "valid_until"), ("program", "program"),
        )
    )  # fmt: skip
    rows = "".join(_row(step, record["steps"][step.name]) for step in steps)
    page = (
        f'<!doctype html><meta charset="utf-8"><title>{escape(rig)}: acceptance test</title>'
        f"<style>{_STYLE}</style><h1>{escape(rig)}: acceptance test</h1>"
        f"<p>digest <code>{record['digest']}</code></p><table>{facts}</table>"
        f"<h2>Steps</h2><table>{rows}</table>\n"
    )
    path = configs / FOLDER / f"{rig}.html"
    try:
        write_whole(path, page)
    except OSError as error:
        raise ConfigurationError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def _row(step: AcceptanceStep, found: Content) -> str:
    lines = [*found["measured_in_words"], *([found["said"]] if found["said"] else [])]
    measured = "<br>".join(map(escape, lines))
    verdict = "passed" if found["passed"] else "FAILED"
    what = f"{escape(step.does)}<br><i>{escape(step.expects)}</i>"
    return (
        f"<tr><th>{escape(step.name)}</th><td>{what}</td><td>{measured}</td><td>{verdict}</td></tr>"
    )
