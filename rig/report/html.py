"""One page that says what was run, how it went and how to run it again; it needs no network."""

import base64
import math
import shlex
from collections.abc import Iterable, Sequence
from datetime import datetime
from html import escape
from pathlib import Path
from typing import cast

from rig.config import format_against
from rig.report.data import mechanism_of, origin_of
from rig.report.figures import known_figures
from rig.report.timing import Spread, TimingSummary
from rig.run_folder import (
    REPORT,
    TIMING,
    Event,
    Manifest,
    MetricRow,
    RunFolder,
    RunFolderError,
    RunStatus,
)  # fmt: skip

_EXPLANATIONS = {
    RunStatus.RUNNING: "The run still goes on; this is what there is so far.",
    RunStatus.OK: "The run came to its end and kept every bound.",
    RunStatus.FAILED: "The run came to its end and missed a bound.",
    RunStatus.ABORTED: "The run was interrupted and the rig made safe.",
    RunStatus.FAULTED: "A fault ended the run and the rig was made safe.",
    RunStatus.CRASHED: "A bug ended the run, or the process died; every cycle until then is here.",
}
_EVENTS_SHOWN = 200
_SCREEN_SCALE = 0.62
"""Pixels on the page per pixel of a figure: 85 mm and 170 mm stay one and two columns."""


def write_html(
    folder: RunFolder,
    figures: Sequence[Path],
    problems: Sequence[str],
    failures: Sequence[str] = (),
) -> Path:
    """Write ``report.html`` into a run folder.

    Parameters
    ----------
    folder : RunFolder
        The run.
    figures : sequence of Path
        PNG files, which are embedded; one named ``.svg`` beside it is linked.
    problems : sequence of str
        What could not be judged, and why.
    failures : sequence of str
        Which figures could not be drawn, and why.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    RunFolderError
        It cannot be written.
    """
    manifest = folder.manifest
    title = f"{manifest.get('experiment', folder.path.name)} on {manifest.get('backend', '?')}"
    title += ", a simulation" if origin_of(folder).startswith("simulation") else ""
    sections = [
        _header(folder, title),
        _metrics(folder.metrics(), problems),
        _figures(figures, failures, mechanism_of(folder)),
        _timing(cast("TimingSummary", folder.read_json(TIMING))),
        _events(folder.events()),
        _reproduce(manifest),
        _environment(manifest),
    ]
    style = Path(__file__).with_name("report.css").read_text(encoding="utf-8")
    page = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(section for section in sections if section)
        + "\n</main>\n</body>\n</html>\n"
    )
    target = folder.path / REPORT
    try:
        target.write_text(page, encoding="utf-8")
    except OSError as error:
        raise RunFolderError(f"cannot write {target}: {error.strerror or error}") from error
    return target


def _header(folder: RunFolder, title: str) -> str:
    manifest, status = folder.manifest, folder.status
    message = manifest.get("message") or _EXPLANATIONS[status]
    facts = {
        "started": _time(manifest.get("started")),
        "took": _duration(manifest.get("started"), manifest.get("ended")),
        "rig": manifest.get("rig"),
        "law": manifest.get("law"),
        "backend": manifest.get("backend"),
        "seed": manifest.get("seed"),
        "exit code": manifest.get("exit_code"),
        "folder": folder.path.name,
    }
    items = "".join(
        f"<div><dt>{escape(name)}</dt><dd>{escape(str(value))}</dd></div>"
        for name, value in facts.items()
        if value is not None
    )
    return (
        f'<header>\n<h1>{escape(title)} <span class="badge {status}">{status}</span></h1>\n'
        f"<p>{escape(str(message))}</p>\n<dl>{items}</dl>\n</header>"
    )


def _metrics(metrics: Sequence[MetricRow], problems: Sequence[str]) -> str:
    if not metrics and not problems:
        return ""
    rows = []
    for metric in metrics:
        number = math.nan if metric.get("is_nan") else metric["value"]
        value, bound = format_against(number, metric.get("bound"), metric.get("unit") or "1")
        sign = {"max": "≤", "min": "≥"}.get(str(metric.get("bound_kind")), "")
        passed = metric.get("pass")
        verdict = "" if passed is None else "pass" if passed else "fail"
        rows.append(
            [
                f"<code>{escape(str(metric['name']))}</code>",
                escape(str(metric.get("segments", ""))),
                escape(value),
                escape(f"{sign} {bound}") if bound else "",
                f'<span class="{verdict}">{verdict}</span>' if verdict else "–",
            ]
        )
    table = _table(["metric", "over", "value", "bound", ""], rows, numeric=(2, 3)) if rows else ""
    return _section("Metrics", table + _problems(problems))


def _problems(sentences: Sequence[str]) -> str:
    notes = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f'<ul class="problems">{notes}</ul>' if notes else ""


def _figures(figures: Sequence[Path], failures: Sequence[str], mechanism: str | None) -> str:
    parts, known = [], known_figures(mechanism)
    for figure in figures:
        content = figure.read_bytes()
        data = base64.b64encode(content).decode()
        width = round(_SCREEN_SCALE * int.from_bytes(content[16:20], "big"))  # of its IHDR
        name = figure.stem
        vector = f"{figure.parent.name}/{name}.svg"
        caption = known[name].caption if name in known else name
        parts.append(
            f'<figure><img alt="{escape(caption)}" width="{width}" '
            f'src="data:image/png;base64,{data}">'
            f'<figcaption>{escape(caption)} <a href="{escape(vector)}">svg</a></figcaption>'
            "</figure>"
        )
    body = "\n".join(parts) + _problems(failures)
    return _section("Figures", body) if body else ""


