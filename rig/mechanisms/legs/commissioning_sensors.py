"""Direction and scale of each load cell and of the inertial sensor, by hand and without energy."""

from collections.abc import Callable, Sequence
from functools import partial
from math import degrees, radians
from typing import Final

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
from rig.hal import ConfigurationError, DevicePicker, HandledPlant, InertialSensor, LoadCells
from rig.hal.world import BreakableWorld
from rig.mechanisms.legs.settings import LegsSettings
from rig.mechanisms.servo.commissioning.axes import Axes, listened

_FORCE: Final = 20.0
"""With which a cell is pressed, N: two litres of water."""
_LEAN: Final = radians(5.0)
"""By which the waist is leant."""
_SCALE: Final = (0.8, 1.25)
"""What a sensor may show over what an instrument does: a hand holds neither quite still."""
_OTHER: Final = 0.3
"""Share of it that another sensor may show."""
_AVERAGED: Final = 0.2
"""Over so long readings are averaged, s."""
_DELAY: Final = 0.1
"""Until a reading is of what a simulated hand has done, s."""


class BalanceSensorsByHand(AcceptanceStep):
    """Each load cell is pressed, and the waist is leant forwards and to the right."""

    name = "sensors"
    does = (
        "Nothing is energised and both feet are in the air; you press the sole under each load "
        "cell with about 20 N, and lean the waist by about 5 deg forwards, then to the right."
    )
    expects = "The cell that is pressed shows it, and the inertial sensor the lean; no other does."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        settings = site.profile.mechanism_settings
        assert isinstance(settings, LegsSettings)
        if settings.inertial is None:
            return StepResult(said="the profile names no load cells and no inertial sensor")
        measured: list[MeasuredValue] = []
        cells = [
            channel
            for name in settings.load_cells
            for channel in site.profile.devices[name].settings.channel_names()
        ]
        for k, cell in enumerate(cells):
            task = _hand(
                cell, _FORCE, "N",
                f"Press the sole under {cell} with about 20 N; how much is it by the balance? "
                "e.g. 20 N",
            )  # fmt: skip
            shown = _shown(site, task, _forces)
            measured.append(_judge(cells, k, shown, _told(site, task, "N")))
        leans = ("waist_roll", "waist_pitch")
        for k, (lean, how) in enumerate(zip(leans, ("to the right", "forwards"), strict=True)):
            task = _hand(
                lean, _LEAN, "rad",
                f"Lean the waist {how} by about 5 deg; how much is it by the level? e.g. 5 deg",
            )  # fmt: skip
            shown = _shown(site, task, _leans)
            measured.append(_judge(leans, k, shown, _told(site, task, "rad")))
        return StepResult(tuple(measured))


def _shown(site: Site, task: Task, read: Callable[[Axes], tuple[float, ...]]) -> tuple[float, ...]:
    """Return by how much every sensor of a kind shows more once something is done by hand, SI."""
    with listened(site) as axes:
        bench = axes.bench
        bench.run(_DELAY)
        before = _mean(bench, partial(read, axes))
        world = site.world_of(axes.rig)
        site.operator.do(task, world)
        bench.run(_DELAY if world is not None else 0.5 * site.patience(axes.rig))
        after = _mean(bench, partial(read, axes))
    return tuple(b - a for a, b in zip(before, after, strict=True))


def _mean(bench: StepBench, read: Callable[[], tuple[float, ...]]) -> tuple[float, ...]:
    rows: list[tuple[float, ...]] = []

    def look() -> bool:
        rows.append(read())
        return False

    bench.run(_AVERAGED, look)
    return tuple(sum(column) / len(rows) for column in zip(*rows, strict=True))


def _forces(axes: Axes) -> tuple[float, ...]:
    pick = DevicePicker("commissioning", axes.rig.devices)
    names = axes.rig.profile.mechanism_settings.load_cells
    return tuple(f for name in names for f in pick("load_cells", name, LoadCells).forces().value)


def _leans(axes: Axes) -> tuple[float, ...]:
    pick = DevicePicker("commissioning", axes.rig.devices)
    name = axes.rig.profile.mechanism_settings.inertial
    return pick("inertial", name, InertialSensor).lean().value


def _told(site: Site, task: Task, unit: str) -> float:
    """Return what somebody has read at an instrument, SI.

    Raises
    ------
    ConfigurationError
        It is nothing that a sensor could be held against.
    """
    by = parse_reading(site.operator.answer(task), unit)
    if by < _least(unit):
        raise ConfigurationError(f"{task.key}: {by:g} {unit} is too little to tell anything")
    return by


def _least(unit: str) -> float:
    """Return what a sensor can be held against, SI."""
    return 0.1 * (_FORCE if unit == "N" else _LEAN)


def _hand(channel: str, by: float, unit: str, text: str) -> Task:
    def act(world: BreakableWorld) -> str:
        if not isinstance(world.plant, HandledPlant):
            raise ConfigurationError(f"the simulated plant has nobody to move {channel}")
        world.plant.pull(channel, by)
        return f"{by:g} N" if unit == "N" else f"{degrees(by):g} deg"

    form = reading(unit, "80 N" if unit == "N" else "5 deg", _least(unit))
    return Task(f"sensors.{channel}", text, act, form)


def _judge(names: Sequence[str], k: int, shown: tuple[float, ...], by: float) -> MeasuredValue:
    """Return what a sensor has shown over what was done to it; raise for what is wrong with it."""
    name, own = names[k], shown[k] / by
    others = [other for j, other in enumerate(names) if j != k and abs(shown[j]) > _OTHER * by]
    if abs(own) <= _OTHER:
        what = f"and {others[0]} shows it: sensors swapped" if others else "and it shows nothing"
        require(False, name, f"it was pressed or leant, {what}")
    require(own > 0.0, name, "direction reversed: it shows less where it should show more")
    require(not others, name, f"{', '.join(others)} shows it as well: sensors are not told apart")
    value = MeasuredValue(f"{name} over the instrument", own, "1", *_SCALE)
    return require_within(name, value, "wrong scale of the sensor")
