"""Leaks of the chambers: by soap water, and by the gauge where a valve locks the air in."""

from math import log
from typing import Final, NamedTuple

from rig.commissioning.forms import reading
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import (
    AcceptanceStep,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.config.quantities import parse_reading
from rig.hal import AiryPlant, Vector
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
        "Every chamber gets 5 to 17 kPa above the least setpoint; you brush tubes, fittings and "
        "rods with soap water for up to a minute; chambers with a lock valve are then shut "
        "for 5 s, and you read their gauges."
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
        for its in locked:
            start, end = (
                parse_reading(site.operator.answer(task), "Pa") for task in (its.before, its.after)
            )
            rate = log(max(start, 1.0) / max(end, 1.0)) / its.waited
            value = MeasuredValue(f"{its.channel}: locked in, it loses", rate, "1/s", high=_RATE)
            measured.append(require_within(its.channel, value, "leak: it does not keep its air"))
        said = "" if measured else "no chamber has a lock valve: soap water alone tells"
        return StepResult(tuple(measured), {"bubbling": bubbling}, said)


class _Locked(NamedTuple):
    """A chamber that was locked in: the tasks to read its gauge, and the time between them, s."""

    channel: str
    before: Task
    after: Task
    waited: float


def _lock(site: Site, chambers: Chambers, setpoints: Vector) -> list[_Locked]:
    """Lock the air of every chamber that has a valve in, and have its gauge read twice."""
    regulators, bench, rig = chambers.regulators, chambers.bench, chambers.rig
    shut = regulators.lockable
    if not any(shut):
        return []
    names = [name for name, has_valve in zip(regulators.channels, shut, strict=True) if has_valve]
    regulators.lock(shut)
    chambers.set(setpoints, 0.5)
    tasks, times = [], []
    for when in ("before", "after"):
        times.append(bench.now)
        tasks.append([_gauge(name, when) for name in names])
        for task in tasks[-1]:
            site.operator.do(task, site.world_of(rig))
        bench.run(site.glance(rig))
        bench.run(_SHUT if when == "before" else 0.0)
    regulators.lock((False,) * len(shut))
    waited = times[1] - times[0]
    return [
        _Locked(name, before, after, waited)
        for name, before, after in zip(names, tasks[0], tasks[1], strict=True)
    ]


def _gauge(channel: str, when: str) -> Task:
    return Task(
        f"leak.{channel}.{when}",
        f"What does the gauge of {channel} show, {when} the wait? e.g. 12.3 kPa",
        lambda world: f"{true_pressures(world, [channel])[channel] / 1e3:.3f} kPa",
        reading("Pa", "12.3 kPa"),
    )


def _bubbling(world: BreakableWorld) -> str:
    plant = world.plant
    return ", ".join(plant.bubbling()) if isinstance(plant, AiryPlant) else "none"
