"""Wiring and scale of each regulator, one at a time at the lowest pressures."""

from typing import Final

from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult, require_within
from rig.config.quantities import parse_reading
from rig.hal import Vector
from rig.hal.formats import format_quantity
from rig.mechanisms.pneumatic.alarms.bounds import STATIC
from rig.mechanisms.pneumatic.commissioning.chambers import (
    SEEN,
    Chambers,
    energised,
    gauges,
)

_MORE: Final = 3e3
"""From level to level where the other chambers are filled, too, and this one shows less yet, Pa."""
_STEP: Final = 8e3
"""From a level that was answered to the next one at most, Pa."""
_HIGHEST, _STEEPEST = 18.5e3, 2.1
"""No gauge may show more, Pa, and how much steeper than asked for a pressure may rise: of a scale
that is wrong by a factor of two."""
_ENOUGH, _ENOUGH_OF_LOOP = 15e3, 12e3
"""A setpoint or a gauge that is so high tells a scale from hysteresis and offsets, Pa; a loop
around a valve has none, and overshoots."""
_FIRST: Final = (0.25, 1.4)
"""Gauge over setpoint where the monitor first answers: hysteresis and offsets are part of it."""
_THEN: Final = (0.7, 1.35)
"""The same at the highest level, of which they are a smaller part; offsets of a regulator as sold
come to 6 kPa, so that beyond this its slope has the word, unless it is beyond `_FAR`."""
_SLOPE: Final = (0.75, 1.3)
"""Rise of the gauge over that of the setpoint, from the level that was answered to the highest:
offsets and hysteresis are not in it, what a regulator repeats badly is twice."""
_FAR: Final = (0.5, 1.6)
"""What no offset makes of a gauge over its setpoint there."""
_LOOP: Final = (0.1, 2.4)
"""The same of a loop around a valve, whose least openings are not known yet: what its sensor
shows is held to the gauge."""
_SHOWN: Final = (0.7, 1.3)
"""Rise of the monitor over that of the gauge, from the one level to the next."""
_MUCH_OFF: Final = 0.5
"""Share of what a regulator may be off from which on it is told that it is."""
_ARRIVES: Final = 0.4
"""Share of a monitor's rise that some gauge shows where the air gets to a chamber, whatever scale
the monitor has."""


class RegulatorsAlone(AcceptanceStep):
    """Each chamber is filled alone, and the gauges are read."""

    name = "actuators"
    does = (
        "Each chamber alone gets 5 to 17 kPa above the least setpoint, then more, but never so "
        "much that a gauge could go beyond 20 kPa above it; you read which gauge moves."
    )
    expects = "Its own gauge and its own monitor show what was asked for; no other one moves."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        measured: list[MeasuredValue] = []
        has_valves = site.profile.mechanism_settings.valves is not None
        with energised(site) as chambers:
            channels, levels = chambers.regulators.channels, _levels_of(chambers)
            lift, unsure = chambers.lift, chambers.unsure
            least, largest = chambers.regulators.pressure_range
        most = STATIC * (largest - least) + (unsure if lift > 0.0 else 0.0)
        remarks: list[str] = []
        for number, channel in enumerate(channels):
            first, then, enough = _FIRST, _THEN, _ENOUGH
            if has_valves:
                first, then, enough = _LOOP, _LOOP, _ENOUGH_OF_LOOP
            for level in levels:
                low = _fill(site, number, level)
                # Another gauge may show more as long as its chamber's least is more.
                if max(low.rises) >= SEEN and low.is_told_apart and low.whose == channel:
                    break
            _find_swapped_wires(channels, number, low)
            _find_wrong_tube(channel, number, low)
            measured.append(_setpoint_scale(channel, low, number, level, first, unsure))
            high, lowest, enough, further = low, level, enough + lift, 0.0
            highest = _HIGHEST + lift
            if lift > 0.0:  # chambers that were told apart late
                highest = max(highest, low.gauge + _STEP)
            while high is low or (level < enough and high.gauge < enough):
                level += min(_STEP, (highest - high.gauge) / _STEEPEST)
                high = _fill(site, number, level)
            given, rise = high.gauge - low.gauge, high.rises[number] - low.rises[number]
            slope = given / (level - lowest)
            if not has_valves and _SLOPE[0] <= slope <= _SLOPE[1]:
                then, further = _FAR, unsure
            measured.append(_setpoint_scale(channel, high, number, level, then, further))
            measured.append(_monitor_scale(channel, rise, given))
            if not has_valves:
                off = _offset(channel, high.gauge - level, most)
                measured.append(off)
                remarks += _remark(site, channel, off)
        return StepResult(tuple(measured), said=" ".join(remarks))


def _levels_of(chambers: Chambers) -> Vector:
    """Return what a chamber is given until it shows most: more where the others are filled, too."""
    levels = chambers.levels
    more = round(3.0 * chambers.unsure / _MORE) if chambers.lift > 0.0 else 0
    return (*levels, *(levels[-1] + _MORE * (k + 1) for k in range(more)))


