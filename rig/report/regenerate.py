"""Everything that can be derived from a run's log, derived again."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rig.experiment.measure import Samples
from rig.experiment.metrics import (
    Evaluation,
    Metric,
    constants_from_json,
    evaluate_one,
    evaluation_from_json,
    facts_from_json,
    known_measures,
)
from rig.experiment.windows import MetricError
from rig.hal import ContractBroken
from rig.report.data import mechanism_of
from rig.report.figures import draw_figures
from rig.report.html import write_html
from rig.report.limits_figure import LIMIT_FIGURES
from rig.report.timing import summarise_timing
from rig.report.truth_figure import TRUTH_FIGURES
from rig.run_facts import EVALUATION, METRICS, TIMING, MetricRow, RunStatus
from rig.run_folder import RunFolder
from rig.runtime.log import LogError
from rig.runtime.log_columns import LogColumns, read_columns
from rig.whole_file import clear_left_over


class RunReport(NamedTuple):
    """A run's page.

    Parameters
    ----------
    page : Path
        Its file.
    failures : list of str
        What is not in it, and why.
    notes : list of str
        What was asked for and has nothing to show.
    is_bare : bool
        There are figures to draw, and none could be.
    """

    page: Path
    failures: list[str]
    notes: list[str]
    is_bare: bool = False


def write_report(path: str | Path, besides: Sequence[Path] = ()) -> RunReport:
    """Derive metrics, timing, figures and ``report.html`` from a run folder alone.

    It works on any run: of one that ended early, what its log holds is judged, and the report
    says what could not be and why.

    Parameters
    ----------
    path : Path
        The run folder.
    besides : sequence of Path
        Figures (PNG) of the run that others have drawn, to be shown first.

    Returns
    -------
    RunReport
        Its page, and what is not in it.

    Raises
    ------
    ConfigurationError
        It is not a run folder.
    RunFolderError
        It cannot be written.
    """
    folder = RunFolder.open(path)
    clear_left_over(folder.path)
    problems: list[str] = []
    torn: list[str] = []
    try:
        log = read_columns(folder.log_path)
    except LogError as error:
        damaged = [str(error)] if folder.log_path.exists() else []  # a run may have had none
        return RunReport(write_html(folder, [], [str(error)]), damaged, [])
    if folder.status is not RunStatus.RUNNING:
        torn = [sentence] if (sentence := folder.missing_end(complete=log.complete)) else []
        metrics, problems = measure_run(folder, log)
        # What was measured of the whole log is not replaced by what is left of it.
        if not (folder.path / METRICS).exists() or (metrics and not torn):
            folder.write_metrics(metrics)
        if not (folder.path / TIMING).exists():
            folder.write_timing(summarise_timing(log))
    names = folder.read_json(EVALUATION, Evaluation).get("figures") or None
    # What cut commands, and what came of a fault, is worth a look whoever asked for which figures.
    asked = None if names is None else list(dict.fromkeys((*TRUTH_FIGURES, *names, *LIMIT_FIGURES)))
    drawn = draw_figures(folder.path, asked, log)
    figures = [*besides, *(file for file in drawn.files if file.suffix == ".png")]
    # Without a list everything is tried that might be there, and most of it is not.
    empty = [name for name in drawn.empty if name in (names or ())]
    notes = [f"nothing to draw: {', '.join(empty)}"] if empty else []
    page = write_html(folder, figures, [*torn, *problems], [*drawn.failures, *notes])
    is_bare = bool(drawn.failures) and not drawn.files
    return RunReport(page, [*torn, *drawn.failures], notes, is_bare)


def measure_run(folder: RunFolder, log: LogColumns) -> tuple[list[Metric], list[str]]:
    """Compute every metric of a run that its log permits.

    Returns
    -------
    metrics : list of Metric
        Those that could be computed.
    problems : list of str
        Why the others could not.
    """
    content = folder.read_json(EVALUATION, Evaluation)
    segments, specs = evaluation_from_json(content)
    if not specs:  # then nothing need be in the log
        return [], []
    facts, constants = facts_from_json(content), constants_from_json(content)
    known, samples = known_measures(mechanism_of(folder)), Samples(log, constants)
    metrics: list[Metric] = []
    problems: list[str] = []
    for name, spec in specs.items():
        measure = spec.measure or name
        if measure not in known and measure not in facts:
            # It came with the run, and so did its value.
            metrics += _as_recorded(folder, measure)
            continue
        try:
            metrics += evaluate_one(name, spec, samples, segments, known, facts)
        except (MetricError, ContractBroken) as error:
            problems.append(str(error))
    return metrics, problems


def _as_recorded(folder: RunFolder, measure: str) -> list[Metric]:
    return [
        Metric(
            row["name"], _number(row), row["unit"], row["bound"], row["bound_kind"], measure,
            row["segments"], is_seen=row["pass"] is not None or row.get("is_nan", False),
        )
        for row in folder.metrics()
        if row.get("measure") == measure
    ]  # fmt: skip


def _number(row: MetricRow) -> float:
    if row.get("is_nan"):
        return math.nan
    return math.inf if row["value"] is None else row["value"]
