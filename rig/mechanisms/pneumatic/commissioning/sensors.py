"""Direction and scale of each rod's encoder, by hand and without energy."""

from functools import partial
from typing import Final

from rig.assembly import REGISTRY, Rig
from rig.commissioning.bench import StepBench
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
from rig.hal import ConfigurationError, DevicePicker, HandledPlant, LinearEncoder
from rig.hal.world import BreakableWorld

_PULL: Final = 0.5e-3
"""How far a rod is pulled, m: any encoder sees it, and nobody is hurt by it."""
_STILL: Final = 0.2
"""Share of the pull that a rod may move which was not pulled."""
_SCALE: Final = (0.8, 1.25)
"""What an encoder may show over what a gauge does: a hand and a feeler gauge are no better."""


class EncodersByHand(AcceptanceStep):
    """Each rod is pulled out a little, one at a time."""

    name = "sensors"
    does = "Nothing is energised; you pull each rod out by half a millimetre and gauge how far."
    expects = "Its own encoder shows it, outwards and as far as the gauge; no other one moves."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        view = REGISTRY.load("mechanism", site.profile.mechanism)
        wired = view.wiring(site.profile.mechanism_settings)
        measured = []
        for name, channel in wired.items():
            task = _pull(channel)
            before, after = self._watch(site, task, tuple(wired))
            moved = {other: after[other] - before[other] for other in wired}
            by = parse_reading(site.operator.answer(task), "m")
            measured.append(_judge(name, channel, by, moved))
        return StepResult(tuple(measured))

    def _watch(
        self, site: Site, task: Task, names: tuple[str, ...]
    ) -> tuple[dict[str, float], dict[str, float]]:
        """Return what encoders show before and after something is done by hand, m."""
        rig = site.make_rig(site.profile)
        with rig:
            rig.arm(torque=False)
            bench = StepBench(rig)
            bench.run(0.05)
            before = _positions(rig, names)
            site.operator.do(task, site.world_of(rig))
            if site.world_of(rig) is None:
                bench.run(site.patience(rig), partial(_has_settled, rig, names, before))
            else:
                bench.run(0.05)
            return before, _positions(rig, names)


def _positions(rig: Rig, names: tuple[str, ...]) -> dict[str, float]:
    pick = DevicePicker("commissioning", rig.devices)
    return {name: pick("encoder", name, LinearEncoder).position().value[0] for name in names}


def _has_settled(rig: Rig, names: tuple[str, ...], before: dict[str, float]) -> bool:
    """Return whether a rod has been pulled nearly as far as it is to be."""
    now = _positions(rig, names)
    return any(abs(now[name] - before[name]) > 0.9 * _PULL for name in names)


def _pull(channel: str) -> Task:
    def act(world: BreakableWorld) -> str:
        if not isinstance(world.plant, HandledPlant):
            raise ConfigurationError(f"the simulated plant has nobody who could pull {channel}")
        world.plant.pull(channel, _PULL)
        return f"{_PULL * 1e3:g} mm"

    text = f"Pull the rod of {channel} out by half a millimetre; how far is it by the gauge?"
    return Task(f"sensors.{channel}", text, act, reading("m", "0.5 mm"))


def _judge(name: str, channel: str, by: float, moved: dict[str, float]) -> MeasuredValue:
    """Return how far an encoder has shown a rod to move; raise for what is wrong with it."""
    others = [other for other in moved if other != name and abs(moved[other]) > _STILL * abs(by)]
    own = moved[name] / by
    if others:
        require(
            abs(own) > _STILL, name,
            f"the rod of {channel} was pulled, and {others[0]} moved: encoders swapped",
        )  # fmt: skip
    require(abs(own) > _STILL, name, f"the rod of {channel} was pulled, and it shows nothing")
    require(own > 0.0, name, "direction reversed: the rod was pulled out, and it shows inwards")
    shown = MeasuredValue(f"{name} over the gauge", own, "1", *_SCALE)
    return require_within(name, shown, "wrong scale of the encoder")
