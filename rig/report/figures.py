"""The figures of one run, drawn from its folder alone."""

from collections.abc import Iterable
from pathlib import Path

from rig.assembly import REGISTRY
from rig.report.data import load_run, origin_of
from rig.report.figure import FigureKind
from rig.report.style import paper_style, save
from rig.report.timing_figure import TIMING_FIGURES
from rig.run_folder import FIGURES as FIGURES_FOLDER


def known_figures(mechanism: str | None) -> dict[str, FigureKind]:
    """Return every figure by name: those of the mechanisms, and what any run's cycles cost."""
    return {**REGISTRY.figures(mechanism, FigureKind), **TIMING_FIGURES}


def draw_figures(path: str | Path, names: Iterable[str] | None = None) -> list[Path]:
    """Draw a run's figures into its folder, as PNG and SVG.

    A figure whose quantities the log does not hold is left out.

    Parameters
    ----------
    path : Path
        The run folder.
    names : iterable of str, optional
        Keys of `known_figures`; default: all.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ValueError
        A figure is unknown.
    ConfigurationError, LogError
        There is no run folder, or no log in it.
    """
    run = load_run(path)
    known = known_figures(run.mechanism)
    chosen = list(known) if names is None else list(names)
    for name in chosen:
        if name not in known:
            raise ValueError(f"there is no figure {name!r}; there are {', '.join(known)}")
    written: list[Path] = []
    if len(run.log.t) < 2:
        return written
    with paper_style():
        for name in chosen:
            figure = known[name].draw(run)
            if figure is not None:
                written += save(
                    figure, run.folder.path / FIGURES_FOLDER, name, origin_of(run.folder)
                )
    return written
