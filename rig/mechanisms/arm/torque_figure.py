"""The torques of an arm's drives against their limits."""

from typing import TYPE_CHECKING

import numpy as np

from controllers.arm.dynamics.carried import torques_for
from controllers.arm.dynamics.limits import halfway
from controllers.arm.dynamics.settings import Payload
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from rig.config.settings import adapter
from rig.config.yaml_loader import read_plain
from rig.report.data import RunData
from rig.report.figure import draw_line, finish_time_axis
from rig.report.style import BLUE, GREY, PAGE, VERMILION, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from controllers.arm.dynamics.chain import ArmTorques


def draw_torques(run: RunData) -> "Figure | None":
    """Draw what the commanded motion asks of the drives, what they gave, and their limits."""
    rates = [f"command.velocity_{name}" for name in AXIS_NAMES]
    joints = [f"command.position_{name}" for name in AXIS_NAMES]
    if len(run.time) < 2 or not run.has(*rates, *joints, "plan.index_wrist"):
        return None
    needs = _torques_of(run)
    if needs is None:
        return None
    t = run.time
    q, v = (np.column_stack([run.trace(name) for name in names]) for names in (joints, rates))
    foreseen = needs.of(*halfway(q, v, float(np.median(np.diff(t)))))
    middle = 0.5 * (t[1:] + t[:-1])
    figure = new_figure(PAGE, 92.0)
    panels = figure.subplots(2, 3, sharex=True)
    for axes, name, of, limit in zip(
        panels.flat, AXIS_NAMES, foreseen.T, needs.limits.tolist(), strict=True
    ):
        if run.has(f"truth.torque_{name}"):
            draw_line(axes, t, run.trace(f"truth.torque_{name}"), GREY, "drive", lw=1.2)
        draw_line(axes, middle, of, BLUE, "foreseen", lw=0.9)
        for bound, label in ((-limit, "_"), (limit, "limit")):
            axes.axhline(bound, color=VERMILION, lw=0.8, ls=(0, (5, 2)), label=label)
        finish_time_axis(axes, t, f"{name} (N m)", "")
        axes.set_ylim(-1.2 * limit, 1.2 * limit)
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    handles = panels[0, 0].get_legend_handles_labels()[0]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles), frameon=False)
    return figure


def _torques_of(run: RunData) -> "ArmTorques | None":
    """Return what is known of the arm's drives and its payload; None if that is nothing."""
    geometry = adapter(ArmGeometry).validate_python(run.settings["geometry"])
    if not isinstance(geometry, ArmGeometry) or geometry.dynamics is None:
        return None
    experiment = read_plain(run.folder.path / "experiment.yaml")
    reference = experiment.get("reference") if isinstance(experiment, dict) else None
    carried = reference.get("payload", {}) if isinstance(reference, dict) else {}
    payload = adapter(Payload).validate_python(carried)
    return torques_for(geometry, payload) if isinstance(payload, Payload) else None
