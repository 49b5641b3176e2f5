"""The loop that a run has measured, as a figure of its report."""

from typing import TYPE_CHECKING

from rig.assembly import REGISTRY, make_law
from rig.config import load_profile
from rig.hal import RigError
from rig.report.data import RunData
from rig.report.figure import FigureKind
from rig.report.loop_figure import draw_loops

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_margins(run: RunData) -> "Figure | None":
    """Draw the loop of the law that ran; None where the run does not tell it."""
    try:
        profile = load_profile(run.folder.path / "profile.yaml", REGISTRY)
        tell = REGISTRY.measured_loop(profile.mechanism)
        law = make_law(profile, str(run.folder.manifest["law"]))
        return None if tell is None else draw_loops({"in force": tell(run, law)})
    except (RigError, OSError, KeyError):
        return None


MARGINS_FIGURES = {
    "margins": FigureKind(
        draw_margins,
        "Gain and phase of the open loop, broken at the setpoints, and the sensitivity: as "
        "measured while the pair glides and is shaken (shaded: 95 % of what glides differ by), and "
        "dashed as the linear model of `rig check` says.",
    ),
}
