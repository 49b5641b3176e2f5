"""The figure of a run beside another one of the same motion: its simulated twin, for instance."""

from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.hal import ConfigurationError
from rig.hal.columns import Column
from rig.report.data import RunData, imprint_of, load_run, origin_of
from rig.report.figure import draw_line, panels
from rig.report.style import (
    BLUE,
    GREY,
    INK,
    PAGE,
    VERMILION,
    length_scale,
    new_figure,
    paper_style,
    place_legend,
    save,
)
from rig.run_facts import FIGURES

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

BESIDE: Final = "beside"
"""The figure's name."""
CAPTION: Final = "The run, another one of the same motion over it, and what is between them."
_UNITS: Final = ("m", "rad")
_MOST: Final = 6
"""Quantities that have a row: those in which the runs are furthest apart."""


class Residual(NamedTuple):
    """The distance of two runs in one quantity.

    Parameters
    ----------
    name : str
        Its column.
    unit : str
        SI.
    rms, greatest : float
        Of one less the other, while both followed the reference.
    """

    name: str
    unit: str
    rms: float
    greatest: float


class _Pairing(NamedTuple):
    """A quantity of both runs at the same times of their reference."""

    column: Column
    first: "Array"
    second: "Array"

    @property
    def residual(self) -> "Array":
        return self.first - self.second

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.residual**2)))


class Beside(NamedTuple):
    """Two runs side by side: how far they are apart, the worst first, and the figure's files."""

    residuals: list[Residual]
    files: list[Path]


def draw_beside(path: Path, other: Path) -> Beside:
    """Draw a run with another one over it into its folder, and return how far they are apart.

    Parameters
    ----------
    path, other : Path
        Run folders; what both measured of what they followed is compared at the same times of
        the reference.

    Raises
    ------
    ConfigurationError
        They have nothing in common.
    RunFolderError
        The figure cannot be written.
    """
    run, second = load_run(path), load_run(other)
    t, pairings = _paired(run, second)
    residuals = [
        Residual(one.column.name, one.column.unit, one.rms, float(np.abs(one.residual).max()))
        for one in pairings
    ]
    labels = [origin_of(of.folder) or of.folder.path.name for of in (run, second)]
    if labels[0] == labels[1]:
        labels = [run.folder.path.name, second.folder.path.name]
    with paper_style():
        figure = _draw(t, pairings[:_MOST], labels)
        imprint = imprint_of([run.folder, second.folder])
        return Beside(residuals, save(figure, run.folder.place(FIGURES), BESIDE, imprint))


def _paired(run: RunData, other: RunData) -> "tuple[Array, list[_Pairing]]":
    """Return common times of the reference, s, and what both measured there, the worst first."""
    t = run.time
    t = t[(t >= other.time[0]) & (t <= other.time[-1])] if len(other.time) else t[:0]
    shared = [
        column
        for column in run.log.columns
        if column.name.startswith("reading.")
        and column.unit in _UNITS
        and run.has(column.name.replace("reading.", "reference.", 1))
        and other.has(column.name)
    ]
    if len(t) < 2 or not shared:
        raise ConfigurationError(
            f"{run.folder.path.name} and {other.folder.path.name} have nothing in common that both "
            "measured while they followed a reference"
        )
    pairings = [
        _Pairing(
            column,
            *(np.interp(t, of.time, of.trace(column.name)) for of in (run, other)),
        )
        for column in shared
    ]
    return t, sorted(pairings, key=lambda one: -one.rms)


def _draw(t: "Array", pairings: list[_Pairing], labels: list[str]) -> "Figure":
    figure = new_figure(PAGE, 22.0 + 30.0 * len(pairings))
    grid = panels(figure, len(pairings), 2, sharex=True)
    for number, one in enumerate(pairings):
        both, apart = grid[2 * number : 2 * number + 2]
        factor, unit = _scale(one.column.unit, max(np.abs(one.first).max(), 1e-9))
        draw_line(both, t, one.first * factor, BLUE, labels[0], lw=1.4)
        draw_line(both, t, one.second * factor, INK, labels[1], lw=0.7, ls=(0, (4, 2)))
        name = one.column.name.removeprefix("reading.").replace("_", " ")
        both.set_ylabel(f"{name} ({unit})")
        factor, unit = _scale(one.column.unit, float(np.abs(one.residual).max()))
        apart.axhline(0.0, color=GREY, lw=0.5)
        draw_line(apart, t, one.residual * factor, VERMILION, "residual", lw=0.7)
        apart.set_ylabel(f"residual ({unit})")
        apart.set_title(f"rms {one.rms * factor:.3g} {unit}", loc="right")
        both.set_xlim(float(t[0]), float(t[-1]))
    place_legend(grid[0], 2)
    for axes in grid[-2:]:
        axes.set_xlabel("time since the reference started (s)")
    figure.align_ylabels()
    return figure


def _scale(unit: str, extent: float) -> tuple[float, str]:
    return length_scale(extent) if unit == "m" else (180.0 / np.pi, "deg")
