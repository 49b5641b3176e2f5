"""Whether what a refusal says is true: by kinematics of our own, or by doing what it names."""

import dataclasses
import math
import re

import numpy as np
from drawn_cases import faults_of, hand_of

from controllers.arm.paths import Circle, DwellLine, Line
from controllers.motion import InfeasibleMotion

_NUMBER = r"(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
_LONGEST = 600.0
"""s: a motion that takes longer, sixty thousand periods, is not tried by who refuses …"""
_LONG = 30.0
"""… nor here one that takes longer than this: its samples would take minutes."""


class Refused:
    """A refusal, and what else can be asked of who gave it.

    Parameters
    ----------
    prepare : callable
        ``prepare(geometry, path)`` plans or raises.
    geometry, path
        What was refused.
    message : str
        In which words.
    rates, accelerations : sequence of int
        Joints whose limits a plan promises.
    """

    def __init__(self, prepare, geometry, path, message, rates, accelerations):
        self.prepare, self.geometry, self.path, self.message = prepare, geometry, path, message
        self.rates, self.accelerations = rates, accelerations

    def false_claim(self):
        """Return what is false about it; None if all of it is true."""
        for pattern, judge in _KINDS:
            found = re.search(pattern, self.message)
            if found:
                values = [float(group) for group in found.groups() if group is not None]
                wrong = judge(self, *values)
                return None if not wrong else f"{wrong}: {self.message}"
        return f"nobody knows how to check: {self.message}"

    def says(self, words, geometry=None, path=None):
        """Return whether words are in the refusal of another arm or path."""
        try:
            self.prepare(geometry or self.geometry, path or self.path)
        except InfeasibleMotion as error:
            return words in str(error)
        return False

    def limited(self, name, joint, value):
        """Return the arm with another limit of one joint."""
        limits = list(getattr(self.geometry, name))
        limits[joint] = value
        return dataclasses.replace(self.geometry, **{name: tuple(limits)})

    def slower(self, speed):
        """Return the path at another speed, m/s; the tool turns as much less."""
        if isinstance(self.path, Circle):
            return dataclasses.replace(self.path, rate=speed)
        turns = getattr(self.path, "turn_rate", 0.0)
        turning = {"turn_rate": turns * speed / self.path.speed} if turns else {}
        return dataclasses.replace(self.path, speed=speed, **turning)


def _rate(refused, joint, need, limit):
    if not math.isclose(limit, refused.geometry.rate_limits[int(joint) - 1], rel_tol=1e-3):
        return "another limit"
    return _fits(refused) if need > limit else "no excess"


def _fits(refused, *_):
    """Do what a refusal names."""
    speed = re.search(rf"; at (?:a rate of )?{_NUMBER} (?:m/s|rad/s)", refused.message)
    if speed is None:
        return None if "no speed was found" in refused.message else "no speed is named"
    named = refused.slower(float(speed[1]))
    dwell = re.search(rf"with a dwell of {_NUMBER} s", refused.message)
    if dwell is not None:
        named = dataclasses.replace(named, dwell=float(dwell[1]))
    untried = re.search(rf"not tried as it takes at least {_NUMBER} s", refused.message)
    if untried is not None:
        return None if float(untried[1]) > _LONGEST else "it could have been tried"
    if _duration(named) > _LONG:
        return ""  # of so slow a motion nothing is tried here
    _, too, other = refused.message.partition("it would be refused, too: ")
    try:
        plan = refused.prepare(refused.geometry, named)
    except InfeasibleMotion as error:
        if too:
            return (
                "" if other.split(" ")[3:5] == str(error).split(" ")[3:5] else "for another reason"
            )
        return f"at what it names it does not fit ({error})"
    if too:
        return "it is not refused there"
    promised = refused.rates(named)
    return ", ".join(
        faults_of(refused.geometry, named, plan, promised, refused.accelerations, keeps_path=False)
    )


def _duration(path):
    """Return about how long a path takes, s."""
    if isinstance(path, Circle):
        return (path.end - path.begin) / path.rate
    if isinstance(path, Line):
        return (path.before + path.after) / path.speed
    return getattr(path, "dwell", 0.0) + 0.5 / path.speed


def _range(refused, joint, value, low, high):
    j, path = int(joint) - 1, refused.path
    angle, lower, upper = map(math.radians, (value, low, high))
    if lower + 2e-4 < angle < upper - 2e-4:  # it is told in hundredths of a degree
        return "it is inside"
    begins = "after 0.000 s" in refused.message and not isinstance(path, Circle | Line)
    if begins and abs(path.start[j] - angle) > 2e-4:
        return "it does not start there"
    if value < low:
        wide = refused.limited("position_min", j, angle - 1e-3)
    else:
        wide = refused.limited("position_max", j, angle + 1e-3)
    return (
        "a wider range does not help"
        if refused.says(f"q{j + 1} would be at {value:.2f}", wide)
        else ""
    )


def _no_region(refused, *_):
    """A region is of no use either that the arm would start in."""
    words = ("there is no such region", "starts inside the region")
    least = re.search(rf"at least {_NUMBER} rad/s", refused.message)
    if least is None:  # no rate of q3 would do
        if not any(refused.says(word, refused.limited("rate_limits", 2, 1e3)) for word in words):
            return "q3 needs but be fast"
    else:
        for share, refuses in ((0.999, True), (1.001, False)):
            arm = refused.limited("rate_limits", 2, share * float(least[1]))
            if any(refused.says(word, arm) for word in words) is not refuses:
                return f"at {share} of that rate of q3"
    slower = re.search(rf"no faster than {_NUMBER} m/s", refused.message)
    path = refused.slower(0.999 * float(slower[1]))
    return "not at that speed either" if refused.says(words[0], path=path) else ""


