"""Chambers that are energised for one step, at the lowest pressures that tell anything."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import inf
from typing import Final, NamedTuple

from rig.assembly import REGISTRY, Rig
from rig.commissioning.bench import StepBench
from rig.commissioning.forms import whose_reading
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import Defect
from rig.hal import DevicePicker, LinearEncoder, PressureRegulator, Vector
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.alarms.bounds import STATIC
from rig.mechanisms.pneumatic.settings import PneumaticSettings
from rig.mechanisms.pneumatic.valves.regulating import (
    ValveRegulators,
    as_regulators,
    regulating_kind,
)

LOWEST: Final = 8e3
"""Setpoint of the first steps, Pa gauge: less than 20 kPa even from a regulator whose scale is
wrong by a factor of two."""
LEVELS: Final = (LOWEST, 11e3, 14e3, 17e3)
"""Setpoints until monitors answer, Pa gauge. A regulator holds some kPa at least and has
hysteresis, so the first may not move it; one whose scale is twice too large answers there."""
LEVELS_OF_LOOPS: Final = (5e3, *LEVELS)
"""The same of loops around valves, which have no hysteresis and overshoot, Pa gauge."""
SEEN: Final = 2e3
"""Least rise of a monitor that is one, Pa: well above noise and hysteresis."""
_MUCH: Final = 0.6
"""A monitor that rose by more than this share of its setpoint over the least that there is need not
be given more."""
SETTLE: Final = 1.0
"""Until a setpoint is reached, s."""
_AVERAGED: Final = 0.2
"""Over so long a monitor is averaged, s."""
_STEEPEST: Final = 100e3
"""Pressures of loops around valves rise so fast at most, Pa/s: a spool whose signal is too large
overshoots a step by more than the step itself."""

_BEYOND: Final = 9e3
"""So much more than asked for no chamber of a loop around a valve shows, Pa, unless the loop turns
the wrong valve, which it would open to the end; uncalibrated ones show up to 7 kPa more."""
_FAR_BEYOND: Final = 20e3
"""The same of a regulator, Pa: even one whose scale is wrong by a factor of two shows less."""
_VENTED: Final = 15e3
"""So much, either way, a monitor shows at most of a chamber that nothing is asked of, Pa: zeros of
monitors and of regulators as sold come to half of it."""


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
    lift : float
        So much higher every setpoint of the test is than `LOWEST` and the like say, Pa: the least
        that calibrated regulators can be told, from which on their signal begins to rise.
    levels : tuple of float
        Setpoints until monitors answer, Pa gauge.
    unsure : float
        So much the line of a calibrated regulator may be off at its low end, Pa: it is straight to
        a share of its range.
    """

    def __init__(self, bench: StepBench, regulators: PressureRegulator) -> None:
        self.bench = bench
        self.regulators = regulators
        self.zeros: Vector = ()
        self._asked: Vector = (regulators.pressure_range[0],) * len(regulators.channels)
        self._wanted = self._asked
        per_cycle = _STEEPEST * bench.rig.profile.loop.period
        self._is_loop = isinstance(regulators, ValveRegulators)
        self._beyond = _BEYOND if self._is_loop else _FAR_BEYOND
        self._rise = per_cycle if self._is_loop else inf
        least = regulators.pressure_range[0]
        self._least = max(least, 0.0)  # no chamber is below the air around it
        self.lift = self._least
        span = regulators.pressure_range[1] - least
        self.unsure = 0.0 if self._is_loop else 0.5 * STATIC * span
        levels = LEVELS_OF_LOOPS if self._is_loop else LEVELS
        self.levels: Vector = tuple(level + self.lift for level in levels)
        self._highest = self.levels[0]
        bench.each_cycle = self._give

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.bench.rig

    def ask(self, pressures: Sequence[float]) -> None:
        """Give setpoints in one step from the next cycle on, Pa gauge."""
        self._asked = self._wanted = tuple(pressures)
        self._highest = max(self.levels[0], *pressures)

    def set(self, pressures: Sequence[float], duration: float = SETTLE) -> None:
        """Give setpoints, Pa gauge, for so long, s; see `_STEEPEST`."""
        self._wanted = tuple(pressures)
        self._highest = max(self.levels[0], *pressures)
        self.bench.run(duration)

    def _give(self) -> None:
        """Give this cycle's setpoints."""
        self._asked = tuple(
            min(wanted, asked + self._rise)
            for wanted, asked in zip(self._wanted, self._asked, strict=True)
        )
        self._look_for_too_much()
        self.regulators.set_pressure(self._asked)

    def _look_for_too_much(self) -> None:
        """Raise if a chamber fills further than any was asked to, before its rod runs away."""
        shown = self.regulators.pressure().value
        if not self.zeros:  # nothing is asked for yet, and what was before may be on its way out
            self._require_vented(shown, self._beyond)
            return
        rises = tuple(p - zero for p, zero in zip(shown, self.zeros, strict=True))
        for channel, rise in zip(self.regulators.channels, rises, strict=True):
            more = rise - self._highest
            if more > self._beyond:
                raise Defect(
                    channel,
                    f"its pressure goes {more / 1e3:.1f} kPa beyond what was asked for: "
                    f"{self._why_too_much(rises)}",
                )

    def _why_too_much(self, rises: Vector) -> str:
        """Return what fills a chamber further than any was asked to."""
        scales = "wrong scale of its monitor, or wrong scale of its setpoint"
        if not self._is_loop:
            return f"its regulator is stuck open, wrong zero of its setpoint, {scales}"
        dead = [
            channel
            for channel, rise, asked in zip(
                self.regulators.channels, rises, self._asked, strict=True
            )
            if rise < SEEN and asked - self._least > SEEN
        ]
        # Its own loop opens such a valve to the end, and the rod that comes presses on this one.
        other = f"the monitor of {' or '.join(dead)} shows nothing of its chamber, " if dead else ""
        return (
            "its valve is stuck open or leaks, setpoint wires swapped, monitor wires swapped, "
            f"{other}{scales}"
        )

    def take_zeros(self) -> None:
        """Keep what the monitors show before anything is asked for.

        Raises
        ------
        Defect
            It is more, or less, than a chamber can have that nothing is asked of.
        """
        zeros = self.means()
        self._require_vented(zeros)
        self.zeros = zeros

    def _require_vented(self, pressures: Vector, more: float = 0.0) -> None:
        for channel, pressure in zip(self.regulators.channels, pressures, strict=True):
            if -_VENTED - more <= pressure <= self._least + self.unsure + _VENTED + more:
                continue
            part = "valve" if self._is_loop else "regulator"
            stuck = f", or its {part} is stuck open" if pressure > 0.0 else ""
            raise Defect(
                channel,
                f"its monitor shows {pressure / 1e3:.1f} kPa before anything is asked for: wrong "
                f"zero or scale of its monitor{stuck}",
            )

    def set_all(self, pressure: float, duration: float = SETTLE) -> None:
        """Give every chamber the same setpoint, so that forces balance; see `set`."""
        self.set((pressure,) * len(self.regulators.channels), duration)

    def alone(self, number: int, pressure: float) -> Vector:
        """Return the setpoints that fill one chamber alone, Pa gauge.

        The others get the least that there is: calibrated regulators may have none of 0 Pa.
        """
        least = self.regulators.pressure_range[0]
        return tuple(
            pressure if k == number else least for k in range(len(self.regulators.channels))
        )

    def is_told_apart(self, rises: Vector) -> bool:
        """Return whether the chamber that rose most shows most, and no other nearly as much.

        Where there is no 0 Pa the others are filled, too, and to different pressures. Monitors may
        be as far off as setpoints.
        """
        if self._least <= 0.0:
            return True
        shown = [zero + rise for zero, rise in zip(self.zeros, rises, strict=True)]
        rose = rises.index(max(rises))
        return shown[rose] >= SEEN + self.unsure + max(p for k, p in enumerate(shown) if k != rose)

    def climb(self) -> Climbed:
        """Raise all setpoints until every monitor answers, but none that shows as much already.

        A setpoint whose scale is too large stays so where it was first seen.
        """
        setpoints, rises = [0.0] * len(self.zeros), (0.0,) * len(self.zeros)
        for level in self.levels:
            setpoints = [
                before if rise > max(2.0 * SEEN, _MUCH * (before - self._least)) else level
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
        self.require_answers(rises)
        return rises

    def require_answers(self, rises: Vector) -> None:
        """Raise unless every monitor has risen.

        Raises
        ------
        Defect
            One does not answer, or none does.
        """
        if min(rises) >= SEEN:
            return
        level = f"of {self.levels[-1] / 1e3:.4g} kPa"
        if max(rises) < SEEN:
            raise Defect(
                self.regulators.channels[0],
                f"no pressure rises with the supply open ({max(rises) / 1e3:.1f} kPa {level}): the "
                "supply does not open, or has no pressure; or every regulator or valve is stuck",
            )
        number = rises.index(min(rises))
        # Beside a regulator a monitor shows nothing of the tube, at a chamber it does.
        own = "valve is stuck, its tube is off" if self._is_loop else "regulator is stuck"
        raise Defect(
            self.regulators.channels[number],
            f"its monitor shows {max(rises[number], 0.0) / 1e3:.1f} kPa {level}, and others rise: "
            f"its {own}, its output or its monitor is not wired or frozen, or the scale of its "
            "setpoint is much too small",
        )

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

    def watch(self, duration: float) -> list[tuple[float, Vector]]:
        """Return what the monitors show for so long: the time since then (s), and Pa gauge."""
        start = self.bench.now
        rows: list[tuple[float, Vector]] = []
        while self.bench.now - start < duration:
            self.bench.cycle()
            rows.append((self.bench.now - start, self.regulators.pressure().value))
        return rows

    def have_fallen(self, share: float, tops: Vector) -> Callable[[], bool]:
        """Return what tells whether every monitor has lost all but a share of its rise."""

        def fallen() -> bool:
            return self.below(self.regulators.pressure().value, share, tops)

        return fallen

    def above(self, pressures: Vector, tops: Vector) -> bool:
        """Return whether a pressure has risen well beyond an earlier rise."""
        found = zip(pressures, self.zeros, tops, strict=True)
        return any(p - zero > top + SEEN for p, zero, top in found)

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
        least = regulators.pressure_range[0]
        chambers.set_all(least, SETTLE if least > 0.0 else 0.3)  # which fills the chambers
        chambers.take_zeros()
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


def gauges(stem: str, pressure: float, text: str, channels: Sequence[str]) -> Task:
    """Return the task to read the gauge of the chamber that shows most: ``agonist 8.1 kPa``.

    Its key ends with the pressure that was asked for, which depends on the answers before.
    """

    def look(world: BreakableWorld) -> str:
        shown = true_pressures(world, channels)
        most = max(shown, key=lambda channel: shown[channel])
        return f"{most} {shown[most] / 1e3:.2f} kPa"

    form = whose_reading(channels, "Pa", "8 kPa")
    return Task(f"{stem}{pressure / 1e3:.3g}", text, look, form, stem)
