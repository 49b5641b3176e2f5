"""The figures of one run, drawn from its folder alone."""

import importlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY
from rig.hal import ConfigurationError
from rig.hal.fits import where
from rig.report.column_figure import column_figure, file_of, is_column
from rig.report.copies import Lost, may_copy, share_out
from rig.report.data import RunData, imprint_of, load_run
from rig.report.figure import FigureKind
from rig.report.limits_figure import LIMIT_FIGURES
from rig.report.style import paper_style, save
from rig.report.timing_figure import TIMING_FIGURES
from rig.report.truth_figure import TRUTH_FIGURES
from rig.run_facts import FIGURES as FIGURES_FOLDER
from rig.run_folder import RunFolderError
from rig.runtime.log_columns import LogColumns
from rig.whole_file import clear_left_over

ANY_RUN = {**TIMING_FIGURES, **LIMIT_FIGURES, **TRUTH_FIGURES}
"""The figures that do not depend on the mechanism."""


def known_figures(mechanism: str | None) -> dict[str, FigureKind]:
    """Return every figure by name: those of the mechanisms, and of any run."""
    return {**REGISTRY.figures(mechanism, FigureKind), **ANY_RUN}


def own_figures(mechanism: str | None) -> tuple[str, ...]:
    """Return the names of the figures that are of a mechanism's runs; all if it is not known."""
    if mechanism is None:
        return tuple(known_figures(None))
    return (*REGISTRY.own_figures(mechanism), *ANY_RUN)


def figure_kind(name: str, known: Mapping[str, FigureKind]) -> FigureKind | None:
    """Return a figure by its name among those that are known, or by a column; None: neither."""
    return known.get(name) or (column_figure(name) if is_column(name) else None)


class Drawn(NamedTuple):
    """The figures of a run.

    Parameters
    ----------
    files : list of Path
        Those written.
    failures : list of str
        Which others could not be drawn, and why.
    empty : list of str
        Which had nothing to draw: the log lacks what they show, or it never happened.
    """

    files: list[Path]
    failures: list[str]
    empty: list[str]


def draw_figures(
    path: str | Path, names: Iterable[str] | None = None, log: LogColumns | None = None
) -> Drawn:
    """Draw a run's figures into its folder, as PNG and SVG.

    A figure whose quantities the log does not hold is left out; one whose code fails keeps no
    other from being drawn.

    Parameters
    ----------
    path : Path
        The run folder.
    names : iterable of str, optional
        Keys of `known_figures`, or columns of the log (``device.oil_value``, ``device.oil_*``);
        default: all that are known.
    log : LogColumns, optional
        The run's log, if it has been read already.

    Returns
    -------
    Drawn
        The files, and what failed.

    Raises
    ------
    ConfigurationError
        A figure is unknown, there is no run folder, or no log in it.
    """
    run = load_run(path, log)
    known = known_figures(run.mechanism)
    chosen = list(known) if names is None else list(names)
    for name in chosen:
        if figure_kind(name, known) is None:
            known_names = ", ".join(known)
            raise ConfigurationError(f"there is no figure {name!r}; there are {known_names}")
    drawn = Drawn([], [], [])
    if len(run.log.t) < 2:
        return drawn
    folder = run.folder.place(FIGURES_FOLDER)
    clear_left_over(folder)
    try:
        with paper_style():
            for one in _share_out(partial(_draw, run, folder), chosen):
                drawn.files.extend(one.files)
                drawn.failures.extend(one.failures)
                drawn.empty.extend(one.empty)
    finally:
        clear_left_over(folder)  # of a copy that was killed
    return drawn


def _draw(run: RunData, folder: Path, name: str) -> Drawn:
    """Draw one figure into a folder, or say why not."""
    kind = figure_kind(name, known_figures(run.mechanism))
    assert kind is not None  # it was looked for before
    draw = kind.draw
    try:
        figure = draw(run)
        if figure is None:
            return Drawn([], [], [name])
        content = None if kind.table is None else kind.table(run)
        origin = imprint_of([run.folder])
        return Drawn(save(figure, folder, file_of(name), origin, content=content), [], [])
    except (OSError, RunFolderError):
        raise
    except Exception as error:  # anything may happen in the code of others
        why = f"{type(error).__name__}: {error}"
        return Drawn([], [f"the figure {name} ({where(draw)}) cannot be drawn: {why}"], [])


def _share_out(draw: Callable[[str], Drawn], names: list[str]) -> Iterator[Drawn]:
    """Draw on every processor that this process has, where it can be copied."""
    workers = min(len(names), len(os.sched_getaffinity(0)))
    if workers < 2 or not may_copy():
        yield from map(draw, names)
        return
    import_once()
    # The last ones are of any run, on logarithmic axes, and take longest: they begin.
    found = share_out(draw, names[::-1], workers)
    for name, one in zip(names, reversed(found), strict=True):
        if isinstance(one, Lost):
            yield Drawn([], [f"the figure {name} cannot be drawn: {one}"], [])
        else:
            yield one


def import_once() -> None:
    """Import what draws and writes figures, before copies of this process do so each."""
    for name in ("figure", "backends.backend_agg", "backends.backend_svg", "backends.backend_pdf"):
        importlib.import_module(f"matplotlib.{name}")
