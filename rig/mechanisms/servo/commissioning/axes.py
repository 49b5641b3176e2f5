"""Axes that are energised for one step, slow, weak and quick to give up."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import ceil, degrees, radians
from typing import Final, NamedTuple

from rig.assembly import REGISTRY, Rig
from rig.commissioning.bench import StepBench
from rig.commissioning.derating import gentle
from rig.commissioning.forms import whose_reading
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import require
from rig.config import Profile
from rig.config.quantities import UnitError, parse_reading
from rig.hal import ConfigurationError, DevicePicker, ServoBus, Vector
from rig.hal.world import BreakableWorld
from rig.mechanisms.servo.settings import ServoSettings

ENABLED: Final = 2.5
"""Until drives that may take two seconds have enabled themselves and hold, s."""
SETTLE: Final = 0.5
"""Until an axis has gone where it was sent, s."""
_SPEED: Final = radians(1.0)
"""With which an axis is sent anywhere, rad/s."""
_AWAY: Final = radians(0.5)
"""By how much a motor may turn beside its encoder, rad: twice what coarse velocities err."""
_SWINGS: Final = 2.0
"""Until what the step before let go hangs still, s: a simulation in one process begins anew."""
_AVERAGED: Final = 0.1
"""Over so long positions are averaged, s."""


class MotorWatch:
    """The ways of the motors by their own velocities, beside what the positions show."""

    def __init__(self, axes: "Axes") -> None:
        self._servos = axes.servos
        self._period = axes.rig.profile.loop.period
        self._starts = [servo.positions().value for servo in axes.servos]
        self._ways = [[0.0] * len(start) for start in self._starts]

    def look(self) -> bool:
        """Take this cycle's readings; always False, as nothing is waited for.

        Raises
        ------
        Defect
            A motor has turned by `_AWAY` more than its position shows.
        """
        for servo, start, ways in zip(self._servos, self._starts, self._ways, strict=True):
            here, speeds = servo.positions().value, servo.velocities().value
            for k, name in enumerate(servo.axis_names):
                ways[k] += speeds[k] * self._period
                apart = ways[k] - (here[k] - start[k])
                require(
                    abs(apart) <= _AWAY, name,
                    "its encoder is frozen or mirrored: the motor left the position by "
                    f"{degrees(apart):+.2f} deg",
                )  # fmt: skip
        return False


class Axes(NamedTuple):
    """The axes of a rig, by name.

    Parameters
    ----------
    bench : StepBench
        The rig's cycle.
    servos : sequence of ServoBus
        Its drives.
    """

    bench: StepBench
    servos: Sequence[ServoBus]

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.bench.rig

    def shown(self) -> dict[str, float]:
        """Return what each axis shows, rad; averaged."""
        rows: list[Vector] = []

        def look() -> bool:
            rows.append(tuple(a for servo in self.servos for a in servo.positions().value))
            return False

        self.bench.run(_AVERAGED, look)
        means = [sum(column) / len(rows) for column in zip(*rows, strict=True)]
        names = [name for servo in self.servos for name in servo.axis_names]
        return dict(zip(names, means, strict=True))

    def turn(self, by: Mapping[str, float]) -> None:
        """Send axes so far from where they were sent, rad, and wait until they are there.

        Raises
        ------
        Defect
            A motor turns on while its encoder shows nothing of it.
        """
        watch = MotorWatch(self)
        period = self.rig.profile.loop.period
        cycles = max(ceil(max(map(abs, by.values())) / (_SPEED * period)), 1)
        for cycle in range(cycles + 1):
            for servo in self.servos:
                shares = [by.get(name, 0.0) / (cycles * period) for name in servo.axis_names]
                servo.command_velocities(tuple(v if cycle < cycles else 0.0 for v in shares))
            self.bench.cycle()
            watch.look()
        self.bench.run(SETTLE, watch.look)


@contextmanager
def listened(site: Site, profile: Profile | None = None) -> Iterator[Axes]:
    """Connect a rig for a step that needs no torque, and read its axes.

    Parameters
    ----------
    site : Site
        The rig's.
    profile : Profile, optional
        As it is connected; default: gentle.
    """
    rig = site.make_rig(profile or gentle(site.profile))
    with rig:
        bear(site, rig)
        rig.arm(torque=False)
        yield _axes_of(rig)


@contextmanager
def energised(site: Site) -> Iterator[Axes]:
    """Connect and arm a rig for a step; its axes are held where they stand, after `ENABLED`."""
    rig = site.make_rig(gentle(site.profile))
    with rig:
        bear(site, rig)
        if not rig.backend.is_simulated:
            rig.clock.sleep_until(rig.clock.now() + _SWINGS)
        rig.arm()
        yield _axes_of(rig)


def bear(site: Site, rig: Rig) -> None:
    """Have hands bear what would fall; in simulation, where every step has a world of its own."""
    world = site.world_of(rig)
    if world is not None:
        site.operator.do(_BEAR, world)


def _hang(world: BreakableWorld) -> str:
    if _HUNG in world.plant.known_faults:
        world.plant.inject(_HUNG)
    return "done"


_HUNG: Final = "hung"
"""What `Plant.inject` calls it."""
_BEAR: Final = Task("axes.bear", "Hang up or support what would fall without its drives.", _hang)


def _axes_of(rig: Rig) -> Axes:
    settings = rig.profile.mechanism_settings
    assert isinstance(settings, ServoSettings)
    pick = DevicePicker("commissioning", rig.devices)
    return Axes(StepBench(rig), [pick("servos", name, ServoBus) for name in settings.servos])


def axis_names(profile: Profile) -> tuple[str, ...]:
    """Return the names of the axes of a profile's mechanism."""
    view = REGISTRY.load("mechanism", profile.mechanism)
    names: tuple[str, ...] = view.axis_limits(profile.mechanism_settings).names
    return names


