"""Write the page of every motion of arm and legs under every law, by `rig compare`.

``python .readme/laws.py [PART]`` makes again the tables of all experiments with PART in their
name, a quarter of an hour for all of them; ``--check`` says which are not what comes out. It wants
the rivals of others too: ``pip install -e '.[peers]'``.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import yaml

from rig.hal.formats import unit_for_people

ROOT = Path(__file__).parents[1]
PAGE = ROOT / ".readme" / "laws.md"
EXPERIMENTS = ROOT / "configs" / "experiments"
HEAD = """# Every motion of arm and legs, under every law

Each table is what `rig compare EXPERIMENT --on sim` measures, with the rivals of others
installed (`pip install -e '.[peers]'`); `python .readme/laws.py` writes this page. What is the
same under every law is left out.
`rig explain NAME` says what a measure means, [how it works](how-it-works.md) what a law does.
"""
_RIG = (sys.executable, "-c", "from rig.cli import main; main()")
_NOTHING = "–"
_SECTION = re.compile(r"^## (\S+)\n.*?(?=^## |\Z)", re.M | re.S)


def experiments() -> list[str]:
    """Return the names of the experiments that this page has, arm first."""
    return sorted(
        path.stem for rig in ("arm", "legs") for path in EXPERIMENTS.glob(f"{rig}-*.yaml")
    )


def compared(experiment: str, folder: Path) -> dict[str, Any]:
    """Run a comparison, and return what it says of itself as JSON."""
    done = subprocess.run(
        [*_RIG, "compare", experiment, "--on", "sim", "--json", "--out", str(folder)],
        cwd=ROOT, check=False, capture_output=True, text=True,
    )  # fmt: skip
    if not done.stdout.startswith("{"):
        raise SystemExit(f"rig compare {experiment} ended with {done.returncode}:\n{done.stderr}")
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def section(experiment: str, found: dict[str, Any]) -> str:
    """Return one experiment's heading, table and refusals as Markdown."""
    labels = found["labels"]
    described = yaml.safe_load((EXPERIMENTS / f"{experiment}.yaml").read_text())["description"]
    lines = [f"## {experiment}", "", f"{described} (`rig compare {experiment} --on sim`).", ""]
    lines += [_row("", labels), "|---" * (len(labels) + 1) + "|"]
    for metric in found["metrics"]:
        cells = _cells(metric["values"], metric["unit"])
        if _differs(cells):
            lines.append(_row(metric["name"].partition(" (")[0], cells))
    endings = dict.fromkeys(found["faulted"], "stopped")
    endings |= dict.fromkeys(found["refused"], "refused")
    if endings:
        lines.append(_row("run", [endings.get(label, "ok") for label in labels]))
    for label, why in {**found["faulted"], **found["refused"]}.items():
        reason = str(why).partition("\n")[0].removeprefix(f"{experiment}: ")
        lines += ["", f"`{label}`: {reason}"]
    return "\n".join(lines) + "\n"


def _differs(cells: list[str]) -> bool:
    """Tell whether a row has something to say: laws differ in it, or one alone was measured."""
    measured = [cell for cell in cells if cell != _NOTHING]
    return len(set(measured)) > 1 or len(measured) == 1


def _row(name: str, cells: list[str]) -> str:
    return f"| {' | '.join([name, *cells])} |"


def _cells(values: list[Any], unit: str) -> list[str]:
    """Return what the cells of a row say, in the unit that suits the greatest."""
    numbers = [abs(value) for value in values if isinstance(value, int | float)]
    name, scale = unit_for_people(max(numbers, default=0.0), unit or "1")
    return [_cell(value, scale, name) for value in values]


def _cell(value: Any, scale: float, unit: str) -> str:
    if value is None:
        return _NOTHING
    if isinstance(value, str):
        return value
    # What is less than 0.0001 of a unit that suits the others is rounding, here and there.
    number = value / scale
    return f"{number if abs(number) > 1e-4 else 0:.3g} {unit}".rstrip()


def main() -> int:
    """Write, or check, the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("part", nargs="?", default="")
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    was = PAGE.read_text() if PAGE.exists() else HEAD
    tables = {found[1]: found[0].rstrip() + "\n" for found in _SECTION.finditer(was)}
    stale = []
    with tempfile.TemporaryDirectory() as folder:
        for name in experiments():
            if asked.part not in name:
                continue
            made = section(name, compared(name, Path(folder)))
            stale += [name] if tables.get(name) != made else []
            tables[name] = made
            sys.stdout.write(f"{name}: {'not as it was' if name in stale else 'as it was'}\n")
    page = "\n".join([HEAD, *(tables[name] for name in experiments() if name in tables)])
    if not asked.check:
        PAGE.write_text(page)
    return bool(stale and asked.check)


if __name__ == "__main__":
    sys.exit(main())