def _wrist_at_start(refused, *_):
    path = refused.path
    if isinstance(path, Circle | Line):
        return ""  # it starts elsewhere: what it is there, only its own kinematics know
    return "it is none" if abs(math.sin(path.start[4])) > 1e-6 else ""


def _out_of_reach(refused, distance, nearest, farthest):
    geometry, path = refused.geometry, refused.path
    if nearest <= distance <= farthest:
        return "it is within"
    plain = not (geometry.elbow_offset or geometry.shoulder_offset or geometry.a1)
    if plain and abs(farthest - geometry.a2 - geometry.a3) > 0.011:
        return "another reach"
    if not (plain and isinstance(path, Line) and path.shoulder_distance is None):
        return ""
    gone = re.search(rf"after {_NUMBER} m of {_NUMBER} m the path leaves", refused.message)
    own = _wrist_distance(geometry, path, float(gone[1]) if gone else 0.0)
    if abs(own - distance) > (1e-6 if gone is None else 1e-3):
        return f"it is {own:.9f} m away"
    worst = re.search(
        rf"farthest outside after {_NUMBER} m of .*, by {_NUMBER} mm", refused.message
    )
    if worst is None:
        return ""
    own = _wrist_distance(geometry, path, float(worst[1]))
    outside = 1e3 * max(own - farthest, nearest - own)
    return (
        ""
        if math.isclose(outside, float(worst[2]), rel_tol=0.02, abs_tol=0.01)
        else (f"it is {outside:.4g} mm outside there")
    )


def _wrist_distance(geometry, path, gone):
    """Return how far the wrist is from the shoulder, m, where the hand has gone so far."""
    hand, tool = hand_of(geometry, path.middle)
    along = np.array(path.direction) / np.linalg.norm(path.direction)
    hand = hand + (gone - path.before) * along
    tool = _about(path.axis, path.turn_rate * (gone - path.before) / path.speed) @ tool
    wrist = hand - tool @ np.array((0.0, 0.0, geometry.d6))
    return np.linalg.norm(wrist - np.array((0.0, 0.0, geometry.base_height)))


def _beside_shoulder(refused, distance, offset):
    if abs(offset - abs(refused.geometry.shoulder_offset)) > 1e-5:
        return "another offset"
    return "" if distance <= offset + 1e-6 else "it is beyond"


def _needs_plain_arm(refused, value):
    lengths = (refused.geometry.a1, refused.geometry.shoulder_offset, refused.geometry.elbow_offset)
    named = any(abs(value - length) < 1e-5 for length in lengths)
    return "" if named and isinstance(refused.path, Circle) else "the arm has none"


def _about(axis, angle):
    """Return a rotation about any axis (Rodrigues)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    K = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K


def _reversing_dwell(refused, *_):
    most = float(re.search(rf"dwells at most {_NUMBER} s", refused.message)[1])
    for share, refuses in ((0.99, False), (1.01, True)):
        path = dataclasses.replace(refused.path, dwell=share * most)
        if refused.says("would stop and reverse", path=path) is not refuses:
            return f"at {share} of that dwell"
    return ""


def _inside_region(refused, sine):
    bent = math.atan2(refused.geometry.elbow_offset, refused.geometry.a3)
    if abs(abs(math.sin(refused.path.start[2] + bent)) - sine) > 1e-4:
        return "another S3"
    slower = re.search(rf"no faster than {_NUMBER} m/s", refused.message)
    if slower is None:
        return ""
    path = refused.slower(0.999 * float(slower[1]))
    return "not slower either" if refused.says("starts inside the region", path=path) else ""


def _deep_region(refused, distance, depth):
    geometry, path = refused.geometry, refused.path
    if abs(path.depth - depth) > 1e-4 or distance > depth:
        return "another region"
    if geometry.elbow_offset or geometry.shoulder_offset or geometry.a1:
        return ""
    wrist, _ = hand_of(dataclasses.replace(geometry, d6=0.0), path.start)
    away = np.linalg.norm(wrist - np.array((0.0, 0.0, geometry.base_height)))
    own = geometry.a2 + geometry.a3 - away
    return "" if abs(own - distance) < 1e-4 else f"it is {own:.4f} m"


_KINDS = (
    (rf"q(\d) would need {_NUMBER} rad/s, beyond its limit of {_NUMBER} rad/s", _rate),
    (rf"the hand would be {_NUMBER} mm off its path", _fits),
    (rf"q(\d) would be at {_NUMBER} deg, outside its range of {_NUMBER} to {_NUMBER} deg", _range),
    (r"q(\d) would be at more than 20 turns, as at a singularity", lambda refused, joint: ""),
    ("there is no such region", _no_region),
    ("the arm starts at the wrist's singularity", _wrist_at_start),
    (
        rf"wrist centre is {_NUMBER} m from the shoulder; the arm reaches from {_NUMBER} m to "
        rf"{_NUMBER} m",
        _out_of_reach,
    ),
    (
        rf"wrist centre is {_NUMBER} m from the axis of q1, within the shoulder's offset of "
        rf"{_NUMBER} m",
        _beside_shoulder,
    ),
    (rf"singularity needs an arm without .*; this one's is {_NUMBER}", _needs_plain_arm),
    # Of branches nothing is re-derived.
    ("meets the elbow's singularity .* beyond which it is not reached", lambda refused: ""),
    ("would stop and reverse the arm in the region", _reversing_dwell),
    (rf"starts inside the region: \|S3\| = {_NUMBER} at the start", _inside_region),
    (rf"its wrist is {_NUMBER} m from the boundary, the region is {_NUMBER} m deep", _deep_region),
    (
        "look-ahead is as fast as it can be and cannot dwell",
        lambda refused: "" if isinstance(refused.path, DwellLine) else "it is no dwell",
    ),
)
