"""Several runs of one experiment side by side: one figure and one table."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from rig.hal import ConfigurationError
from rig.report.comparison import ComparisonRow, rows_of_metrics
from rig.report.comparisons import comparison_of
from rig.report.data import RunData, imprint_of, load_run
from rig.report.style import paper_style, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compare_metrics(paths: Sequence[str | Path], labels: Sequence[str]) -> list[ComparisonRow]:
    """Collect the metrics of several runs, or what their kind of rig is compared by.

    Parameters
    ----------
    paths : sequence of Path
        Run folders.
    labels : sequence of str
        What to call each run, e.g. its controller.

    Returns
    -------
    list of ComparisonRow
        One per metric, in the order of the first run that has it.
    """
    runs = _load(paths, labels)
    tabulate = comparison_of(runs).tabulate
    if tabulate is not None:
        return tabulate(runs, labels)
    return rows_of_metrics(runs)


def draw_comparison(
    paths: Sequence[str | Path],
    labels: Sequence[str],
    folder: str | Path,
    absent: Mapping[str, str] = MappingProxyType({}),
) -> list[Path]:
    """Draw runs side by side, as their kind of rig wants it.

    Parameters
    ----------
    paths : sequence of Path
        Run folders.
    labels : sequence of str
        What to call each run.
    folder : Path
        Where ``compare.png`` and ``compare.svg`` go.
    absent : mapping of str to str
        Who is not drawn, and why in a word: ``refused``.

    Raises
    ------
    ConfigurationError
        There are no runs, or not one label for each.
    """
    runs = _load(paths, labels)
    with paper_style():
        figure = comparison_of(runs).draw(runs, labels)
        if absent:
            told = ", ".join(f"{label} ({why})" for label, why in absent.items())
            figure.suptitle(f"not drawn: {told}", x=0.01, ha="left", fontsize=7.0)
        return save(figure, Path(folder), "compare", imprint_of([run.folder for run in runs]))


def comparison_figure(paths: Sequence[str | Path], labels: Sequence[str]) -> "Figure":
    """Return what `draw_comparison` draws, for who shows it instead of keeping it."""
    runs = _load(paths, labels)
    with paper_style():
        return comparison_of(runs).draw(runs, labels)


def _load(paths: Sequence[str | Path], labels: Sequence[str]) -> list[RunData]:
    if not paths or len(paths) != len(labels):
        raise ConfigurationError(
            f"a comparison needs runs and one label for each, not {len(paths)} runs and "
            f"{len(labels)} labels"
        )
    return [load_run(path) for path in paths]
