"""Accelerations of an arm's joints and torques of its drives, against their limits."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

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
    from numpy.typing import NDArray

    from controllers.arm.dynamics.chain import ArmTorques

    Array = NDArray[np.float64]

_ROOM = 1.2
"""Of a panel beyond the limits."""
_AT_ONCE = 1 << 15
"""Cycles whose torques are computed together: their memory does not grow with the run."""
_MOST = 3.0
"""What is beyond so many limits does not set the scale."""


class _Commanded(NamedTuple):
    """Joints, rates and accelerations halfway between the cycles, and when that is, s."""

    t: "Array"
    q: "Array"
    rates: "Array"
    accelerations: "Array"


def draw_accelerations(run: RunData) -> "Figure | None":
    """Draw the commanded accelerations of the joints with their limits."""
    its = _commanded(run)
    if its is None:
        return None
    limits = run.settings["geometry"]["acceleration_limits"]
    return _panels(run, its, its.accelerations, limits, ("commanded", "rad/s²", ""))


def draw_torques(run: RunData) -> "Figure | None":
    """Draw what the commanded motion asks of the drives, what they gave, and their limits."""
    its = _commanded(run)
    needs = None if its is None else _torques_of(run)
    if its is None or needs is None:
        return None
    foreseen = np.empty_like(its.q)
    for start in range(0, len(foreseen), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        foreseen[part] = needs.of(its.q[part], its.rates[part], its.accelerations[part])
    limits = needs.limits.tolist()
    return _panels(run, its, foreseen, limits, ("foreseen", "N m", "truth.torque"))


def _panels(
    run: RunData,
    its: _Commanded,
    values: "Array",
    limits: Sequence[float],
    said: tuple[str, str, str],
) -> "Figure":
    """Draw a panel for each joint; `said` is a label, a unit and where what was is recorded."""
    label, unit, recorded = said
    figure = new_figure(PAGE, 92.0)
    panels = figure.subplots(2, 3, sharex=True)
    for axes, name, of, limit in zip(panels.flat, AXIS_NAMES, values.T, limits, strict=True):
        if run.has(f"{recorded}_{name}"):
            draw_line(axes, run.time, run.trace(f"{recorded}_{name}"), GREY, "drive", lw=1.2)
        draw_line(axes, its.t, of, BLUE, label, lw=0.9)
        for bound, word in ((-limit, "_"), (limit, "limit")):
            axes.axhline(bound, color=VERMILION, lw=0.8, ls=(0, (5, 2)), label=word)
        finish_time_axis(axes, run.time, f"{name} ({unit})", "")
        most = min(max(_ROOM, 1.1 * float(np.abs(of).max()) / limit), _MOST) * limit
        axes.set_ylim(-most, most)
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    handles = panels[0, 0].get_legend_handles_labels()[0]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles), frameon=False)
    return figure


def _commanded(run: RunData) -> _Commanded | None:
    """Return the motion that was commanded; None of a run of something else."""
    rates = [f"command.velocity_{name}" for name in AXIS_NAMES]
    joints = [f"command.position_{name}" for name in AXIS_NAMES]
    if len(run.time) < 2 or not run.has(*rates, *joints, "plan.index_wrist"):
        return None
    t = run.time
    q, v = (np.column_stack([run.trace(name) for name in names]) for names in (joints, rates))
    return _Commanded(0.5 * (t[1:] + t[:-1]), *halfway(q, v, float(np.median(np.diff(t)))))


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
