"""One page that says what was run, how it went and how to run it again; it needs no network."""

import contextlib
import math
import shlex
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path

from rig.config import format_against
from rig.experiment.metrics import Evaluation, known_measures
from rig.explaining.ended_run import explain_run
from rig.hal.files import reason_unwritten
from rig.report import markup
from rig.report.beside_figure import BESIDE, CAPTION
from rig.report.data import mechanism_of, origin_of
from rig.report.figure import FigureKind
from rig.report.figures import figure_kind, known_figures
from rig.report.markup import NOTHING, Html, element, image, items, join, link, section, table
from rig.report.timing import Spread, TimingSummary
from rig.run_facts import (
    EVALUATION,
    EVENTS,
    REPORT,
    TIMING,
    Event,
    Manifest,
    MetricRow,
    RunStatus,
)
from rig.run_folder import RunFolder, RunFolderError
from rig.typed_json import checked
from rig.whole_file import write_whole

_EXPLANATIONS = {
    RunStatus.RUNNING: "The run still goes on; this is what there is so far.",
    RunStatus.OK: "The run came to its end and kept every bound.",
    RunStatus.FAILED: "The run came to its end and missed a bound.",
    RunStatus.ABORTED: "The run was interrupted and the rig made safe.",
    RunStatus.FAULTED: "A fault ended the run and the rig was made safe.",
    RunStatus.CRASHED: "A bug ended the run, or the process died; every cycle until then is here.",
}
_EVENTS_SHOWN = 200
_BESIDE = ("svg", "pdf", "csv")
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
        PNG files, which are embedded; the same as ``.svg``, ``.pdf`` and ``.csv`` are linked.
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
    page = markup.page(
        title,
        _header(folder, title),
        _stopped(folder),
        _motion(folder),
        _metrics(folder.metrics(), _meanings(folder), problems),
        _figures(figures, failures, mechanism_of(folder)),
        _timing(folder),
        _events(folder.events()),
        _reproduce(manifest),
        _environment(manifest),
    )
    target = folder.place(REPORT)
    try:
        write_whole(target, page)
    except OSError as error:
        reason = reason_unwritten(target, error)
        raise RunFolderError(f"cannot write {target}: {reason}") from error
    return target


def _header(folder: RunFolder, title: str) -> Html:
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
    entries = (
        element("div", element("dt", name), element("dd", str(value)))
        for name, value in facts.items()
        if value is not None
    )
    wrongs = [
        element("p", "By what was true of the rig: ", wrong, class_="fail")
        for wrong in manifest.get("wrongs", ())
    ]
    wrongs += [
        element("p", "Not counted, as nothing could have kept it off: ", left)
        for left in manifest.get("uncounted", ())
    ]
    badge = element("span", status, class_=f"badge {status}")
    return element(
        "header",
        element("h1", title, " ", badge),
        element("p", message),
        *wrongs,
        element("dl", *entries),
    )


def _stopped(folder: RunFolder) -> Html:
    """Return why a run was stopped by a fault, and what finds and mends it."""
    if folder.status not in (RunStatus.FAULTED, RunStatus.CRASHED):
        return NOTHING
    told = [remark for remark in explain_run(folder.path) if remark.label not in ("run", "message")]
    entries = [element("div", element("dt", label), element("dd", text)) for label, text in told]
    command = f"rig explain {folder.path.name}"
    said = element("p", "The same in a terminal: ", element("code", command), ".")
    return section("Why it stopped", element("dl", *entries), said)


def _motion(folder: RunFolder) -> Html:
    """Return what the planner said of the motion: a run from before it was kept says nothing."""
    remarks = folder.read_json(EVALUATION, Evaluation).get("remarks")
    if not remarks:
        return NOTHING
    rows = [[remark["kind"], remark["message"]] for remark in remarks]
    return section(
        "The motion as it was planned",
        table("What is known of the motion", ["what", "how"], rows),
    )


def _meanings(folder: RunFolder) -> Mapping[str, str]:
    """Return what each measure says, and each fact that the run's motion brought."""
    facts = folder.read_json(EVALUATION, Evaluation).get("facts") or {}
    own = {name: fact["description"] for name, fact in facts.items()}
    known = known_measures(mechanism_of(folder))
    return {name: measure.description for name, measure in known.items()} | own


def _metrics(
    metrics: Sequence[MetricRow], meanings: Mapping[str, str], problems: Sequence[str]
) -> Html:
    if not metrics and not problems:
        return NOTHING
    rows = []
    for metric in metrics:
        number = math.nan if metric.get("is_nan") else metric["value"]
        value, bound = format_against(number, metric.get("bound"), metric["unit"] or "1")
        sign = {"max": "≤", "min": "≥"}.get(str(metric.get("bound_kind")), "")
        passed = metric.get("pass")
        verdict = "" if passed is None else "pass" if passed else "fail"
        rows.append(
            [
                element("code", metric["name"]),
                metric.get("segments", ""),
                value,
                f"{sign} {bound}" if bound else "",
                element("span", verdict, class_=verdict) if verdict else "–",
                meanings.get(metric.get("measure") or metric["name"], ""),
            ]
        )
    head = ["metric", "over", "value", "bound", "verdict", "what it is"]
    shown = table("Metrics", head, rows, numeric=(2, 3)) if rows else NOTHING
    return section("Metrics", shown, items(problems, "problems"))


