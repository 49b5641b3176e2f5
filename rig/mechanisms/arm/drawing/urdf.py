"""A URDF from anywhere: its joints and nothing else of it.

The text may be anybody's. It is read by expat with no document type, and so without entities, and
with bounds; links and joints alone are kept, no mesh is looked for. What the joints come to in
space is MuJoCo's to say, whose reader of URDF is given that much.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element, SubElement, tostring
from xml.parsers import expat

import numpy as np

from controllers.motion import InfeasibleMotion
from controllers.text_file import read_lines
from rig.mechanisms.arm.drawing.chain import Chain, DrawingError, DrawnJoint

_DEEPEST: Final = 64
_MOST: Final = 20_000
"""Elements of a file."""
_MOST_JOINTS: Final = 1000
_LONGEST: Final = 200
"""Characters of a name or a value."""
_FARTHEST: Final = 100.0
_SHORTEST: Final = 1e-6
_DRIVEN: Final = {"velocity": (1e-3, 1e2, "rad/s"), "effort": (1e-3, 1e5, "N m")}
"""What a joint of a robot may have at most: from the slowest and weakest to the greatest."""
_FLANGE: Final = "tool0"
"""What ROS-Industrial calls the flange of every arm."""
_KEPT: Final = ("origin", "parent", "child", "axis", "limit", "mimic")
_TURNING: Final = ("revolute", "continuous")


@dataclass(slots=True)
class _Joint:
    """A joint's elements: their attributes by name."""

    name: str
    kind: str
    line: int
    parts: dict[str, dict[str, str]] = field(default_factory=dict)

    @property
    def parent(self) -> str:
        return self.parts.get("parent", {}).get("link", "")

    @property
    def child(self) -> str:
        return self.parts.get("child", {}).get("link", "")


def read_urdf(file: Path, tip: str | None = None) -> Chain:
    """Return the arm that a URDF describes, from its root to a link.

    Parameters
    ----------
    file : Path
        The URDF; of a xacro what it expands to.
    tip : str, optional
        The link whose motion is meant. None: the only one that six joints lead to, or else
        ``tool0``.

    Raises
    ------
    DrawingError
        It cannot be read, or six turning joints lead to no such link.
    """
    joints = _Reader(file).joints
    by_child = _by_child(file, joints)
    way = _way_to(file, tip or _only_tip(file, joints, by_child), by_child)
    moving = [joint for joint in way if joint.kind != "fixed"]
    for joint in moving:
        if joint.kind not in _TURNING or "mimic" in joint.parts:
            kind = "follows another" if "mimic" in joint.parts else f"is {joint.kind}"
            raise DrawingError(f"{file}, line {joint.line}: {joint.name} {kind}, and does not turn")
    if len(moving) != 6:
        names = ", ".join(joint.name for joint in moving) or "none"
        raise DrawingError(
            f"{file}: {len(moving)} joints lead to {way[-1].child} ({names}); an arm has six"
        )
    return _placed(file, way, moving)


def _by_child(file: Path, joints: list[_Joint]) -> dict[str, _Joint]:
    """Return the joints by the links that they lead to: each by one joint alone."""
    found: dict[str, _Joint] = {}
    for joint in joints:
        for end in ("parent", "child"):
            if not joint.parts.get(end, {}).get("link"):
                raise DrawingError(f"{file}, line {joint.line}: {joint.name} names no {end} link")
        if joint.child in found:
            other = found[joint.child]
            raise DrawingError(
                f"{file}, line {joint.line}: {joint.name} leads to {joint.child}, and so does "
                f"{other.name} of line {other.line}"
            )
        found[joint.child] = joint
    return found


def _only_tip(file: Path, joints: list[_Joint], by_child: dict[str, _Joint]) -> str:
    parents = {joint.parent for joint in joints}
    counts = {
        joint.child: sum(step.kind != "fixed" for step in _way_to(file, joint.child, by_child))
        for joint in joints
        if joint.child not in parents
    }
    ends = [link for link, count in counts.items() if count == 6]
    if len(ends) == 1:
        return ends[0]
    if _FLANGE in by_child:
        return _FLANGE
    if not ends:
        found = ", ".join(f"{count} lead to {link}" for link, count in list(counts.items())[:5])
        raise DrawingError(
            f"{file}: no link is at the end of six joints; {found or 'they end nowhere'}"
        )
    raise DrawingError(f"{file}: which link is the tool? Name one with --tip: {', '.join(ends)}")


def _way_to(file: Path, tip: str, by_child: dict[str, _Joint]) -> list[_Joint]:
    """Return the joints from the root to a link."""
    if tip not in by_child:
        raise DrawingError(f"{file}: no joint leads to {tip!r}; links are {', '.join(by_child)}")
    way: list[_Joint] = []
    while tip in by_child:
        way.append(by_child[tip])
        tip = way[-1].parent
        if len(way) > len(by_child):
            raise DrawingError(f"{file}: its joints lead round to {tip!r} again")
    return way[::-1]


