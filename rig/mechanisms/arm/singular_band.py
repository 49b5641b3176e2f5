"""Where the arm's figures are shaded: in the law's singular region, or near a singularity."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from controllers.arm.singular_places import NEAR
from rig.report.data import RunData
from rig.report.style import BAND

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KINDS: Final = ("shoulder", "elbow", "wrist")
_NAMES: Final = {"shoulder": "$|c|$", "elbow": "$|S_3|$", "wrist": "$|S_5|$"}
_UNITS: Final = {"shoulder": " m", "elbow": "", "wrist": ""}


def mark_region(axes: "Axes", run: RunData, kinds: Sequence[str] = KINDS) -> None:
    """Shade the singular region, from where it is entered to where it is left.

    A motion whose law plans no region is shaded where an index is below the bound of the law's
    settings, or, without one, where `singular_places` calls it near.

    Parameters
    ----------
    axes : Axes
        Over the time of the run.
    run : RunData
        The run.
    kinds : sequence of str
        The singularities that are looked at, of `KINDS`.
    """
    regions = [s for s in run.segments if s.name == "region"]
    label = "singular region"
    for segment in regions:
        axes.axvspan(segment.start, segment.end, color=BAND, lw=0, zorder=0, label=label)
        label = "_"
    label = "near singular"  # its bounds are told where one singularity is looked at alone
    for kind in () if regions else kinds:
        bound = _bound(run, kind)
        if len(kinds) == 1:
            label = f"near singular: {_NAMES[kind]} < {bound:g}{_UNITS[kind]}"
        label = _shade_near(axes, run, kind, bound, label)


def _shade_near(axes: "Axes", run: RunData, kind: str, bound: float, label: str) -> str:
    """Shade where an index is below a bound; return the label of what is shaded next."""
    name = f"plan.index_{kind}"
    if not run.has(name):
        return label
    t, near = run.time, np.abs(run.trace(name)) < bound
    edges = np.flatnonzero(np.diff(np.concatenate(([False], near, [False])).astype(int)))
    for start, end in edges.reshape(-1, 2):
        axes.axvspan(t[start], t[min(end, len(t) - 1)], color=BAND, lw=0, zorder=0, label=label)
        label = "_"
    return label


def _bound(run: RunData, kind: str) -> float:
    """Return the least index of the law's settings, or what is called near a singularity."""
    said = run.law_settings.get(f"{kind}_region")
    return float(said) if isinstance(said, int | float) and said else NEAR[KINDS.index(kind)]
