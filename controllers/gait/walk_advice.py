"""What would fit for a whole walk: another manner of walking, flatter, longer or shorter steps."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from controllers.gait.footprints import Footstep, SteppingSettings
from controllers.gait.footstep_advice import HIGHER, LOWER, nearest_lift
from controllers.gait.footstep_checks import BeyondLeg, MeetsGround, OutOfBalance
from controllers.gait.footstep_trials import Trials
from controllers.gait.geometry import LegGeometry
from controllers.motion import InfeasibleMotion

_MM = 1e-3
_FARTHEST = 80
"""How far the waist might go to meet a foot at most, mm."""
_STRIDE = 5
"""Between the distances that are tried, mm."""
_FLATTER = tuple(round(0.1 * k, 1) for k in range(10, 0, -1))
"""What all heights are multiplied by, the most first."""
_LONGER = (1.0, 1.05, 0.95, 1.1, 0.9, 1.2, 0.8, 1.3, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
"""What all ways ahead are multiplied by, if the robot turns nowhere."""
_FOLLOWS = (30, 20, 40, 60)
"""How far the waist might go to meet a foot on them, mm."""
_LIFTS = (20, 30)
"""How far feet might be lifted on them, mm."""


def advise_manner(trials: Trials, settings: SteppingSettings, error: InfeasibleMotion) -> str:
    """Say with what manner of walking all steps would fit as they are; empty: with none.

    Parameters
    ----------
    trials : Trials
        Of the walk that is refused.
    settings : SteppingSettings
        How it was to be walked.
    error : InfeasibleMotion
        Why it is refused.
    """
    for manner in _manners(trials, settings, error):
        if trials.walk_fits(trials.steps, manner):
            return f" With {_listed(_changes(settings, manner))} all steps would fit."
    return ""


def advise_walk(trials: Trials, settings: SteppingSettings) -> str:
    """Say how all steps would fit if they were flatter, longer or shorter; empty: they would not.

    A step down may do by itself and leave the foot behind too high for the next one: then what has
    to change lies before the step that is refused. Parameters as `advise_manner`.
    """
    middle = _middle_of_sole(trials.geometry)
    manners = [
        replace(settings, lift=lift, follow=follow, ahead=ahead)
        for lift in dict.fromkeys((settings.lift, *(_MM * mm for mm in _LIFTS)))
        for follow in dict.fromkeys((settings.follow, *(_MM * mm for mm in _FOLLOWS)))
        for ahead in dict.fromkeys((settings.ahead, middle))
    ]
    for changed, steps in _smaller(trials.geometry, trials.steps):
        for manner in manners:
            if trials.walk_fits(steps, manner):
                words = _listed((*_changes(settings, manner), *changed))
                return f" With {words} all steps would fit."
    return ""


def _smaller(
    geometry: LegGeometry, steps: Sequence[Footstep]
) -> Iterator[tuple[list[str], list[Footstep]]]:
    """Yield steps that are like these and may be easier, with what was changed in words."""
    tilts = any(step.pitch or step.roll for step in steps)
    climbs = any(step.height for step in steps)
    if tilts:
        return
    if climbs or all(step.heading == 0.0 for step in steps):
        for flatter in _FLATTER if climbs else _FLATTER[:1]:
            for longer in _LONGER:
                said = [
                    f"every height times {flatter:g}" if flatter != 1.0 else "",
                    f"every x times {longer:g}" if longer != 1.0 else "",
                ]
                tried = [replace(s, x=s.x * longer, height=s.height * flatter) for s in steps]
                yield [word for word in said if word], tried
    spacing = geometry.hip_half_spacing
    if not climbs:
        for share in _FLATTER[1:]:
            sides = [spacing if step.foot == "left" else -spacing for step in steps]
            yield (
                [f"every x, heading and distance of y from {spacing / _MM:g} mm times {share:g}"],
                [
                    replace(s, x=s.x * share, y=y + share * (s.y - y), heading=s.heading * share)
                    for s, y in zip(steps, sides, strict=True)
                ],
            )


def _manners(
    trials: Trials, settings: SteppingSettings, error: InfeasibleMotion
) -> Iterator[SteppingSettings]:
    """Yield manners of walking that may help where a walk is refused, the nearest first."""
    yield from _with_other_sway(settings)
    aheads = list(dict.fromkeys((settings.ahead, *_towards(settings.ahead, trials.geometry))))
    asked = math.floor(settings.follow / _MM + 0.5)
    if isinstance(error, MeetsGround):
        yield from _with_nearest_lift(trials, settings, HIGHER)
    if isinstance(error, BeyondLeg):
        # A waist that goes to meet the foot needs less of both legs, and more of the sole.
        follows = [_MM * mm for mm in range(_STRIDE, _FARTHEST + 1, _STRIDE) if mm > asked]
        for ahead in aheads:
            yield from (replace(settings, follow=follow, ahead=ahead) for follow in follows)
        yield from _with_nearest_lift(trials, settings, LOWER)
        lifts = [_MM * math.floor(settings.lift / _MM * share) for share in LOWER]
        lifts = [lift for lift in lifts if lift > 0.0]
        for ahead in aheads:
            for follow in follows[:: _FARTHEST // _STRIDE // 4]:
                lower = replace(settings, follow=follow, ahead=ahead)
                yield from (replace(lower, lift=lift) for lift in lifts)
    if isinstance(error, OutOfBalance):
        follows = [_MM * mm for mm in range(_FARTHEST, -1, -_STRIDE) if mm < asked]
        for follow in (settings.follow, *follows):
            for ahead in aheads:
                if (follow, ahead) != (settings.follow, settings.ahead):
                    yield replace(settings, follow=follow, ahead=ahead)


def _with_other_sway(settings: SteppingSettings) -> Iterator[SteppingSettings]:
    """Yield ways aside that are nearer to over the standing ankle."""
    for share in (0.5, 1.0):
        sway = round(settings.sway + share * (1.0 - settings.sway), 2)
        if sway != settings.sway:
            yield replace(settings, sway=sway)


def _with_nearest_lift(
    trials: Trials, settings: SteppingSettings, times: Iterable[float]
) -> Iterator[SteppingSettings]:
    def fits(lift: float) -> bool:
        return trials.walk_fits(trials.steps, replace(settings, lift=lift))

    lift = nearest_lift(fits, settings.lift, times)
    if lift is not None:
        yield replace(settings, lift=_MM * lift)


def _towards(ahead: float, geometry: LegGeometry) -> Iterator[float]:
    """Yield places of the waist over the sole on the way to its middle, in whole millimetres, m."""
    middle = _middle_of_sole(geometry)
    for share in (1.0, 0.5):
        yield _MM * round((ahead + share * (middle - ahead)) / _MM)


def _middle_of_sole(geometry: LegGeometry) -> float:
    """Return how far the middle of a sole is ahead of its ankle, in whole millimetres, m."""
    return _MM * round(0.5 * (geometry.sole.front - geometry.sole.back) / _MM)


def _changes(asked: SteppingSettings, manner: SteppingSettings) -> list[str]:
    """Return in what two manners of walking differ."""
    sway = [f"sway at {manner.sway:g}"] if manner.sway != asked.sway else []
    return sway + [
        f"{'a lift of' if name == 'lift' else f'{name} at'} {getattr(manner, name) / _MM:.0f} mm"
        for name in ("lift", "follow", "ahead")
        if getattr(manner, name) != getattr(asked, name)
    ]


def _listed(words: Iterable[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last
