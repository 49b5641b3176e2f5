"""Leaks of the chambers: by soap water, and by the gauge where a valve locks the air in."""

from math import log
from typing import Final

from rig.calibration.instruments import parse_reading
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import (
    AcceptanceStep,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.hal import AiryPlant
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.commissioning.chambers import Chambers, energised, true_pressures

_SHUT: Final = 5.0
"""For so long air is locked in, s."""
_RATE: Final = 0.1
"""Share of its gauge pressure that a chamber may lose in a second."""


class LeaksOfChambers(AcceptanceStep):
    """Everything that holds air is brushed with soap water; what can be locked in is."""

    name = "leak"
    does = (
        "Every chamber gets 8 to 14 kPa; you brush tubes, fittings and rods with soap water for up "
        "to a minute; chambers with a lock valve are then shut for 5 s, and you read their gauges."
    )
    expects = "No fitting bubbles, and a locked chamber keeps its air."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        soap = Task(
            "leak.soap",
            "Brush tubes, fittings and rods with soap water; which chamber's bubble (names, or "
            "none)?",
            _bubbling,
        )
        with energised(site) as chambers:
            setpoints, _ = chambers.climb()
            site.operator.do(soap, site.world_of(chambers.rig))
            chambers.set(setpoints, site.patience(chambers.rig))
            locked = _lock(site, chambers, setpoints)
        bubbling = site.operator.answer(soap).strip()
        require(
            bubbling.lower() in ("", "none", "no"), bubbling,
            "leak: soap water bubbles there; tighten the fitting, or renew tube or seal",
        )  # fmt: skip
        measured = []
        for channel, before, after in locked:
            start, end = (parse_reading(site.operator.answer(its), "Pa") for its in (before, after))
            rate = log(max(start, 1.0) / max(end, 1.0)) / _SHUT
            value = MeasuredValue(f"{channel}: locked in, it loses", rate, "1/s", high=_RATE)
            measured.append(require_within(channel, value, "leak: it does not keep its air"))
        said = "" if measured else "no chamber has a lock valve: soap water alone tells"
        return StepResult(tuple(measured), {"bubbling": bubbling}, said)


def _lock(
    site: Site, chambers: Chambers, setpoints: tuple[float, ...]
) -> list[tuple[str, Task, Task]]:
    """Lock the air of every chamber that has a valve in; return the tasks to read its gauge."""
    regulators = chambers.regulators
    shut = regulators.lockable or (False,) * len(setpoints)
    if not any(shut):
        return []
    found = []
    world = site.world_of(chambers.rig)
    regulators.lock(shut)
    chambers.set(setpoints, 0.5)
    for channel, has_valve in zip(regulators.channels, shut, strict=True):
        if has_valve:
            found.append((channel, _gauge(channel, "before"), _gauge(channel, "after")))
    for _, before, _ in found:
        site.operator.do(before, world)
    chambers.set(setpoints, _SHUT)
    for _, _, after in found:
        site.operator.do(after, world)
    regulators.lock((False,) * len(shut))
    return found


def _gauge(channel: str, when: str) -> Task:
    return Task(
        f"leak.{channel}.{when}",
        f"What does the gauge of {channel} show, {when} the wait? e.g. 12.3 kPa",
        lambda world: f"{true_pressures(world, [channel])[channel] / 1e3:.3f} kPa",
    )


def _bubbling(world: BreakableWorld) -> str:
    plant = world.plant
    return ", ".join(plant.bubbling()) if isinstance(plant, AiryPlant) else "none"
