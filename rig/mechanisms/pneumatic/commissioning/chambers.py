"""Chambers that are energised for one step, at the lowest pressures that tell anything."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, NamedTuple

from rig.assembly import Rig
from rig.commissioning.bench import StepBench
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.hal import DevicePicker, PressureRegulator, Vector
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.settings import PneumaticSettings

LOWEST: Final = 8e3
"""Setpoint of the first steps, Pa gauge: less than 20 kPa even from a regulator whose scale is
wrong by a factor of two."""
HIGHER: Final = 14e3
"""Setpoint where the scale was found right at `LOWEST`, Pa gauge."""
SEEN: Final = 2e3
"""Least rise of a monitor that is one, Pa: well above noise and hysteresis."""
SETTLE: Final = 1.0
"""Until a setpoint is reached, s."""
_AVERAGED: Final = 0.2
"""Over so long a monitor is averaged, s."""


class Chambers(NamedTuple):
    """The chambers of an energised rig, and their monitors before anything was set.

    Parameters
    ----------
    bench : StepBench
        The rig's cycle.
    regulators : PressureRegulator
        Armed.
    zeros : tuple of float
        Means of the monitors, vented, Pa gauge.
    """

    bench: StepBench
    regulators: PressureRegulator
    zeros: Vector = ()

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.bench.rig

    def cycle(self, pressure: float) -> None:
        """Give every chamber the same setpoint, Pa gauge, for one cycle."""
        self.regulators.set_pressure((pressure,) * len(self.regulators.channels))
        self.bench.cycle()

    def set(self, pressures: Sequence[float], duration: float = SETTLE) -> None:
        """Give setpoints, Pa gauge, for so long, s."""
        end = self.bench.now + duration
        while self.bench.now < end:
            self.regulators.set_pressure(tuple(pressures))
            self.bench.cycle()

    def set_all(self, pressure: float, duration: float = SETTLE) -> None:
        """Give every chamber the same setpoint, so that forces balance; see `set`."""
        self.set((pressure,) * len(self.regulators.channels), duration)

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
        yield chambers._replace(zeros=chambers.means())


def regulators_of(rig: Rig) -> PressureRegulator:
    """Return the regulators of a rig's mechanism."""
    settings = rig.profile.mechanism_settings
    assert isinstance(settings, PneumaticSettings)
    return DevicePicker("commissioning", rig.devices)(
        "regulators", settings.regulators, PressureRegulator
    )


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
