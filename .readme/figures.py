"""Make the figures of the pages again, each by the command that its marker names.

A marker is a comment before a number, ``<!--= COMMAND; METRIC; UNIT -->0.12``; of a sweep it goes
on with ``; max; COLUMN=VALUE …``, the worst of its points that have these values.
``python .readme/figures.py [PART]`` writes the numbers of all markers whose command has PART in
it, with as many decimals as they have; ``--check`` says which are not what comes out.
"""

import argparse
import csv
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from rig.config.quantities import parse_unit

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", *sorted(ROOT.glob(".readme/*.md")), *sorted(ROOT.glob("rig/*/*.md")))
_MARKER = re.compile(r"<!--= (?P<claim>[^>]+?) -->(?P<number>\d+(?:\.\d+)?)")
_RIG = (sys.executable, "-c", "from rig.cli import main; main()")


class Claim(NamedTuple):
    """A number of a page, and how it is made.

    Parameters
    ----------
    command : str
        ``rig run …`` or ``rig sweep …``.
    metric : str
        Its name; of a sweep a column.
    unit : str
        Of the number on the page.
    reduce : str
        ``max`` or ``min``: which of a sweep's points.
    where : str
        ``column=value`` of these points, apart by spaces, in quotes where they have some.
    """

    command: str
    metric: str
    unit: str
    reduce: str = "max"
    where: str = ""


def claims(text: str) -> Iterator[tuple[re.Match[str], Claim]]:
    """Return every number of a page that has a marker."""
    for found in _MARKER.finditer(text):
        yield found, Claim(*(part.strip() for part in found["claim"].split(";")))


def made(command: str, folder: Path) -> list[dict[str, str]]:
    """Run a command, and return what it measured: a row for a run, a row for each point."""
    what = ["--no-report", "--json"] if command.startswith("rig run ") else ["--workers", "1"]
    done = subprocess.run(
        [*_RIG, *shlex.split(command)[1:], *what, "--out", str(folder)],
        cwd=ROOT, check=False, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode > 1:
        raise SystemExit(f"{command} ended with {done.returncode}:\n{done.stderr}")
    if command.startswith("rig run "):
        return [{m["name"]: repr(m["value"]) for m in json.loads(done.stdout)["metrics"]}]
    with next(folder.rglob("sweep.csv")).open() as table:
        return list(csv.DictReader(table))


def value_of(claim: Claim, rows: list[dict[str, str]]) -> float:
    """Return what a claim's number should be, in its unit."""
    wanted = dict(part.split("=", 1) for part in shlex.split(claim.where))
    values = [
        float(row[claim.metric])
        for row in rows
        if row[claim.metric]  # a run that was stopped has none
        and all(_same(row[column], value) for column, value in wanted.items())
    ]
    if not values:
        raise SystemExit(f"{claim.command} has no {claim.metric} where {claim.where}")
    return {"max": max, "min": min}[claim.reduce](values) / float(parse_unit(claim.unit).scale)


def _same(one: str, other: str) -> bool:
    try:
        return abs(float(one) - float(other)) < 1e-9
    except ValueError:
        return one == other


def main() -> int:
    """Write, or check, the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("part", nargs="?", default="")
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    texts = {page: page.read_text() for page in PAGES}
    commands = sorted(
        {c.command for text in texts.values() for _, c in claims(text) if asked.part in c.command}
    )
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as workers:
        places = [Path(folder, str(k)) for k in range(len(commands))]
        rows = dict(zip(commands, workers.map(made, commands, places), strict=True))
    stale = []
    for page, text in texts.items():

        def again(found: re.Match[str], page: Path = page) -> str:
            claim = Claim(*(part.strip() for part in found["claim"].split(";")))
            if claim.command not in rows:
                return found[0]
            decimals = len(found["number"].partition(".")[2])
            number = f"{value_of(claim, rows[claim.command]):.{decimals}f}"
            if number != found["number"]:
                stale.append(f"{page.name}: {claim} is {number}, and not {found['number']}")
            return found[0].removesuffix(found["number"]) + number

        renewed = _MARKER.sub(again, text)
        if not asked.check and renewed != text:
            page.write_text(renewed)
    told = "\n".join(stale) or f"the figures of {len(commands)} commands are as they come out"
    sys.stdout.write(told + "\n")
    return bool(stale and asked.check)


if __name__ == "__main__":
    sys.exit(main())
