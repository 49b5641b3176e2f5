"""Direction and scale of each axis: first all by next to nothing, then one at a time by little."""

from math import degrees, radians
from typing import Final

from rig.commissioning.site import Site
from rig.commissioning.step import (
    AcceptanceStep,
    Defect,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.config import Profile
from rig.hal import DeviceFault
from rig.mechanisms.servo.commissioning.axes import (
    ENABLED,
    DialGauges,
    Turned,
    axis_names,
    energised,
    parse_turned,
)

_ALL: Final = (
    (radians(0.008), radians(0.1)),
    (radians(0.08), radians(0.2)),
    (radians(0.16), radians(0.3)),
)
"""What all axes are asked for together, and what none may exceed, rad. A gear that is wrong by a
hundred is seen in the first before anything turns by a degree, one by ten in the second; drives
without an integral jump by a tenth of a degree as dry friction lets go."""
_TAKEN_UP: Final = radians(0.1)
"""What each axis is asked for alone before anybody looks, rad: backlash and dry friction, which
swallow as much of the first motion, are not in the second."""
_ALONE: Final = radians(0.25)
"""What each axis is asked for alone then, rad: with what the others let pass, below a degree."""
_COUNTS: Final = 4.0
"""An axis whose counts are coarse is asked for so many of them at least."""
_SCALE: Final = (0.75, 1.33)
"""What a joint may turn over what was asked for, beside the counts of its drive."""
_SEEN: Final = 0.3
"""Share of what was asked for that is a motion."""


class AxesAlone(AcceptanceStep):
    """All axes are turned by next to nothing, then each one alone by a quarter of a degree."""

    name = "axes"
    does = (
        "All joints are turned by 0.008, 0.08 and 0.16 degrees, then each alone by 0.1 "
        "and 0.25 (or 4 counts); you read which one turns, which way, and how far."
    )
    expects = "The joint that was sent turns, as far as it was sent, in its positive direction."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        names = axis_names(site.profile)
        for asked, most in _ALL:
            together = dict.fromkeys(names, asked)
            turned, shown = _turn(site, names, together, f"axes.all.{degrees(asked):g}")
            if abs(turned.by) > most:
                its = shown.get(turned.whose, 0.0)
                raise Defect(turned.whose, _why_too_far(turned, its, asked))
        measured: list[MeasuredValue] = []
        steps = _resolutions(site.profile)
        for name in names:
            asked = max(_ALONE, _COUNTS * steps[name])
            turned, shown = _turn(site, names, {name: asked}, f"axes.{name}", _TAKEN_UP)
            measured += _judge(name, turned, shown[name], asked, steps[name] / asked)
        return StepResult(tuple(measured))


def _turn(
    site: Site, names: tuple[str, ...], by: dict[str, float], key: str, before: float = 0.0
) -> tuple[Turned, dict[str, float]]:
    """Return which joint turned most, and what every drive showed of it, rad."""
    gauges = DialGauges(names, key)
    with energised(site) as axes:
        axes.bench.run(ENABLED)
        try:
            axes.turn(dict.fromkeys(by, before))
            first = axes.shown()
            site.operator.do(gauges.zero, site.world_of(axes.rig))
            axes.turn(by)
            shown = {name: angle - first[name] for name, angle in axes.shown().items()}
        except DeviceFault as fault:
            what = (
                "it does not follow: its encoder is mirrored or frozen, it is blocked, or its gear "
                "is wrong"
            )
            raise Defect(fault.device, f"{what}; {fault}") from fault
        site.operator.do(gauges.read, site.world_of(axes.rig))
    return parse_turned(site.operator.answer(gauges.read)), shown


def _resolutions(profile: Profile) -> dict[str, float]:
    """Return the finest step of each axis, rad."""
    drives = [entry.settings for entry in profile.devices.values()]
    return {its: drive.resolution(its) for drive in drives for its in drive.axis_bounds()}


def _why_too_far(turned: Turned, shown: float, asked: float) -> str:
    """Return why a joint has turned much further than it was asked to, rad."""
    what = f"it turned by {degrees(turned.by):.3f} deg when it was asked for {degrees(asked):g}"
    if shown * turned.by < 0.0 and abs(shown) > _SEEN * abs(turned.by):
        return f"its encoder is mirrored: {what}, and shows {degrees(shown):.3f}"
    if abs(shown) < _SEEN * asked:
        return f"its encoder is frozen: {what}, and shows {degrees(shown):.3f}"
    return f"wrong scale: {what}; its gear or its counts per turn are wrong"


def _judge(
    name: str, turned: Turned, shown: float, asked: float, step: float
) -> list[MeasuredValue]:
    """Return how far a joint and its drive went; raise for what is wrong with it."""
    low, high = _SCALE
    seen, own = abs(turned.by) > _SEEN * asked, shown / asked
    if not seen:
        what = "although its drive shows that it does" if abs(own) > _SEEN else "nor does its drive"
        raise Defect(
            name,
            f"it does not turn, {what}: it is blocked, its brake holds it, or its gear is wrong",
        )
    if turned.whose != name:
        raise Defect(name, f"drives exchanged: its setpoint turns {turned.whose}")
    require(turned.by > 0.0, name, "direction reversed: it turns against its positive direction")
    half = 0.5 * step
    gone = MeasuredValue(
        f"{name}: gauge over setpoint", turned.by / asked, "1", low - half, high + half
    )
    read = MeasuredValue(
        f"{name}: drive over gauge", shown / turned.by, "1", low - step, high + step
    )
    return [
        require_within(name, gone, "wrong scale: its gear or its counts per turn are wrong"),
        require_within(name, read, "wrong scale of its encoder"),
    ]
