"""The figures of one run, drawn from its folder alone."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY
from rig.hal import ConfigurationError
from rig.hal.fits import where
from rig.report.data import imprint_of, load_run
from rig.report.figure import FigureKind
from rig.report.style import paper_style, save
from rig.report.timing_figure import TIMING_FIGURES
from rig.run_facts import FIGURES as FIGURES_FOLDER
from rig.run_folder import RunFolderError


def known_figures(mechanism: str | None) -> dict[str, FigureKind]:
    """Return every figure by name: those of the mechanisms, and what any run's cycles cost."""
    return {**REGISTRY.figures(mechanism, FigureKind), **TIMING_FIGURES}


def own_figures(mechanism: str | None) -> tuple[str, ...]:
    """Return the names of the figures that are of a mechanism's runs; all if it is not known."""
    if mechanism is None:
        return tuple(known_figures(None))
    return (*REGISTRY.own_figures(mechanism), *TIMING_FIGURES)


class Drawn(NamedTuple):
    """The figures of a run.

    Parameters
    ----------
    files : list of Path
        Those written.
    failures : list of str
        Which others could not be drawn, and why.
    """

    files: list[Path]
    failures: list[str]


def draw_figures(path: str | Path, names: Iterable[str] | None = None) -> Drawn:
    """Draw a run's figures into its folder, as PNG and SVG.

    A figure whose quantities the log does not hold is left out; one whose code fails keeps no
    other from being drawn.

    Parameters
    ----------
    path : Path
        The run folder.
    names : iterable of str, optional
        Keys of `known_figures`; default: all.

    Returns
    -------
    Drawn
        The files, and what failed.

    Raises
    ------
    ConfigurationError
        A figure is unknown, there is no run folder, or no log in it.
    """
    run = load_run(path)
    known = known_figures(run.mechanism)
    chosen = list(known) if names is None else list(names)
    for name in chosen:
        if name not in known:
            known_names = ", ".join(known)
            raise ConfigurationError(f"there is no figure {name!r}; there are {known_names}")
    drawn = Drawn([], [])
    if len(run.log.t) < 2:
        return drawn
    folder = run.folder.place(FIGURES_FOLDER)
    with paper_style():
        for name in chosen:
            draw = known[name].draw
            try:
                figure = draw(run)
                if figure is not None:
                    drawn.files.extend(save(figure, folder, name, imprint_of([run.folder])))
            except (OSError, RunFolderError):
                raise
            except Exception as error:  # anything may happen in the code of others
                why = f"{type(error).__name__}: {error}"
                drawn.failures.append(f"the figure {name} ({where(draw)}) cannot be drawn: {why}")
    return drawn