def _speed(timing: TimingSummary) -> str:
    """Return how fast the loop ran; nothing for runs that were recorded without it."""
    if "speed" not in timing:
        return ""
    return f"The loop took {timing['took']:.2f} s, {timing['speed']:.3g} times real time. "


def _timing(timing: TimingSummary) -> str:
    if not timing.get("stages"):
        return ""

    def cells(spread: Spread) -> list[str]:
        return [f"{t * 1e6:.1f}" for t in (spread["p50"], spread["p99"], spread["max"])]

    rows = [
        [escape(name), *cells(stage), f"{100 * stage['share']:.0f}"]
        for name, stage in timing["stages"].items()
    ]
    rows.append(["<b>all work</b>", *cells(timing["work"]), "100"])
    rows.append(["lateness", *cells(timing["lateness"]), ""])
    stages = _table(
        ["stage", "median (µs)", "99 % (µs)", "longest (µs)", "share (%)"], rows, (1, 2, 3, 4)
    )
    worst = _table(
        ["cycle", "t (s)", "work (µs)", "lateness (µs)", "stage to blame"],
        [
            [
                str(cycle["cycle"]),
                f"{cycle['t']:.3f}",
                f"{cycle['work'] * 1e6:.1f}",
                f"{cycle['lateness'] * 1e6:.1f}",
                escape(cycle["blame"]),
            ]
            for cycle in timing["worst"]
        ],
        (0, 1, 2, 3),
    )
    text = (
        f"<p>{timing['cycles']} cycles of {timing['period'] * 1e3:.4g} ms; "
        f"{timing['overruns']} took longer than that, {timing['missed']} ticks were missed. "
        f"{_speed(timing)}"
        "These are wall-clock times of this machine and differ from run to run.</p>"
    )
    details = f"<details><summary>The longest cycles</summary>{worst}</details>"
    return _section("Timing", text + stages + details)


def _events(events: Sequence[Event]) -> str:
    if not events:
        return ""
    rows = []
    for event in events[:_EVENTS_SHOWN]:
        t = event.get("t")
        data = event.get("data") or {}
        details = ", ".join(f"{key} {value}" for key, value in data.items())
        rows.append(
            [
                f"{t:.3f}" if isinstance(t, int | float) else "",
                escape(str(event.get("kind", ""))),
                escape(str(event.get("message", ""))),
                escape(details),
            ]
        )
    left = len(events) - len(rows)
    more = f"<p>{left} more are in <code>events.jsonl</code>.</p>" if left > 0 else ""
    return _section("Events", _table(["t (s)", "kind", "event", "data"], rows, (0,)) + more)


def _reproduce(manifest: Manifest) -> str:
    command = manifest.get("command")
    if not command:
        return ""
    if len(command) == 1:  # an older version kept the line as one word
        command = shlex.split(command[0])
    git = manifest.get("git")
    lines = [shlex.join(("git", "checkout", str(git["commit"])))] if git else []
    lines.append(shlex.join(command))
    note = (
        "<p>The checkout had uncommitted changes, so its commit alone is not what ran.</p>"
        if git and git.get("dirty")
        else ""
    )
    code = escape("\n".join(lines))
    return _section("How to run it again", f"<pre>{code}</pre>{note}")


def _environment(manifest: Manifest) -> str:
    facts: dict[str, object] = {**manifest.get("machine", {}), **manifest.get("versions", {})}
    rows = [[escape(str(key)), escape(str(value))] for key, value in facts.items()]
    files = [
        [f'<a href="{escape(name)}">{escape(name)}</a>', f"<code>{escape(digest)}</code>"]
        for name, digest in manifest.get("files", {}).items()
    ]
    body = _table(["", ""], rows)
    if files:
        body += _table(["file", "SHA-256"], files)
    return _section("Environment", f"<details><summary>Machine, versions, files</summary>{body}"
                    "</details>")  # fmt: skip


def _section(title: str, body: str) -> str:
    return f"<section>\n<h2>{title}</h2>\n{body}\n</section>"


def _table(
    head: Sequence[str], rows: Iterable[Sequence[str]], numeric: tuple[int, ...] = ()
) -> str:
    def cell(tag: str, column: int, content: str) -> str:
        kind = ' class="number"' if column in numeric else ""
        return f"<{tag}{kind}>{content}</{tag}>"

    top = "".join(cell("th", column, escape(text)) for column, text in enumerate(head))
    body = "\n".join(
        "<tr>" + "".join(cell("td", column, text) for column, text in enumerate(row)) + "</tr>"
        for row in rows
    )
    header = f"<thead><tr>{top}</tr></thead>" if any(head) else ""
    return f'<div class="wide"><table>{header}<tbody>\n{body}\n</tbody></table></div>'


def _time(stamp: str | None) -> str | None:
    return f"{datetime.fromisoformat(stamp):%Y-%m-%d %H:%M:%S} UTC" if stamp else None


def _duration(started: str | None, ended: str | None) -> str | None:
    if not started or not ended:
        return None
    seconds = (datetime.fromisoformat(ended) - datetime.fromisoformat(started)).total_seconds()
    return f"{seconds:.1f} s"
