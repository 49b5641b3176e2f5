"""The figures of one run, drawn from its folder alone."""

from collections.abc import Iterable
from pathlib import Path

from rig.mechanisms.arm.figures import ARM_FIGURES
from rig.mechanisms.cylinder.figures import PAIR_FIGURES
from rig.mechanisms.joint.figures.camera import CAMERA_FIGURES
from rig.mechanisms.joint.figures.health import HEALTH_FIGURES
from rig.mechanisms.joint.figures.maps import MAP_FIGURES
from rig.mechanisms.joint.figures.tracking import JOINT_FIGURES
from rig.mechanisms.legs.figures.gait import LEGS_FIGURES
from rig.report.data import load_run
from rig.report.figure import FigureKind
from rig.report.style import paper_style, save
from rig.report.timing_figure import TIMING_FIGURES
from rig.run_folder import FIGURES as FIGURES_FOLDER

FIGURES: dict[str, FigureKind] = {
    **PAIR_FIGURES,
    **JOINT_FIGURES,
    **CAMERA_FIGURES,
    **HEALTH_FIGURES,
    **MAP_FIGURES,
    **LEGS_FIGURES,
    **ARM_FIGURES,
    **TIMING_FIGURES,
}


def draw_figures(path: str | Path, names: Iterable[str] | None = None) -> list[Path]:
    """Draw a run's figures into its folder, as PNG and SVG.

    A figure whose quantities the log does not hold is left out.

    Parameters
    ----------
    path : Path
        The run folder.
    names : iterable of str, optional
        Keys of `FIGURES`; default: all.

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
    chosen = list(FIGURES) if names is None else list(names)
    for name in chosen:
        if name not in FIGURES:
            raise ValueError(f"there is no figure {name!r}; there are {', '.join(FIGURES)}")
    run = load_run(path)
    written: list[Path] = []
    if len(run.log.t) < 2:
        return written
    with paper_style():
        for name in chosen:
            figure = FIGURES[name].draw(run)
            if figure is not None:
                written += save(figure, run.folder.path / FIGURES_FOLDER, name)
    return written
