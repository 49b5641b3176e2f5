"""The page of a sweep: figure, best and worst points, failures, and every run that was kept."""

import base64
import math
from collections.abc import Callable, Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rig.config.formats import format_quantity
from rig.hal import RigError

if TYPE_CHECKING:
    from rig.sweeping.result import Sweep

PAGE: Final = "sweep.html"
_SHOWN: Final = 20
"""Most rows of a table of the page; sweep.csv has all."""


def draw(sweep: "Sweep", metric: str | None, title: str, say: Callable[[str], None]) -> None:
    """Draw the figure and write the page; the table is there without them too."""
    from rig.report.style import paper_style, save

    try:
        with paper_style():
            figure = sweep.figure(metric)
            save(figure, sweep.folder, "sweep", title)
        write_page(sweep, metric, title)
    except (RigError, OSError) as error:
        say(f"there is no figure: {error}")


def write_page(sweep: "Sweep", metric: str | None, title: str) -> Path:
    """Write ``sweep.html``; it needs no network and runs nothing."""
    import rig.report

    css = Path(rig.report.__file__).with_name("report.css").read_text(encoding="utf-8")
    image = base64.b64encode((sweep.folder / "sweep.png").read_bytes()).decode()
    data = sweep.data
    name, _ = data.metric(metric)
    order = data.order(metric)
    failed = [int(number) for number in data.failed.nonzero()[0]]
    unfinished = sweep.total - len(data.points)
    left = f", {unfinished} not finished" if unfinished else ""
    missed = data.statuses.count("failed")
    path = sweep.folder / PAGE
    path.write_text(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
        "style-src 'unsafe-inline'; img-src data:\">\n"
        f"<title>{escape(title)}</title>\n<style>\n{css}main {{ max-width: 80rem; }}\n</style>\n"
        f"</head>\n<body>\n<main>\n<header><h1>{escape(title)}</h1>"
        f"<p>{missed} missed a bound, {len(failed)} failed{left}. "
        "All points stand in sweep.csv.</p></header>\n"
        f'<section><figure><img src="data:image/png;base64,{image}" alt="{escape(name)}" '
        'style="max-width: 100%"></figure></section>\n'
        + _section(f"Best in {name}", sweep, order[:_SHOWN])
        + _section(f"Worst in {name}", sweep, order[::-1][:_SHOWN])
        + _section("Failed", sweep, failed[:_SHOWN])
        + _kept(sweep)
        + "</main>\n</body>\n</html>\n",
        encoding="utf-8",
    )
    return path


def _section(title: str, sweep: "Sweep", numbers: Sequence[int]) -> str:
    if not numbers:
        return ""
    data = sweep.data
    names = ("run", *data.settings, "status", *data.metrics)
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "\n".join(
        "<tr>" + "".join(f"<td>{cell}</td>" for cell in _cells(sweep, number)) + "</tr>"
        for number in numbers
    )
    return (
        f'<section><h2>{escape(title)}</h2><div class="wide"><table>'
        f"<thead><tr>{head}</tr></thead>\n"
        f"<tbody>{body}</tbody></table></div></section>\n"
    )


def _cells(sweep: "Sweep", number: int) -> Iterable[str]:
    data = sweep.data
    yield _link(sweep, data.points[number])
    for values in data.settings.values():
        yield escape(str(values[number]))
    yield escape(data.statuses[number])
    for column in data.metrics.values():
        value = column.numbers[number]
        yield "" if math.isnan(value) else escape(format_quantity(value, column.unit or "1"))


def _link(sweep: "Sweep", point: str) -> str:
    kept = (sweep.folder / "runs" / point).is_dir()
    return f'<a href="runs/{point}/">{point[:8]}</a>' if kept else point[:8]


def _kept(sweep: "Sweep") -> str:
    kept = [point for point in dict.fromkeys(sweep.data.points) if "<a" in _link(sweep, point)]
    links = " ".join(_link(sweep, point) for point in kept)
    return f"<section><h2>Runs that were kept</h2><p>{links}</p></section>\n" if kept else ""
