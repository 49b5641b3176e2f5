"""Which foot of walking legs stands when: as planned, and as it was."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.mechanisms.legs.figures.base import COLORS, LEGS, mark_phases
from rig.report.data import RunData
from rig.report.figure import TIME_LABEL, FigureKind
from rig.report.style import PAGE, SHADE, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_STANDS: Final = 0.05
"""A foot stands that bears this share of what both bear at most."""
_HEIGHT: Final = 0.36
_GAP: Final = 0.05
"""A shorter break of a contact (s) is a bounce of its load, which no bar shows."""
_PALE: Final = 0.35
"""Of what is planned: so much of a foot's colour, the rest is white."""


def draw_contacts(run: RunData) -> "Figure | None":
    """Draw bars of the time in which each foot is planned to stand, and in which it bears load."""
    if not run.has(*(f"plan.stands_{leg}" for leg in LEGS)):
        return None
    loads = _loads(run)
    figure = new_figure(PAGE, 40.0)
    axes = figure.subplots()
    t = run.time
    for row, leg in enumerate(LEGS):
        _draw_bars(axes, t, run.trace(f"plan.stands_{leg}") > 0.0, row - 0.2, leg, _PALE)
        if loads:
            _draw_bars(axes, t, loads[leg], row + 0.2, leg, 1.0)
    rows = [row + side for row in range(len(LEGS)) for side in (-0.2, 0.2)]
    told = [f"{leg}, {what}" for leg in LEGS for what in ("planned", "bears load")]
    shown = slice(None) if loads else slice(None, None, 2)
    axes.set_yticks(rows[shown], labels=told[shown])
    axes.set_ylim(len(LEGS) - 0.4, -0.6)
    axes.set_xlim(float(t[0]), float(t[-1]))
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(TIME_LABEL)
    mark_phases(axes, run)
    _explain(figure, has_loads=bool(loads))
    return figure


def _explain(figure: "Figure", *, has_loads: bool) -> None:
    """Say above the bars what their colours and the shades behind them are."""
    from matplotlib.patches import Patch

    handles = [Patch(color=_paled(leg, _PALE), lw=0, label=f"{leg}, planned") for leg in LEGS]
    if has_loads:
        handles += [Patch(color=COLORS[leg], lw=0, label=f"{leg}, bears load") for leg in LEGS]
    handles.append(Patch(color=SHADE, lw=0, label="swing"))
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles), frameon=False)


def _loads(run: RunData) -> "dict[str, NDArray[np.bool_]]":
    """Return when each foot bears load: by its cells, else as the simulation knows; or nothing."""
    found = {}
    for leg in LEGS:
        cells = [name for name in run.log.names("reading.force_") if f"_{leg}_" in f"{name}_"]
        if cells:
            found[leg] = np.sum([run.trace(name) for name in cells], axis=0)
        elif run.has(f"truth.load_{leg}"):
            found[leg] = run.trace(f"truth.load_{leg}")
    if len(found) < len(LEGS):
        return {}
    weight = float(np.max(sum(found.values())))
    return {leg: force > _STANDS * weight for leg, force in found.items()}


def _draw_bars(
    axes: "Axes", t: "NDArray[np.float64]", stands: "NDArray[np.bool_]", row: float, leg: str,
    share: float,
) -> None:  # fmt: skip
    color = _paled(leg, share)
    stretches = list(stretches_of(t, stands))
    axes.broken_barh(
        [(start, end - start) for start, end in stretches], (row - 0.5 * _HEIGHT, _HEIGHT),
        color=color, lw=0, zorder=2,
    )  # fmt: skip
    # A table of what is drawn has lines alone: each stretch is one, too.
    for start, end in stretches:
        axes.plot([start, end], [row, row], color="none", label=f"{leg} stands")


def _paled(leg: str, share: float) -> tuple[float, float, float]:
    """Return a share of a foot's colour, the rest white."""
    from matplotlib.colors import to_rgb

    red, green, blue = (share * part + 1.0 - share for part in to_rgb(COLORS[leg]))
    return red, green, blue


def stretches_of(
    t: "NDArray[np.float64]", stands: "NDArray[np.bool_]"
) -> Iterator[tuple[float, float]]:
    """Yield from when to when something was so; a break of less than 50 ms is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], stands.astype(int), [0]])))
    begun: tuple[float, float] | None = None
    for first, after in edges.reshape(-1, 2).tolist():
        start, end = float(t[first]), float(t[min(after, len(t) - 1)])
        if begun is not None and start - begun[1] < _GAP:
            begun = begun[0], end
            continue
        if begun is not None:
            yield begun
        begun = start, end
    if begun is not None:
        yield begun


CONTACT_FIGURES = {
    "contacts": FigureKind(
        draw_contacts,
        "Which foot stands when: pale as planned, full while it bears load; swings are shaded.",
    ),
}
