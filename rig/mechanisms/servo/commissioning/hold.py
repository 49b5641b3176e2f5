"""The first energy: every axis is held where it stands."""

from math import radians
from typing import Final

from rig.commissioning.forms import one_of
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import (
    AcceptanceStep,
    Defect,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.hal import DeviceFault
from rig.hal.world import BreakableWorld
from rig.mechanisms.servo.commissioning.axes import (
    ENABLED,
    MotorWatch,
    energised,
    listened,
)

_SAG: Final = radians(0.6)
"""How far an axis may go when it is energised, rad: it sags until its drive bears it."""


class HoldStill(AcceptanceStep):
    """All drives are energised, and nobody asks them to move."""

    name = "hold"
    does = "What could fall is hung up; every drive holds its joint where it is, slow and weak."
    expects = "Every drive enables itself and no joint moves by more than it sags."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        with listened(site) as axes:
            axes.bench.run(0.05)
            free = axes.shown()
        with energised(site) as axes:
            try:
                axes.bench.run(ENABLED, MotorWatch(axes).look)
            except DeviceFault as fault:
                said = str(fault).partition(": ")[2]
                what = (
                    "or, if its drive has torque, it does not hold: its encoder is mirrored or "
                    "frozen, or its scale is wrong, or what it bears needs more torque than it is "
                    "permitted"
                )
                raise Defect(fault.device, f"{said}; {what}") from fault
            held = axes.shown()
            text = "Do all joints stand still (yes, no)?"
            holding = Task("hold.still", text, _still, one_of("yes", "no"))
            site.operator.do(holding, site.world_of(axes.rig))
            axes.bench.run(site.glance(axes.rig))
        answer = site.operator.answer(holding).strip().lower()
        require(answer in ("y", "yes"), "drives", "a joint moves although it is to be held")
        measured = []
        for name, angle in held.items():
            moved = MeasuredValue(f"{name} moved by", abs(angle - free[name]), "rad", high=_SAG)
            measured.append(require_within(name, moved, "it is not held where it stands"))
        return StepResult(tuple(measured))


def _still(world: BreakableWorld) -> str:
    plant = world.plant
    speeds = [
        abs(value)
        for (name, unit), value in zip(plant.truth_columns, plant.truth(), strict=True)
        if unit == "rad/s" and name.endswith("_velocity")
    ]
    return "yes" if max(speeds) < radians(1.0) else "no"
