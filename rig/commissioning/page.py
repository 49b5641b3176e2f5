"""The page that an acceptance test leaves: every step, its bounds and what was measured."""

from collections.abc import Sequence
from pathlib import Path

from rig.commissioning.record import BY, FOLDER, Content
from rig.commissioning.step import AcceptanceStep
from rig.config.calibration import HARDWARE
from rig.hal import ConfigurationError
from rig.hal.files import reason_unwritten
from rig.report.markup import NOTHING, Html, element, join, page, section, table
from rig.whole_file import write_whole

_FACTS = (
    ("on", "backend"), ("computer", "host"), ("by", BY), ("date", "date"),
    ("until", "valid_until"), ("program", "program"), ("digest", "digest"),
)  # fmt: skip
_STEPS = ("step", "what happens, and what is expected", "measured", "by", "verdict")
_WHO = ("device", "vendor", "product", "serial", "firmware")
_REHEARSAL = "rehearsal in simulation"
_IS_REHEARSED = "A rehearsal in simulation: it says nothing of any hardware."


def write_page(configs: Path, record: Content, steps: Sequence[AcceptanceStep]) -> Path:
    """Write the page of a record beside it; it needs no network and runs nothing.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    is_rehearsed = record["backend"] != HARDWARE
    title = f"{record['rig']}: acceptance test{f', {_REHEARSAL}' if is_rehearsed else ''}"
    facts = [(name, _told(record, key)) for name, key in _FACTS if key in record]
    rows = [_row(step, record["steps"][step.name], record) for step in steps]
    who = _identities(record)
    devices = table("Devices", _WHO, who) if who else "No device says who it is."
    text = page(
        title,
        element("header", element("h1", title)),
        element("p", _IS_REHEARSED) if is_rehearsed else NOTHING,
        section("Circumstances", table("Circumstances", (), facts)),
        section("Devices", devices),
        section("Steps", table("Steps", _STEPS, rows)),
    )
    path = configs / FOLDER / f"{record['rig']}.html"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)  # of a record that was kept elsewhere
        write_whole(path, text)
    except OSError as error:
        raise ConfigurationError(f"cannot write {path}: {reason_unwritten(path, error)}") from error
    return path


def _told(record: Content, key: str) -> str:
    """Return a circumstance in words."""
    if key == BY:  # who resumes a test may be another one than who began it
        found = record["steps"].values()
        return ", ".join(dict.fromkeys(_by(step, record) for step in found)) or str(record[BY])
    if key == "backend" and record[key] != HARDWARE:
        return f"{record[key]}: {_REHEARSAL}"
    return str(record[key])


def _by(found: Content, record: Content) -> str:
    """Return who has taken a step; a record of before steps said so has one operator."""
    return str(found.get(BY, record.get(BY, "")))


def _identities(record: Content) -> list[tuple[str, ...]]:
    """Return who the devices have said they are, a row for each device or joint."""
    rows: dict[str, dict[str, str]] = {}
    for step in record["steps"].values():
        for device, said in step.get("facts", {}).get("identities", {}).items():
            for key, value in said.items():
                joint, _, what = key.rpartition(" ")  # of a chain: "q1 serial"
                rows.setdefault(f"{device}.{joint}" if joint else device, {})[what] = _number(value)
    return [(name, *(said.get(what, "-") for what in _WHO[1:])) for name, said in rows.items()]


def _number(value: object) -> str:
    """Return a number as profiles and makers write it: small ones plain, others in both ways."""
    if not isinstance(value, int):
        return str(value)
    return str(value) if value < 10 else f"{value} (0x{value:X})"


def _row(step: AcceptanceStep, found: Content, record: Content) -> tuple[str, ...]:
    lines = [*found["measured_in_words"], *([found["said"]] if found["said"] else [])]
    line = Html("<br>")
    what = join([step.does, element("em", step.expects)], line)
    passed = element("span", "passed", class_="pass")
    verdict = passed if found["passed"] else element("span", "FAILED", class_="fail")
    return step.name, what, join(lines, line), _by(found, record), verdict
