"""Each joint from end to end, by hand and without energy: the profile's range is really there."""

from functools import partial
from math import degrees, radians
from typing import Final

from rig.commissioning.forms import one_of
from rig.commissioning.hands import EndToEnd
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult, require_within
from rig.commissioning.steps.ends import Ends, watch_ends
from rig.hal import DeviceFault
from rig.hal.driver import AxisBounds
from rig.hal.world import BreakableWorld
from rig.mechanisms.servo.commissioning.axes import Axes, axis_names, listened

_HAND: Final = 0.8
"""Share of its greatest speed with which a simulated hand turns a joint."""
_OFF: Final = radians(10.0)
"""By how much a drive may be off whose zero is not calibrated, rad."""
_HELD: Final = "held"
"""The answer for a joint that no hand can turn."""


class AxesToTheirEnds(AcceptanceStep):
    """Each joint is turned by hand over its whole range."""

    name = "ends"
    does = (
        "What could fall is hung up; without energy you turn each joint by hand over the profile's "
        "range and back, its brake released; or you answer that gear or brake hold it."
    )
    expects = "Each joint goes as far as the profile permits, and its drive shows it on the way."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        bounds = {
            name: its
            for entry in site.profile.devices.values()
            for name, its in entry.settings.axis_bounds().items()
        }
        measured: list[MeasuredValue] = []
        held: list[str] = []
        names = axis_names(site.profile)
        tasks: dict[str, Task] = {}
        found: dict[str, Ends] = {}
        with listened(site, site.profile) as axes:
            axes.bench.run(0.05)
            for name in names:
                tasks[name], found[name] = _turn(site, axes, name, bounds[name])
        for name in names:
            low, high, _ = bounds[name]
            if site.operator.answer(tasks[name]).strip().lower() == _HELD:
                held.append(name)
                continue
            for what, end, least, most in (
                ("lower end", found[name].low, low - _OFF, low + _OFF),
                ("upper end", found[name].high, high - _OFF, high + _OFF),
            ):
                shown = MeasuredValue(f"{name}: {what}", end, "rad", least, most)
                defect = "range: it does not go from end to end of the profile's range"
                measured.append(require_within(name, shown, defect))
        said = f"not turned, as gear or brake hold them: {', '.join(held)}" if held else ""
        return StepResult(tuple(measured), {"held": held}, said)


def _turn(site: Site, axes: Axes, name: str, bounds: AxisBounds) -> tuple[Task, Ends]:
    nudge = _HAND * bounds.speed * site.profile.loop.period
    hand = EndToEnd(name, name, nudge, low=bounds.low, high=bounds.high)
    task = Task(
        f"ends.{name}",
        f"Turn {name} by hand to both ends of its range and back, slower than "
        f"{degrees(bounds.speed):.0f} deg/s; is it done (yes, or {_HELD})?",
        partial(_nudge, hand),
        one_of("yes", _HELD),
    )
    try:
        span = bounds.high - bounds.low
        return task, watch_ends(site, axes.bench, task, hand, partial(_shown, axes, name), span)
    except DeviceFault as fault:
        raise Defect(name, f"range: its drive is not well on the way; {fault}") from fault


def _nudge(hand: EndToEnd, world: BreakableWorld) -> str:
    hand.nudge(world)
    return "yes"


def _shown(axes: Axes, name: str) -> float:
    """Return what a joint's drive shows in this cycle, rad."""
    for servo in axes.servos:
        if name in servo.axis_names:
            return servo.positions().value[servo.axis_names.index(name)]
    raise KeyError(name)