def _placed(file: Path, way: list[_Joint], moving: list[_Joint]) -> Chain:
    """Return the chain as MuJoCo places it."""
    import mujoco

    root = Element("robot", name="arm")
    settings = SubElement(root, "mujoco")
    SubElement(settings, "compiler", fusestatic="false", boundmass="1", boundinertia="1")
    for link in (way[0].parent, *(joint.child for joint in way)):
        SubElement(root, "link", name=link)
    for joint in way:
        element = SubElement(root, "joint", name=joint.name, type=joint.kind)
        for part in ("origin", "parent", "child", *(("axis",) if joint in moving else ())):
            if part in joint.parts:
                SubElement(element, part, joint.parts[part])
        for part, key in (("origin", "xyz"), ("origin", "rpy"), ("axis", "xyz")):
            _check_numbers(file, joint, part, key)
    try:
        model = mujoco.MjModel.from_xml_string(tostring(root, encoding="unicode"))
    except ValueError as error:
        raise DrawingError(f"{file}: {' '.join(str(error).split())}") from error
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    tip = data.body(way[-1].child)
    drawn = []
    for joint in moving:
        lower, upper, speed, effort = _limits(file, joint)
        place = data.joint(joint.name)
        axis = np.array(place.xaxis)
        drawn.append(
            DrawnJoint(joint.name, np.array(place.xanchor), axis, lower, upper, speed, effort)
        )
    if not np.all(np.abs(np.concatenate((data.xpos, data.xanchor))) < _FARTHEST):
        raise DrawingError(f"{file}: its joints are not within {_FARTHEST:g} m of its root")
    return Chain(
        str(file),
        tuple(drawn),
        way[0].parent,
        way[-1].child,
        np.array(tip.xpos),
        np.array(tip.xmat).reshape(3, 3),
    )


def _check_numbers(file: Path, joint: _Joint, part: str, key: str) -> None:
    """Raise if an attribute is no three numbers: MuJoCo would say so in a file of its own."""
    text = joint.parts.get(part, {}).get(key)
    if text is None:
        return
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    if len(numbers) != 3 or not all(abs(number) < _FARTHEST for number in numbers):
        raise DrawingError(
            f"{file}, line {joint.line}: {key} of {part} of {joint.name} is {text[:60]!r}, no "
            f"three numbers below {_FARTHEST:g}"
        )
    if part == "axis" and not math.hypot(*numbers) > _SHORTEST:
        raise DrawingError(f"{file}, line {joint.line}: the axis of {joint.name} has no direction")


def _limits(file: Path, joint: _Joint) -> tuple[float, float, float | None, float | None]:
    """Return range (rad), speed (rad/s) and torque (N m) of a joint; 0 says nothing."""
    limit = joint.parts.get("limit", {})
    values = {}
    for name, text in limit.items():
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise DrawingError(
                f"{file}, line {joint.line}: {name} of {joint.name} is {text[:40]!r}, no number"
            )
    lower, upper = values.get("lower", 0.0), values.get("upper", 0.0)
    if joint.kind == "continuous":
        lower, upper = -math.inf, math.inf
    elif not lower < upper:
        raise DrawingError(
            f"{file}, line {joint.line}: the range of {joint.name} is empty "
            f"({lower:g} to {upper:g} rad)"
        )
    for name, (least, most, unit) in _DRIVEN.items():
        value = values.get(name, 0.0)
        if value and not least <= value <= most:
            raise DrawingError(
                f"{file}, line {joint.line}: {name} of {joint.name} is {value:g} {unit}, and of a "
                f"robot from {least:g} to {most:g} {unit}"
            )
    return lower, upper, values.get("velocity") or None, values.get("effort") or None


class _Reader:
    """The joints of a URDF, read by expat.

    Raises
    ------
    DrawingError
        It is no XML, has a document type, is too deep or too long, or names a joint twice.
    """

    def __init__(self, file: Path) -> None:
        self.joints: list[_Joint] = []
        self._file, self._path, self._count = file, [""] * 0, 0
        self._names: set[str] = set()
        self._parser = parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        try:
            parser.Parse("\n".join(read_lines(file)), True)
        except InfeasibleMotion as error:
            raise DrawingError(str(error)) from error
        except expat.ExpatError as error:
            what = expat.ErrorString(error.code)
            raise DrawingError(f"{file}, line {error.lineno}: it is no XML: {what}") from error
        if not self.joints:
            raise DrawingError(f"{file}: it has no joints: a URDF is meant, not a xacro or an SDF")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._path.append(tag)
        self._count += 1
        line = self._parser.CurrentLineNumber
        if len(self._path) > _DEEPEST or self._count > _MOST:
            raise DrawingError(
                f"{self._file}, line {line}: more than {_DEEPEST} elements deep or {_MOST} long"
            )
        is_kept = self._path == ["robot", "joint"]
        is_kept |= self._path == ["robot", "joint", tag] and tag in _KEPT
        long = [key for key, value in attributes.items() if len(value) > _LONGEST]
        if is_kept and long:
            raise DrawingError(
                f"{self._file}, line {line}: {long[0][:_LONGEST]} of {tag} has more than "
                f"{_LONGEST} characters"
            )
        if self._path == ["robot", "joint"]:
            name = attributes.get("name", "")
            if not name or name in self._names:
                raise DrawingError(f"{self._file}, line {line}: {name!r} is no joint's own name")
            if len(self.joints) == _MOST_JOINTS:
                raise DrawingError(f"{self._file}, line {line}: more than {_MOST_JOINTS} joints")
            self._names.add(name)
            self.joints.append(_Joint(name, attributes.get("type", ""), line))
        elif is_kept:
            self.joints[-1].parts[tag] = attributes

    def _end(self, tag: str) -> None:
        del tag
        self._path.pop()

    def _refuse_doctype(self, *_: object) -> None:
        line = self._parser.CurrentLineNumber
        raise DrawingError(
            f"{self._file}, line {line}: a URDF has no document type, and no entities"
        )