class _Filled:
    """Readings of monitors and gauges of one filled chamber."""

    def __init__(self, chambers: Chambers, rises: Vector, answer: str) -> None:
        self.rises = rises
        self.is_told_apart = chambers.is_told_apart(rises)
        self.whose, _, shown = answer.strip().partition(" ")
        self.gauge = parse_reading(shown, "Pa")
        before = dict(zip(chambers.regulators.channels, chambers.zeros, strict=True))
        self._before = max(before.get(self.whose, 0.0), 0.0)

    def moved(self, channel: str) -> float:
        """Return by how much that gauge can have moved, Pa, if `channel` was filled.

        Another chamber shows what it had before: regulators as sold let some kPa in.
        """
        return self.gauge - (0.0 if self.whose == channel else self._before)


def _fill(site: Site, number: int, pressure: float) -> _Filled:
    with energised(site) as chambers:
        channels = chambers.regulators.channels
        chambers.set(chambers.alone(number, pressure))
        rises = chambers.rises()
        task = gauges(
            f"actuators.{channels[number]}.",
            pressure,
            f"Which gauge shows most ({', '.join(channels)}), and how much? e.g. agonist 8 kPa",
            channels,
        )
        site.operator.do(task, site.world_of(chambers.rig))
        chambers.bench.run(site.glance(chambers.rig))
    return _Filled(chambers, rises, site.operator.answer(task))


def _find_swapped_wires(channels: tuple[str, ...], number: int, filled: _Filled) -> None:
    """Raise if another chamber or another monitor answers than the one that was asked."""
    channel, rises = channels[number], filled.rises
    shown = max(range(len(channels)), key=lambda k: rises[k])
    if rises[shown] < SEEN:
        raise Defect(
            channel,
            "no monitor shows its pressure: setpoint or monitor is not wired, or zero or scale of "
            "its setpoint are much too small",
        )
    other = channels[shown]
    if shown != number and filled.whose == channel:
        raise Defect(channel, f"monitor wires swapped: the monitor of {other} shows its chamber")
    if shown != number:
        raise Defect(channel, f"setpoint wires swapped: the setpoint of {channel} fills {other}")


def _find_wrong_tube(channel: str, number: int, filled: _Filled) -> None:
    """Raise if the air of a regulator gets nowhere, or into another chamber."""
    rise = filled.rises[number]
    if filled.moved(channel) < _ARRIVES * rise:
        raise Defect(
            channel,
            f"its tube is off, leaks or is blocked: its monitor rises by {rise / 1e3:.1f} kPa, and "
            f"no gauge rises with it; {filled.whose} shows most, {filled.gauge / 1e3:.1f} kPa",
        )
    if filled.whose != channel:
        raise Defect(
            channel, f"tubes swapped: its regulator is right, and the gauge of {filled.whose} moves"
        )


def _setpoint_scale(
    channel: str,
    filled: _Filled,
    number: int,
    asked: float,
    bounds: tuple[float, float],
    unsure: float,
) -> MeasuredValue:
    """Return the gauge over what was asked for; raise if a scale is wrong, or seems to be."""
    name = f"{channel}: gauge over setpoint, {asked / 1e3:.3g} kPa"
    low, high = max(bounds[0] - unsure / asked, 0.0), bounds[1] + unsure / asked
    value = MeasuredValue(name, filled.gauge / asked, "1", low, high)
    why = "wrong zero or scale of its setpoint"
    if value.value < low:
        leaks = filled.rises[number] > _SHOWN[1] * filled.gauge
        why += ", or its tube leaks" if leaks else ", or the supply gives no more"
    return require_within(channel, value, why)


def _offset(channel: str, off: float, most: float) -> MeasuredValue:
    """Return by how much the gauge is off its setpoint; raise if a healthy regulator never is."""
    name = f"{channel}: gauge off its setpoint"
    why = "it lets out another pressure than it is asked for by more than its maker states"
    return require_within(channel, MeasuredValue(name, off, "Pa", -most, most), why)


def _remark(site: Site, channel: str, off: MeasuredValue) -> list[str]:
    """Return what to do about a regulator that is off by much of what its maker states."""
    if abs(off.value) < _MUCH_OFF * off.high:
        return []
    off_by, bound = (format_quantity(value, off.unit) for value in (off.value, off.high))
    remedy = f"`rig calibrate {site.profile.argument} regulators` finds that"
    return [f"{channel} gives {off_by} beside what it is asked for, of at most {bound}: {remedy}."]


def _monitor_scale(channel: str, rise: float, gauge: float) -> MeasuredValue:
    """Return by how much the monitor rose over the gauge; raise if a scale is wrong."""
    name = f"{channel}: monitor over gauge, as it rises"
    value = MeasuredValue(name, rise / max(gauge, 1.0), "1", *_SHOWN)
    leaks = ", or its tube leaks" if value.value > value.high else ""
    return require_within(channel, value, f"wrong scale of its monitor{leaks}")
