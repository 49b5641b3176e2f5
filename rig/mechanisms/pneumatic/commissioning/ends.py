"""Each rod from end to end, by hand and without energy: the way that the profile wants is there."""

from collections.abc import Callable
from functools import partial
from typing import Final

from rig.assembly import REGISTRY
from rig.commissioning.bench import StepBench
from rig.commissioning.forms import reading
from rig.commissioning.hands import EndToEnd
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult, require_within
from rig.commissioning.steps.ends import Ends, watch_ends
from rig.config.quantities import parse_reading
from rig.hal import AiryPlant, DeviceFault, DevicePicker, LinearEncoder
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.settings import PneumaticSettings

_HAND: Final = 0.2
"""How fast a simulated hand moves a rod, m/s, whatever the cycle: wires pull it back meanwhile."""
_HARDER: Final = 5.0
"""Times harder it pulls at last where a wire pulls back at what sticks."""
_OFF: Final = 2e-3
"""How far off the zero of an encoder may be that nobody has calibrated, m."""
_SCALE: Final = (0.97, 1.03)
"""What an encoder may show over what a gauge does from end to end."""


class RodsToTheirEnds(AcceptanceStep):
    """Each rod is pulled out and pushed in as far as it goes.

    Parameters
    ----------
    way : callable
        ``way(settings)`` returns how far a rod goes from home where the profile permits most, m.
    """

    name = "ends"
    does = (
        "Nothing is energised; you pull each rod out as far as it goes, push it in as far as it "
        "goes, put it back, and gauge its way from end to end."
    )
    expects = "Its encoder follows from end to end, and the way that the profile permits is there."

    def __init__(self, way: Callable[[PneumaticSettings], float]) -> None:
        self._way = way

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        settings = site.profile.mechanism_settings
        needed = self._way(settings)
        measured: list[MeasuredValue] = []
        view = REGISTRY.load("mechanism", site.profile.mechanism)
        for name, channel in view.wiring(settings).items():
            ends, gauged = _gauge(site, name, channel, 2.0 * needed)
            measured.append(
                require_within(
                    name,
                    MeasuredValue(
                        f"{name} over the gauge, end to end", (ends.high - ends.low) / gauged, "1",
                        *_SCALE,
                    ),
                    "wrong scale of the encoder, or it does not see the whole way",
                )
            )  # fmt: skip
            for what, end, low, high in (
                ("innermost", ends.low, -_OFF, settings.home - needed + _OFF),
                ("outermost", ends.high, settings.home + needed - _OFF, settings.stroke + _OFF),
            ):
                shown = MeasuredValue(f"{name}: {what}", end, "m", low, high)
                measured.append(require_within(name, shown, f"range: {_why(shown, channel)}"))
        return StepResult(tuple(measured))


def _gauge(site: Site, name: str, channel: str, span: float) -> tuple[Ends, float]:
    """Return the ends of what an encoder shows of a rod, and the way between them by a gauge, m.

    Raises
    ------
    Defect
        The encoder is not well on the way.
    """
    nudge = _HAND * site.profile.loop.period
    hand = EndToEnd(channel, f"extension_{channel}", nudge, _HARDER)
    task = Task(
        f"ends.{channel}",
        f"Pull the rod of {channel} out as far as it goes, push it in as far as it goes, and put "
        "all back where it was; how far is it from end to end by the gauge? e.g. 60 mm",
        lambda world: f"{hand.nudge(world) * 1e3:.3f} mm",
        reading("m", "60 mm"),
    )
    rig = site.make_rig(site.profile)
    with rig:
        rig.arm(torque=False)
        bench = StepBench(rig)
        bench.run(0.05)
        encoder = DevicePicker("commissioning", rig.devices)("encoder", name, LinearEncoder)
        try:
            ends = watch_ends(site, bench, task, hand, partial(_extension, encoder), span)
        except DeviceFault as fault:
            raise Defect(
                name, f"range: its reading is not good from end to end of {channel}; {fault}"
            ) from fault
        world = site.world_of(rig)
        if world is not None:  # what wires have dragged along, too
            site.operator.do(_PUT_BACK, world)
    return ends, parse_reading(site.operator.answer(task), "m")


def _put_back(world: BreakableWorld) -> str:
    if isinstance(world.plant, AiryPlant):
        world.plant.put_back()
    return "done"


_PUT_BACK: Final = Task("ends.back", "Put all back where it was.", _put_back)


def _extension(encoder: LinearEncoder) -> float:
    return encoder.position().value[0]


def _why(shown: MeasuredValue, channel: str) -> str:
    """Return what is wrong with an end of a rod."""
    is_inner = "innermost" in shown.name
    if (shown.value > shown.high) if is_inner else (shown.value < shown.low):
        return f"the rod of {channel} does not go as far as the profile permits"
    return f"the rod of {channel} goes further than the cylinder's stroke: stroke or zero is wrong"
