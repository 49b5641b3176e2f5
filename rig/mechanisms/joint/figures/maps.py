"""What the joint can do, as maps over all directions and as curves over its mean pressure."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from rig.experiment.measure import Samples, Window
from rig.mechanisms.joint.measures.stiffness import yielding
from rig.mechanisms.joint.measures.tracking import CHANNELS
from rig.report.data import RunData
from rig.report.envelope import path_envelope
from rig.report.figure import FigureKind
from rig.report.style import BLUE, GREY, INK, ORANGE, PAGE, VERMILION, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_LOOP_ROWS = 2
"""Of panels, one for each pressure."""
_RINGS, _SECTORS = 8, 36
"""Fields of a map; a spiral passes each of them while it has as many rounds as rings."""


class _Map(NamedTuple):
    """One quantity over tilt and azimuth.

    Parameters
    ----------
    title : str
        With the unit.
    values : ndarray
        At every instant, shape (n,).
    worst : callable
        Takes the values in a field; returns the one that is shown.
    colors : str
        A colour map of matplotlib's.
    logarithmic : bool
        Whether its colours go by powers of ten.
    """

    title: str
    values: "Array"
    worst: "Callable[[Array], float]"
    colors: str
    logarithmic: bool = False


def draw_range_map(run: RunData) -> "Figure | None":
    """Draw tension, error of the wires and of the paper's wires over tilt and azimuth."""
    if not run.has("plan.reach", "reference.axis_x", "estimate.tension_ch1"):
        return None
    # The way home goes over fields that were passed already, and much faster.
    out = next((segment.end for segment in run.segments if segment.name == "spiral"), np.inf)
    part = run.followed & (run.t < out)
    if not part.any():
        return None
    x, y, z = (run.log.column(f"reference.axis_{axis}")[part] for axis in "xyz")
    tilt, azimuth = np.degrees(np.arctan2(np.hypot(x, y), z)), np.arctan2(y, x)
    source = "truth" if run.has("truth.tension_ch1") else "estimate"
    least = np.min([run.log.column(f"{source}.tension_{name}")[part] for name in CHANNELS], axis=0)
    wires = np.max(
        [
            np.abs(run.log.column(f"reference.rod_{name}") - run.log.column(f"reading.rod_{name}"))
            for name in CHANNELS
        ],
        axis=0,
    )[part]
    maps = (
        _Map("least tension (N)", least, np.min, "viridis"),
        _Map("greatest error of a wire (mm)", wires * 1e3, np.max, "magma_r"),
        _Map(
            "error of the paper's wire (µm)",
            run.log.column("plan.paper_error")[part] * 1e6,
            np.max,
            "cividis_r",
            logarithmic=True,
        ),
    )
    figure = new_figure(PAGE, 78.0)
    reach = np.degrees(run.log.column("plan.reach")[part])
    edges = np.linspace(0.0, float(tilt.max()) + 1e-6, _RINGS + 1)
    for number, shown in enumerate(maps):
        axes = cast("PolarAxes", figure.add_subplot(1, 3, number + 1, projection="polar"))
        _draw_map(figure, axes, shown, tilt, azimuth, edges)
        axes.plot(*_outline(azimuth, reach), color=VERMILION, lw=0.9, label="reach")
        axes.set_rmax(1.04 * float(reach.max()))
        axes.set_rticks([20, 40, 60])
        axes.set_rlabel_position(68.0)
        axes.set_thetagrids([0, 90, 180, 270], ["ch4", "ch1", "ch2", "ch3"])
        axes.tick_params(labelsize=6.5, pad=0.0)
        axes.set_title(shown.title, pad=14.0)
        axes.grid(lw=0.3, color="white" if number != 1 else GREY, alpha=0.6)
        if number == 0:
            axes.legend(loc="lower left", bbox_to_anchor=(-0.22, -0.2))
    return figure


def _outline(azimuth: "Array", reach: "Array") -> "tuple[Array, Array]":
    """Return a closed line through the reach in each sector."""
    edges = np.linspace(-np.pi, np.pi, _SECTORS + 1)
    sector = np.digitize(azimuth, edges[1:-1])
    known = [number for number in range(_SECTORS) if np.any(sector == number)]
    around = np.array([0.5 * (edges[number] + edges[number + 1]) for number in known])
    limit = np.array([float(np.median(reach[sector == number])) for number in known])
    return np.append(around, around[:1]), np.append(limit, limit[:1])