def _figures(figures: Sequence[Path], failures: Sequence[str], mechanism: str | None) -> Html:
    parts, known = [], known_figures(mechanism)
    for figure in figures:
        content = figure.read_bytes()
        width = round(_SCREEN_SCALE * int.from_bytes(content[16:20], "big"))  # of its IHDR
        name = figure.stem
        caption = _caption(name, known)
        files = [link(f"{figure.parent.name}/{name}.{kind}", kind) for kind in _BESIDE]
        told = element("figcaption", caption, " ", join(files, " "))
        parts.append(element("figure", image(content, caption, width), told))
    body = join([*parts, items(failures, "problems")], "\n")
    return section("Figures", body) if body.strip() else NOTHING


def _caption(name: str, known: Mapping[str, FigureKind]) -> str:
    if name == BESIDE:
        return CAPTION
    kind = figure_kind(name, known)
    return name if kind is None else kind.caption


def _speed(timing: TimingSummary) -> str:
    """Return how fast the loop ran; nothing for runs that were recorded without it."""
    if "speed" not in timing or "took" not in timing:
        return ""
    return f"The loop took {timing['took']:.2f} s, {timing['speed']:.3g} times real time. "


def _timing(folder: RunFolder) -> Html:
    facts = folder.read_json(TIMING, dict[str, object])
    if not facts.get("stages"):
        return NOTHING
    timing = checked(facts, TimingSummary, str(folder.path / TIMING))

    def cells(spread: Spread) -> list[str]:
        return [f"{t * 1e6:.1f}" for t in (spread["p50"], spread["p99"], spread["max"])]

    rows = [
        [name, *cells(stage), f"{100 * stage['share']:.0f}"]
        for name, stage in timing["stages"].items()
    ]
    rows.append([element("b", "all work"), *cells(timing["work"]), "100"])
    rows.append(["lateness", *cells(timing["lateness"]), ""])
    head = ["stage", "median (µs)", "99 % (µs)", "longest (µs)", "share (%)"]
    worst = table(
        "The longest cycles",
        ["cycle", "t of the log (s)", "work (µs)", "lateness (µs)", "stage to blame"],
        [
            [
                str(cycle["cycle"]),
                f"{cycle['t']:.3f}",
                f"{cycle['work'] * 1e6:.1f}",
                f"{cycle['lateness'] * 1e6:.1f}",
                cycle["blame"],
            ]
            for cycle in timing["worst"]
        ],
        (0, 1, 2, 3),
    )
    text = (
        f"{timing['cycles']} cycles of {timing['period'] * 1e3:.4g} ms; "
        f"{timing['overruns']} took longer than that, {timing['missed']} ticks were missed. "
        f"{_speed(timing)}"
        "These are wall-clock times of this machine and differ from run to run."
    )
    return section(
        "Timing",
        element("p", text),
        table("Times of the stages", head, rows, (1, 2, 3, 4)),
        element("details", element("summary", "The longest cycles"), worst),
    )


def _events(events: Sequence[Event]) -> Html:
    if not events:
        return NOTHING
    rows = []
    for event in events[:_EVENTS_SHOWN]:
        t = event.get("t")
        details = ", ".join(f"{key} {value}" for key, value in event.get("data", {}).items())
        time = "" if t is None else f"{t:.3f}"
        rows.append([time, event.get("kind", ""), event.get("message", ""), details])
    left = len(events) - len(rows)
    more = (element("p", f"{left} more are in ", element("code", EVENTS), "."),) if left > 0 else ()
    clocks = element(
        "p", "The log's clock begins with the first cycle; figures count from where the reference "
        "starts (reference.time of the log).",
    )  # fmt: skip
    head = ["t of the log (s)", "kind", "event", "data"]
    return section("Events", clocks, table("Events", head, rows, (0,)), *more)


def _reproduce(manifest: Manifest) -> Html:
    command = manifest.get("command")
    if not command:
        return NOTHING
    if len(command) == 1:  # an older version kept the line as one word
        with contextlib.suppress(ValueError):  # else it is no line, and shown as the word it is
            command = shlex.split(command[0])
    git = manifest.get("git")
    lines = [shlex.join(("git", "checkout", git["commit"]))] if git else []
    lines.append(shlex.join(command))
    note = "The checkout had uncommitted changes, so its commit alone is not what ran."
    notes = (element("p", note),) if git and git["dirty"] else ()
    return section("How to run it again", element("pre", "\n".join(lines)), *notes)


def _environment(manifest: Manifest) -> Html:
    facts: dict[str, object] = {**manifest.get("machine", {}), **manifest.get("versions", {})}
    for name, plug_in in manifest.get("plug_ins", {}).items():
        facts[f"plug-in {name}"] = " ".join(str(value) for value in plug_in.values())
    files = [
        [link(name, name), element("code", digest)]
        for name, digest in manifest.get("files", {}).items()
    ]
    parts = [table("Machine and versions", (), [(key, str(value)) for key, value in facts.items()])]
    if files:
        parts.append(table("Files", ["file", "SHA-256"], files))
    told = element("summary", "Machine, versions, files")
    return section("Environment", element("details", told, *parts))


def _time(stamp: str | None) -> str | None:
    return f"{datetime.fromisoformat(stamp):%Y-%m-%d %H:%M:%S} UTC" if stamp else None


def _duration(started: str | None, ended: str | None) -> str | None:
    if not started or not ended:
        return None
    seconds = (datetime.fromisoformat(ended) - datetime.fromisoformat(started)).total_seconds()
    return f"{seconds:.1f} s"
