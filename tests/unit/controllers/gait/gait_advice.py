"""Does what a refusal of footsteps says would fit, as somebody who reads it would."""

import math
import re
from dataclasses import replace

NUMBER = r"(-?[\d.]+)"
MANNER = {
    "lift": rf"a lift of {NUMBER} mm",
    "follow": rf"follow at {NUMBER} mm",
    "ahead": rf"ahead at {NUMBER} mm",
}


def _found(pattern, words):
    match = re.search(pattern, words)
    return None if match is None else [float(group) for group in match.groups() if group]


def follow_advice(told, settings, steps):
    """Return settings and steps as a refusal says they would fit; None: it says nothing.

    Of two ways that are offered the first one is taken that is about all steps.
    """
    told = told.partition("bound is")[2] or told
    whole = re.search(r"With ((?:(?! With ).)*?) all steps would fit", told)
    if whole:
        changed = {
            name: number[0] / 1e3
            for name, pattern in MANNER.items()
            if (number := _found(pattern, whole[1]))
        }
        if sway := _found(rf"sway at {NUMBER}", whole[1]):
            changed["sway"] = sway[0]
        flatter = _found(rf"every height times {NUMBER}", whole[1]) or [1.0]
        longer = _found(rf"every x times {NUMBER}", whole[1]) or [1.0]
        smaller = _found(rf"distance of y from {NUMBER} mm times {NUMBER}", whole[1])
        if smaller:
            side, share = smaller[0] / 1e3, smaller[1]
            sides = {"left": side, "right": -side}
            return replace(settings, **changed), [
                replace(
                    step,
                    x=share * step.x,
                    y=sides[step.foot] + share * (step.y - sides[step.foot]),
                    heading=share * step.heading,
                )
                for step in steps
            ]
        return replace(settings, **changed), [
            replace(step, x=step.x * longer[0], height=step.height * flatter[0]) for step in steps
        ]
    named = re.search(r"[Ss]tep (\d+)(?: \([^)]*\))?(?: by itself)? would fit", told)
    if named is None:
        return None
    place = int(named[1]) - 1
    step = steps[place]
    at = rf"x {NUMBER} mm, y {NUMBER} mm(?:, heading {NUMBER} deg)?, height {NUMBER} mm"
    if lift := _found(rf"Lifted by {NUMBER} mm", told):
        step = replace(step, lift=lift[0] / 1e3)
    elif height := _found(rf"With a height of {NUMBER} mm", told):
        step = replace(step, height=height[0] / 1e3)
    elif numbers := _found(at, told):
        x, y, *heading, height = numbers
        step = replace(step, x=x / 1e3, y=y / 1e3, height=height / 1e3)
        step = replace(step, heading=math.radians(heading[0])) if heading else step
        tilts = _found(rf"pitch {NUMBER} deg, roll {NUMBER} deg", told)
        if tilts:
            step = replace(step, pitch=math.radians(tilts[0]), roll=math.radians(tilts[1]))
    return settings, [*steps[:place], step, *steps[place + 1 :]]
