"""How well places are reached again: scatter of repeated visits, and where further ones would end.

References
----------
ISO 9283:1998, section 7.2: pose accuracy and pose repeatability.
H. Hotelling, Ann. Math. Stat. 2(3), 1931: the region of a further observation.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.report.data import RunData
from rig.report.figure import panels
from rig.report.style import GREY, INK, PAGE, PALETTE, length_scale, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

CONFIDENCE: Final = 0.95
_LEAST: Final = 3
"""Visits of which a scatter is drawn, beyond the number of directions in which they scatter."""
_MOST: Final = 5
"""Places that have a panel."""
_SAME: Final = 1e-6
"""Targets that are no further apart are one place, m."""
_CORNERS: Final = 120
_FURTHER: Final = "95 % of further visits"


class RevisitedPlace(NamedTuple):
    """A place that was gone to more than once.

    Parameters
    ----------
    name : str
        For its panel.
    ends : ndarray, shape (n, k)
        Where each visit ended, off its target, m; k is 1 on a line and 2 on a surface.
    """

    name: str
    ends: "Array"

    @property
    def mean(self) -> "Array":
        """Where visits end on average, off the target, m, shape (k,)."""
        return np.asarray(self.ends.mean(axis=0))

    @property
    def accuracy(self) -> float:
        """Distance of that from the target, m: pose accuracy AP of ISO 9283."""
        return float(np.linalg.norm(self.mean))

    @property
    def repeatability(self) -> float:
        """Mean distance from the mean and three standard deviations of it, m: RP of ISO 9283."""
        distances = np.linalg.norm(self.ends - self.mean, axis=1)
        return float(distances.mean() + 3.0 * distances.std(ddof=1))

    def region(self) -> "Array":
        """Return the outline of where a further visit ends with 95 % confidence, off the mean, m.

        Returns
        -------
        ndarray
            Of an ellipse, shape (m, 2); the two ends of an interval on a line, shape (2, 1).
        """
        from scipy.stats import f

        n, k = self.ends.shape
        share = k * (n * n - 1) / (n * (n - k)) * float(f.ppf(CONFIDENCE, k, n - k))
        spread = np.atleast_2d(np.cov(self.ends.T))
        values, vectors = np.linalg.eigh(spread)
        axes = vectors * np.sqrt(np.maximum(values, 0.0) * share)
        if k == 1:
            return np.asarray(np.array([[-1.0], [1.0]]) * axes[0, 0])
        angle = np.linspace(0.0, 2.0 * math.pi, _CORNERS)
        return np.asarray(np.column_stack([np.cos(angle), np.sin(angle)]) @ axes.T)


class Visit(NamedTuple):
    """A hold: its name, where it was to be and where it was, m, shape (k,) or (3,)."""

    name: str
    target: "Array"
    end: "Array"


def visits_of(run: RunData, target: "Array", reached: "Array") -> list[Visit]:
    """Return what was wanted and what came of it, on average over each hold of a run.

    Parameters
    ----------
    run : RunData
        The run; its segments that begin with "hold" are visits.
    target, reached : ndarray, shape (n, k)
        Of the cycles that followed the reference, m.
    """
    found = []
    for segment in run.segments:
        part = (run.time >= segment.start) & (run.time < segment.end)
        if segment.name.startswith("hold") and part.any() and run.time[-1] >= 0.99 * segment.end:
            end = reached[part].mean(axis=0)
            found.append(Visit(segment.name, target[part].mean(axis=0), end))
    return found


def places_of(
    visits: Iterable[Visit], off: "Callable[[Visit], Array]", name: Callable[[Visit], str]
) -> list[RevisitedPlace]:
    """Return the places that were gone to often enough, in the order of their first visit.

    Parameters
    ----------
    visits : iterable of Visit
        All of them.
    off : callable
        Returns how far a visit ended off its target along one or two directions, m.
    name : callable
        Returns what to call its place.
    """
    groups: list[list[Visit]] = []
    for visit in visits:
        for group in groups:
            if np.linalg.norm(group[0].target - visit.target) <= _SAME:
                group.append(visit)
                break
        else:
            groups.append([visit])
    places = [
        RevisitedPlace(name(group[0]), np.array([off(visit) for visit in group]))
        for group in groups
    ]
    return [place for place in places if len(place.ends) >= _LEAST + place.ends.shape[1] - 1]


def draw_repeatability(
    places: Sequence[RevisitedPlace], directions: Sequence[str]
) -> "Figure | None":
    """Draw the visits of each place about their mean, with the region of a further one.

    Parameters
    ----------
    places : sequence of RevisitedPlace
        All with the same number of directions; None is drawn of none.
    directions : sequence of str
        What to call each.
    """
    if not places:
        return None
    shown = places[:_MOST]
    extent = max(
        float(np.abs(np.concatenate([place.region(), place.ends - place.mean])).max())
        for place in shown
    )
    factor, unit = length_scale(extent)
    figure = new_figure(PAGE, 58.0)
    grid = panels(figure, 1, max(len(shown), 3), sharex=len(directions) > 1, sharey=True)
    for axes, place, color in zip(grid, shown, PALETTE, strict=False):
        _draw_place(axes, place, color, factor)
        off, again = (_brief(value) for value in (place.accuracy, place.repeatability))
        axes.set_title(f"{place.name}, {len(place.ends)} visits\nAP {off}, RP {again}")
        reach = 1.15 * factor * extent
        axes.set_ylim(-reach, reach)
        if len(directions) > 1:
            axes.set_xlim(-reach, reach)
            axes.set_aspect("equal", adjustable="box")
            axes.set_xlabel(f"{directions[0]} ({unit})")
        else:
            axes.set_xlabel("visit")
    for axes in grid[len(shown) :]:
        axes.set_visible(False)
    grid[0].set_ylabel(f"{directions[-1]} ({unit})")
    grid[0].legend(loc="lower left", fontsize=6.0, handlelength=2.0)
    return figure


def _draw_place(axes: "Axes", place: RevisitedPlace, color: str, factor: float) -> None:
    ends = (place.ends - place.mean) * factor
    region = place.region() * factor
    axes.axhline(0.0, color=GREY, lw=0.5)
    if ends.shape[1] == 1:
        count = np.arange(1, len(ends) + 1)
        for label, side in zip((_FURTHER, f"_{_FURTHER}"), region[:, 0].tolist(), strict=True):
            axes.plot(count[[0, -1]], [side] * 2, color=INK, lw=0.8, ls=(0, (4, 2)), label=label)
        axes.plot(count, ends[:, 0], "o", ms=3.0, color=color, label="visits")
        axes.set_xticks(count[:: max(1, -(-len(count) // 8))])
        return
    axes.axvline(0.0, color=GREY, lw=0.5)
    axes.plot(*region.T, color=INK, lw=0.8, ls=(0, (4, 2)), label=_FURTHER)
    axes.plot(*ends.T, "o", ms=3.0, color=color, label="visits")


def _brief(value: float) -> str:
    factor, unit = length_scale(value)
    return (
        f"{value * factor:.2g} {unit}" if value * factor < 100.0 else f"{value * factor:.0f} {unit}"
    )
