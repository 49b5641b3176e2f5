"""Where the axes stand, without energy: limits are where the profile says if this is right."""

from functools import partial
from math import degrees, radians
from typing import Final

from rig.commissioning.forms import reading
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult, require_within
from rig.hal import DeviceFault
from rig.hal.world import BreakableWorld
from rig.mechanisms.servo.commissioning.axes import angle_of, axis_names, listened, true_angles

_OFF: Final = radians(10.0)
"""By how much a protractor and an encoder whose zero is not calibrated may differ, rad."""


class AxesInRange(AcceptanceStep):
    """Each joint's angle is read by a protractor, and compared with its drive's."""

    name = "ranges"
    does = "What could fall is hung up; without energy you read each joint's angle."
    expects = "Its drive shows the same within 10 degrees, inside the range of the profile."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        names = axis_names(site.profile)
        tasks = {name: _read(name) for name in names}
        with listened(site) as axes:
            try:
                axes.bench.run(0.05)
            except DeviceFault as fault:
                what = (
                    "it does not rest without energy: its brake does not hold, or it is not hung up"
                )
                raise Defect(fault.device, f"{what}; {fault}") from fault
            shown = axes.shown()
            for task in tasks.values():
                site.operator.do(task, site.world_of(axes.rig))
        stands = {name: angle_of(site.operator.answer(task)) for name, task in tasks.items()}
        bounds = {
            name: its
            for entry in site.profile.devices.values()
            for name, its in entry.settings.axis_bounds().items()
        }
        measured = []
        for name in names:
            _find_exchanged(name, shown, stands)
            off = MeasuredValue(
                f"{name}: shown, less read", shown[name] - stands[name], "rad", -_OFF, _OFF
            )
            defect = "its zero is wrong, or its direction or gear"
            measured.append(require_within(name, off, defect))
            low, high, _ = bounds[name]
            angle = MeasuredValue(f"{name}: stands at", stands[name], "rad", low, high)
            defect = "the joint stands outside its range; move it back before it is energised"
            measured.append(require_within(name, angle, defect))
        return StepResult(tuple(measured))


def _find_exchanged(name: str, shown: dict[str, float], stands: dict[str, float]) -> None:
    """Raise if a drive shows another joint's angle, and that one's drive this one's."""
    if abs(shown[name] - stands[name]) <= _OFF:
        return
    for other, its in shown.items():
        one, two = shown[name] - stands[other], its - stands[name]
        if other != name and max(abs(one), abs(two)) <= _OFF:
            raise Defect(
                name,
                f"drives exchanged: it shows where {other} stands, {degrees(shown[name]):.1f} deg, "
                f"and {other} shows where it stands",
            )


def _read(name: str) -> Task:
    def look(world: BreakableWorld, name: str) -> str:
        return f"{degrees(true_angles(world, [name])[name]):.2f} deg"

    return Task(
        f"ranges.{name}",
        f"At what angle does {name} stand? e.g. 12.5 deg",
        partial(look, name=name),
        reading("rad", "12.5 deg"),
    )
