"""The page of a sweep: figure, best and worst points, failures, and every run that was kept."""

import contextlib
import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rig.hal import RigError
from rig.hal.formats import format_quantity
from rig.report.markup import NOTHING, Html, element, image, join, link, page, section, table
from rig.whole_file import write_whole

if TYPE_CHECKING:
    from rig.sweeping.result import Sweep

PAGE: Final = "sweep.html"
DRAWN: Final = (PAGE, "sweep.png", "sweep.svg", "sweep.pdf")
"""What is drawn from the table, by name."""
_SHOWN: Final = 20
"""Most rows of a table of the page; sweep.csv has all."""


def draw(sweep: "Sweep", metric: str | None, title: str, say: Callable[[str], None]) -> None:
    """Draw the figure and write the page; the table is there without them too."""
    from rig.report.style import paper_style, save

    try:
        with paper_style():
            figure = sweep.figure(metric)
            save(figure, sweep.folder, "sweep", title, has_table=True)
        write_page(sweep, metric, title)
    except (RigError, OSError) as error:
        say(f"there is no figure: {error}")


def remove_drawn(folder: Path) -> None:
    """Remove the page and the figure of fewer points than the table has now."""
    for name in DRAWN:
        with contextlib.suppress(OSError):
            (folder / name).unlink()


def write_page(sweep: "Sweep", metric: str | None, title: str) -> Path:
    """Write ``sweep.html``; it needs no network and runs nothing."""
    data = sweep.data
    name, column = data.metric(metric)
    order = data.order(metric)
    worst = sorted(order, key=lambda k: column.sign * column.numbers[k], reverse=True)
    failed = [int(number) for number in data.failed.nonzero()[0]]
    unfinished = sweep.total - len(data.points)
    left = f", {unfinished} not finished" if unfinished else ""
    missed = data.statuses.count("failed")
    path = sweep.folder / PAGE
    behind = ", and stand behind all that kept theirs" if missed else ""
    told = f"{missed} missed a bound{behind}, {len(failed)} failed{left}. "
    told += "All points stand in sweep.csv."
    picture = image((sweep.folder / "sweep.png").read_bytes(), name)
    write_whole(
        path,
        page(
            title,
            element("header", element("h1", title), element("p", told)),
            element("section", element("figure", picture)),
            _section(f"Best in {name}", sweep, order[:_SHOWN]),
            _section(f"Worst in {name}", sweep, worst[:_SHOWN]),
            _section("Failed", sweep, failed[:_SHOWN]),
            _kept(sweep),
            width="80rem",
        ),
    )
    return path


def _section(title: str, sweep: "Sweep", numbers: Sequence[int]) -> Html:
    if not numbers:
        return NOTHING
    names = ("run", *sweep.data.settings, "status", *sweep.data.metrics)
    return section(title, table(title, names, [tuple(_cells(sweep, k)) for k in numbers]))


def _cells(sweep: "Sweep", number: int) -> Iterable[str]:
    data = sweep.data
    yield _link(sweep, data.points[number])
    for values in data.settings.values():
        yield str(values[number])
    yield data.ending(number)
    for column in data.metrics.values():
        value = column.numbers[number]
        yield "" if math.isnan(value) else format_quantity(value, column.unit or "1")


def _is_kept(sweep: "Sweep", point: str) -> bool:
    return (sweep.folder / "runs" / point).is_dir()


def _link(sweep: "Sweep", point: str) -> str:
    return link(f"runs/{point}/", point[:8]) if _is_kept(sweep, point) else point[:8]


def _kept(sweep: "Sweep") -> Html:
    kept = [point for point in dict.fromkeys(sweep.data.points) if _is_kept(sweep, point)]
    links = join((_link(sweep, point) for point in kept), " ")
    return section("Runs that were kept", element("p", links)) if kept else NOTHING
