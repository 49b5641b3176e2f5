"""The page that an acceptance test leaves: every step, its bounds and what was measured."""

from collections.abc import Sequence
from pathlib import Path

from rig.commissioning.record import FOLDER, Content
from rig.commissioning.step import AcceptanceStep
from rig.hal import ConfigurationError
from rig.hal.files import reason_unwritten
from rig.report.markup import Html, element, join, page, section, table
from rig.whole_file import write_whole

_FACTS = (
    ("on", "backend"), ("computer", "host"), ("by", "operator"), ("date", "date"),
    ("until", "valid_until"), ("program", "program"), ("digest", "digest"),
)  # fmt: skip
_STEPS = ("step", "what happens, and what is expected", "measured", "verdict")


def write_page(configs: Path, record: Content, steps: Sequence[AcceptanceStep]) -> Path:
    """Write the page of a record beside it; it needs no network and runs nothing.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    title = f"{record['rig']}: acceptance test"
    facts = table(
        "Circumstances", (), [(name, str(record[key])) for name, key in _FACTS if key in record]
    )
    rows = [_row(step, record["steps"][step.name]) for step in steps]
    text = page(
        title,
        element("header", element("h1", title)),
        section("Circumstances", facts),
        section("Steps", table("Steps", _STEPS, rows)),
    )
    path = configs / FOLDER / f"{record['rig']}.html"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)  # of a record that was kept elsewhere
        write_whole(path, text)
    except OSError as error:
        raise ConfigurationError(f"cannot write {path}: {reason_unwritten(path, error)}") from error
    return path


def _row(step: AcceptanceStep, found: Content) -> tuple[str, ...]:
    lines = [*found["measured_in_words"], *([found["said"]] if found["said"] else [])]
    line = Html("<br>")
    what = join([step.does, element("em", step.expects)], line)
    passed = element("span", "passed", class_="pass")
    verdict = passed if found["passed"] else element("span", "FAILED", class_="fail")
    return step.name, what, join(lines, line), verdict
