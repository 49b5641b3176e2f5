"""Chambers that are energised for one step, at the lowest pressures that tell anything."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, NamedTuple

from rig.assembly import REGISTRY, Rig
from rig.commissioning.bench import StepBench
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import Defect
from rig.hal import DevicePicker, LinearEncoder, PressureRegulator, Vector
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.settings import PneumaticSettings
from rig.mechanisms.pneumatic.valves.regulating import as_regulators, regulating_kind

LOWEST: Final = 8e3
"""Setpoint of the first steps, Pa gauge: less than 20 kPa even from a regulator whose scale is
wrong by a factor of two."""
LEVELS: Final = (LOWEST, 11e3, 14e3, 17e3)
"""Setpoints until monitors answer, Pa gauge. A regulator holds some kPa at least and has
hysteresis, so the first may not move it; one whose scale is twice too large answers there."""
HIGHER: Final = 14e3
"""What all chambers are asked for in a step from the lowest, Pa gauge."""
SEEN: Final = 2e3
"""Least rise of a monitor that is one, Pa: well above noise and hysteresis."""
_MUCH: Final = 0.6
"""A monitor that rose by more than this share of its setpoint need not be given more."""
SETTLE: Final = 1.0
"""Until a setpoint is reached, s."""
_AVERAGED: Final = 0.2
"""Over so long a monitor is averaged, s."""


class Climbed(NamedTuple):
    """The setpoints at which every monitor answered, or the highest; and their rises, Pa."""

    setpoints: Vector
    rises: Vector


class Chambers:
    """The chambers of an energised rig, and their monitors before anything was set.

    What they were last asked for they are asked for in every cycle, until the rig is made safe.

    Parameters
    ----------
    bench : StepBench
        The rig's cycle.
    regulators : PressureRegulator
        Armed.

    Attributes
    ----------
    zeros : tuple of float
        Means of the monitors, vented, Pa gauge.
    """

    def __init__(self, bench: StepBench, regulators: PressureRegulator) -> None:
        self.bench = bench
        self.regulators = regulators
        self.zeros: Vector = ()
        self._asked: Vector = (regulators.pressure_range[0],) * len(regulators.channels)
        bench.each_cycle = lambda: regulators.set_pressure(self._asked)

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.bench.rig

    def ask(self, pressures: Sequence[float]) -> None:
        """Give setpoints from the next cycle on, Pa gauge."""
        self._asked = tuple(pressures)

    def set(self, pressures: Sequence[float], duration: float = SETTLE) -> None:
        """Give setpoints, Pa gauge, for so long, s."""
        self.ask(pressures)
        self.bench.run(duration)

    def set_all(self, pressure: float, duration: float = SETTLE) -> None:
        """Give every chamber the same setpoint, so that forces balance; see `set`."""
        self.set((pressure,) * len(self.regulators.channels), duration)

    def climb(self) -> Climbed:
        """Raise all setpoints until every monitor answers, but none that shows as much already.

        A setpoint whose scale is too large stays so where it was first seen.
        """
        setpoints, rises = [0.0] * len(self.zeros), (0.0,) * len(self.zeros)
        for level in LEVELS:
            setpoints = [
                before if rise > _MUCH * before > 0.0 else level
                for before, rise in zip(setpoints, rises, strict=True)
            ]
            self.set(setpoints)
            rises = self.rises()
            if min(rises) >= SEEN:
                break
        return Climbed(tuple(setpoints), rises)

    def bring_up(self) -> Vector:
        """Climb, and return by how much the monitors rose, Pa.

        Raises
        ------
        Defect
            One does not answer.
        """
        rises = self.climb().rises
        if min(rises) < SEEN:
            channel = self.regulators.channels[rises.index(min(rises))]
            raise Defect(
                channel,
                f"its monitor shows nothing of {LEVELS[-1] / 1e3:g} kPa: its regulator is stuck, "
                "or the scale of its setpoint is much too small",
            )
        return rises

    def rises(self) -> Vector:
        """Return by how much each monitor shows more than vented, Pa; averaged."""
        return tuple(p - zero for p, zero in zip(self.means(), self.zeros, strict=True))

    def means(self) -> Vector:
        """Return the means of the monitors, Pa gauge."""
        rows: list[Vector] = []

        def look() -> bool:
            rows.append(self.regulators.pressure().value)
            return False

        self.bench.run(_AVERAGED, look)
        return tuple(sum(column) / len(rows) for column in zip(*rows, strict=True))

    def have_fallen(self, share: float, tops: Vector) -> Callable[[], bool]:
        """Return what tells whether every monitor has lost all but a share of its rise."""

        def fallen() -> bool:
            return self.below(self.regulators.pressure().value, share, tops)

        return fallen

    def below(self, pressures: Vector, share: float, tops: Vector) -> bool:
        """Return whether pressures are all but a share of their rises down again."""
        found = zip(pressures, self.zeros, tops, strict=True)
        return all(p - zero < max(share * top, 0.25 * SEEN) for p, zero, top in found)


@contextmanager
def energised(site: Site, *, supply: bool = True) -> Iterator[Chambers]:
    """Connect and arm a rig for a step; its chambers are vented.

    Parameters
    ----------
    site : Site
        The rig's.
    supply : bool
        Open the supply; else it has never been open since the rig was connected.
    """
    rig = site.make_rig(site.profile)
    with rig:
        regulators = regulators_of(rig)
        rig.arm()
        if not supply:
            regulators.shut_supply(True)
        chambers = Chambers(StepBench(rig), regulators)
        chambers.set_all(regulators.pressure_range[0], 0.3)
        chambers.zeros = chambers.means()
        yield chambers


def regulators_of(rig: Rig) -> PressureRegulator:
    """Return the regulators of a rig's mechanism, also those that are made of valves."""
    settings = rig.profile.mechanism_settings
    assert isinstance(settings, PneumaticSettings)
    pick = DevicePicker("commissioning", rig.devices)
    feed = pick("regulators", settings.regulators, regulating_kind(settings))
    wired = REGISTRY.load("mechanism", rig.profile.mechanism).wiring(settings)
    encoders = {channel: pick("encoder", name, LinearEncoder) for name, channel in wired.items()}
    rods = [encoders[channel] for channel in feed.channels]
    return as_regulators(feed, rods, settings, rig.profile.loop.period)


def true_pressures(world: BreakableWorld, channels: Sequence[str]) -> dict[str, float]:
    """Return what gauges on the chambers would show in a simulated world, Pa gauge."""
    names = [name for name, _ in world.plant.truth_columns]
    truth = world.plant.truth()
    return {channel: truth[names.index(f"pressure_{channel}")] for channel in channels}


def gauges(key: str, text: str, channels: Sequence[str]) -> Task:
    """Return the task to read the gauge of the chamber that shows most: ``agonist 8.1 kPa``."""

    def look(world: BreakableWorld) -> str:
        shown = true_pressures(world, channels)
        most = max(shown, key=lambda channel: shown[channel])
        return f"{most} {shown[most] / 1e3:.2f} kPa"

    return Task(key, text, look)
