"""What becomes of pressurised chambers when the rig is stopped, left alone, or cut off."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rig.commissioning.forms import one_of
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.steps.reactions import Energy, Reacting, put_back
from rig.hal import Vector
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.commissioning.chambers import (
    LEVELS_OF_LOOPS,
    Chambers,
    energised,
    true_pressures,
)

_KEPT = "the chambers keep their pressure"


class ChamberEnergy(Energy):
    """The pressure in the chambers."""

    def __init__(self, chambers: Chambers) -> None:
        self._chambers = chambers
        self.bench = chambers.bench
        self._rises: Vector = ()

    @property
    def holders(self) -> Sequence[str]:
        """See `Energy.holders`."""
        return (self._chambers.regulators.name,)

    def bring_up(self) -> None:
        """See `Energy.bring_up`."""
        self._rises = self._chambers.bring_up()

    def has_gone(self) -> bool:
        """See `Energy.has_gone`."""
        return self._chambers.have_fallen(0.5, self._rises)()

    def asked_to_have_grown(self) -> bool:
        """See `Energy.asked_to_have_grown`."""
        return self._chambers.above(self._chambers.regulators.inspect(), self._rises)

    def asked_to_have_gone(self) -> str:
        """See `Energy.asked_to_have_gone`."""
        chambers = self._chambers
        gone = chambers.below(chambers.regulators.inspect(), 0.5, self._rises)
        return "" if gone else f"{chambers.regulators.name} keeps its pressure"

    def without_cable(self, site: Site, bus: str) -> Callable[[], str]:
        """See `Energy.without_cable`."""
        self.bench.listen(site.profile.loop.safe_within, lambda: False)
        at_zero = _at_zero(self._chambers.regulators.channels)
        site.operator.do(at_zero, site.world_of(self.rig))

        def say() -> str:
            is_zero = site.operator.answer(at_zero).strip().lower() in ("y", "yes")
            site.operator.answer(put_back(site, self.rig, bus))
            return "" if is_zero else f"{_KEPT} without the cable"

        return say


@contextmanager
def _energised(site: Site) -> Iterator[Energy]:
    with energised(site) as chambers:
        yield ChamberEnergy(chambers)


REACTING = Reacting(
    _energised,
    "Every chamber gets 5 to 17 kPa above the least setpoint",
    "the chambers are vented",
    _KEPT,
)
"""Cylinders' part of the steps that take energy away."""


def _at_zero(channels: tuple[str, ...]) -> Task:
    def look(world: BreakableWorld) -> str:
        world.advance(world.time)
        vented = max(true_pressures(world, channels).values()) < 0.5 * LEVELS_OF_LOOPS[0]
        return "yes" if vented else "no"

    text = "Do the gauges of all chambers show zero (yes, no)?"
    return Task("cable.gauges", text, look, one_of("yes", "no"))