def true_angles(world: BreakableWorld, names: Sequence[str]) -> dict[str, float]:
    """Return what protractors on the axes would show in a simulated world, rad."""
    columns = [name for name, _ in world.plant.truth_columns]
    truth = world.plant.truth()
    return {name: truth[columns.index(name)] for name in names}


def angle_of(text: str) -> float:
    """Return an angle that somebody has read, rad.

    Raises
    ------
    ConfigurationError
        It is none.
    """
    try:
        return parse_reading(text, "rad")
    except UnitError as error:
        raise ConfigurationError(f"an angle was asked for, as 12.5 deg: {error}") from error


class DialGauges:
    """Dial gauges at all axes, which are zeroed and then read."""

    def __init__(self, names: Sequence[str], key: str) -> None:
        self._names = names
        self._zeros: dict[str, float] = {}
        self.zero = Task(
            f"{key}.zero", "Zero the gauges, or mark where the joints stand.", self._zero
        )
        self.read = Task(
            key,
            f"Which joint has turned most ({', '.join(names)}), and how far, positive as in its "
            "drawing? e.g. q1 0.35 deg; or none",
            self._read,
            whose_reading(names, "rad", "0.35 deg", or_none=True),
        )

    def _zero(self, world: BreakableWorld) -> str:
        self._zeros = true_angles(world, self._names)
        return "done"

    def _read(self, world: BreakableWorld) -> str:
        now = true_angles(world, self._names)
        turned = {name: now[name] - zero for name, zero in self._zeros.items()}
        most = max(turned, key=lambda name: abs(turned[name]))
        return f"{most} {degrees(turned[most]):.4f} deg"


class Turned(NamedTuple):
    """The joint that turned most, and how far (rad); no name if none did."""

    whose: str
    by: float


def parse_turned(answer: str) -> Turned:
    """Return what somebody has read at the gauges."""
    whose, _, shown = answer.strip().partition(" ")
    if whose.lower() in ("", "none"):
        return Turned("", 0.0)
    return Turned(whose, angle_of(shown))