def _draw_map(
    figure: "Figure", axes: "Axes", shown: _Map, tilt: "Array", azimuth: "Array", edges: "Array"
) -> None:
    from matplotlib.colors import LogNorm

    sectors = np.linspace(-np.pi, np.pi, _SECTORS + 1)
    ring = np.clip(np.digitize(tilt, edges) - 1, 0, len(edges) - 2)
    sector = np.clip(np.digitize(azimuth, sectors) - 1, 0, _SECTORS - 1)
    field = np.full((len(edges) - 1, _SECTORS), np.nan)
    for row in range(len(edges) - 1):
        for column in range(_SECTORS):
            values = shown.values[(ring == row) & (sector == column)]
            if len(values):
                field[row, column] = shown.worst(values)
    norm = None
    if shown.logarithmic:
        norm = LogNorm(max(float(np.nanmin(field)), 1e-3), float(np.nanmax(field)))
        field = np.maximum(field, 1e-3)
    mesh = axes.pcolormesh(
        sectors, edges, field, cmap=shown.colors, norm=norm, edgecolors="face", linewidth=0.1
    )
    mesh.set_rasterized(True)
    bar = figure.colorbar(mesh, ax=axes, orientation="horizontal", fraction=0.05, pad=0.1)
    bar.ax.tick_params(labelsize=6.5, width=0.4, length=2.0)
    bar.outline.set_linewidth(0.4)


def draw_stiffness(run: RunData) -> "Figure | None":
    """Draw how a pose gives way to a push, and its stiffness over the mean pressure."""
    if not run.has("estimate.tension_ch1", "reading.rod_ch1", "reading.pressure_ch1"):
        return None
    samples = Samples(run.log)
    windows = []
    for segment in run.segments:
        if segment.name.endswith("kPa") and len(samples.t) and samples.t[-1] >= segment.end - 0.1:
            first, last = np.searchsorted(samples.t, [segment.start, segment.end])
            windows.append(Window(segment, samples, slice(int(first), int(last))))
    if not windows:
        return None
    figure = new_figure(PAGE, 84.0)
    wide = -(-len(windows) // _LOOP_ROWS)
    grid = figure.add_gridspec(_LOOP_ROWS, 2 * wide)
    corner: Axes | None = None
    for number, window in enumerate(windows):
        row, column = divmod(number, wide)
        axes = figure.add_subplot(grid[row, column], sharex=corner, sharey=corner)
        corner = corner or axes
        _draw_loop(axes, window)
        axes.tick_params(labelbottom=row == _LOOP_ROWS - 1, labelleft=column == 0)
        if row == _LOOP_ROWS - 1:
            axes.set_xlabel("rods (µm)")
        if column == 0:
            axes.set_ylabel("push on the pair (N)")
    curve = figure.add_subplot(grid[:, wide:])
    found = [yielding(window) for window in windows]
    pressure = [each.pressure * 1e-3 for each in found]
    stiffness = [each.stiffness * 1e-6 for each in found]
    curve.plot(pressure, stiffness, "-o", color=BLUE, ms=3.5, label="stiffness")
    curve.set_ylim(0.0, 1.25 * max(stiffness))
    curve.set_xlabel("mean pressure of the four chambers (kPa)")
    curve.set_ylabel("stiffness at the rods (N/µm)")
    lag = curve.twinx()
    lag.plot(
        pressure, [np.degrees(each.lag) for each in found], "--s", color=ORANGE, ms=2.5, lw=0.7,
        label="lag",
    )  # fmt: skip
    lag.set_ylabel("lag of the rods (deg)", color=ORANGE)
    lag.set_ylim(0.0, max(30.0, *(1.25 * np.degrees(each.lag) for each in found)))
    lag.grid(visible=False)
    curve.plot([], [], "--s", color=ORANGE, ms=2.5, lw=0.7, label="lag")
    place_legend(curve, 2)
    curve.axhline(0.0, color=INK, lw=0.4)
    return figure


def _draw_loop(axes: "Axes", window: Window) -> None:
    """Draw how the rods of a pair gave way to its push at one pressure."""
    force = window.column("estimate.tension_ch1") - window.column("estimate.tension_ch3")
    position = 0.5 * (window.column("reading.rod_ch1") - window.column("reading.rod_ch3"))
    path = path_envelope((position - position.mean()) * 1e6, force - force.mean())
    axes.plot(*path, color=BLUE, lw=0.5)
    axes.set_title(window.segment.name)


MAP_FIGURES = {
    "range-map": FigureKind(
        draw_range_map,
        "Least tension and greatest errors over tilt (20, 40, 60 deg) and direction, towards the "
        "wires ch1 to ch4; how far the joint would reach in each direction.",
    ),
    "stiffness": FigureKind(
        draw_stiffness,
        "A slow push on held pressures and how far the pair gives; stiffness over mean pressure.",
    ),
}
