"""Drawn arms and paths, and a judge of plans that shares no code with what it judges."""

import dataclasses
import math

import numpy as np

from controllers.arm.geometry import ArmGeometry
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.trajectory import ArmPath

SHARE = 1e-3
"""By which a promised limit may be passed."""
OFF_PATH = 1e-6
"""m."""
WIDE = {"position_min": (-20.0,) * 6, "position_max": (20.0,) * 6}


def turn(axis, angle):
    """Return a rotation about x, y or z."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    return matrix


def hand_of(geometry, q):
    """Return the tool point and its rotation: the arm's joints one after the other."""
    q1, q2, q3, q4, q5, q6 = q
    upper = turn("z", q1) @ turn("y", q2)
    fore = upper @ turn("y", q3)
    tool = fore @ turn("z", q4) @ turn("y", geometry.wrist_sign * q5) @ turn("z", q6)
    x, y, z = np.eye(3)
    at = geometry.base_height * z + turn("z", q1) @ (geometry.a1 * x + geometry.shoulder_offset * y)
    at = at + upper @ (geometry.a2 * z) + fore @ (geometry.a3 * z + geometry.elbow_offset * x)
    return at + tool @ (geometry.d6 * z), tool


def draw_geometry(rng):
    kind = rng.integers(4)
    if kind == 0:
        geometry = ArmGeometry()
    elif kind == 1:
        geometry = ArmGeometry(wrist_sign=-1)
    elif kind == 2:
        a = float(rng.uniform(0.25, 0.5))
        geometry = ArmGeometry(a2=a, a3=a, d6=float(rng.uniform(0.0, 0.2)))
    else:
        a2, a3, d6, height = rng.uniform((0.25, 0.25, 0.0, 0.0), (0.5, 0.5, 0.2, 0.4)).tolist()
        geometry = ArmGeometry(a2=a2, a3=a3, d6=d6, base_height=height)
    return dataclasses.replace(geometry, **WIDE) if rng.random() < 0.7 else geometry


def draw_offset_geometry(rng):
    """Return an arm whose shoulder, elbow or both are offset."""
    kind = rng.integers(4)
    sizes = rng.uniform((0.25, 0.25, 0.0, 0.0, -0.08), (0.6, 0.6, 0.2, 0.5, 0.08)).tolist()
    lengths = dict(zip(("a2", "a3", "d6", "base_height", "elbow_offset"), sizes, strict=True))
    if kind in (0, 2):
        lengths["a1"] = float(rng.uniform(-0.02, 0.18))
    if kind in (1, 2):
        lengths["shoulder_offset"] = float(rng.uniform(-0.18, 0.18))
    geometry = ArmGeometry(**lengths)
    return dataclasses.replace(geometry, **WIDE) if rng.random() < 0.7 else geometry


def _posture(rng):
    q = rng.uniform((-3, 0.2, 0.5, -3, -2.2, -3), (3, 1.4, 2.2, 3, 2.2, 3)).tolist()
    closeness = rng.choice([0.0, 0.0, 1e-9, 1e-5, 1e-3, 0.05, 1.0, 1.0, 1.0, 1.0])
    if closeness < 1.0:
        q[4] = float(closeness * rng.choice([-1, 1]))
    return tuple(q)


def _direction(rng, geometry, start):
    """Mostly outwards, so that the boundary is met."""
    at, _ = hand_of(dataclasses.replace(geometry, d6=0.0), start)
    out = at - np.array((0.0, 0.0, geometry.base_height))
    out = out / np.linalg.norm(out)
    return tuple((out + rng.uniform(0.0, 0.8) * rng.normal(size=3)).tolist())


def draw_path(rng, geometry):
    kind = rng.integers(5)
    speed, rate = float(10 ** rng.uniform(-1.5, -0.4)), float(rng.normal() * rng.choice([0, 0.3]))
    start = _posture(rng)
    axis = tuple(rng.normal(size=3).tolist())
    if kind == 0:
        direction = _direction(rng, geometry, start)
        return TurnBack(start=start, direction=direction, speed=speed, axis=axis, turn_rate=rate)
    if kind == 1:
        return DwellLine(
            start=start,
            direction=_direction(rng, geometry, start),
            speed=speed,
            depth=float(10 ** rng.uniform(-2.5, -0.9)),
            dwell=float(10 ** rng.uniform(-0.5, 1.0)),
        )
    if kind == 2:
        through = str(rng.choice(["elbow", "shoulder"]))
        return Circle(
            through,
            start,
            radius=float(rng.uniform(0.05, 0.3)),
            plane=float(rng.uniform(-1.5, 1.5)),
            side=int(rng.choice([-1, 1])),
            rate=float(10 ** rng.uniform(-0.7, 0.6)),
            begin=float(rng.uniform(-1.6, -0.3)),
            end=float(rng.uniform(0.3, 1.6)),
        )
    miss = float(rng.choice([0.0, 1e-12, 1e-6, 1e-3, 5e-3])) if kind == 3 else None
    return Line(
        middle=start,
        shoulder_distance=miss,
        direction=tuple(rng.normal(size=3).tolist()),
        before=float(rng.uniform(0.02, 0.2)),
        after=float(rng.uniform(0.02, 0.2)),
        speed=speed,
        axis=axis,
        turn_rate=rate,
    )


def faults_of(geometry, path, plan, rates, accelerations, *, keeps_path=True):
    """Return what is wrong with a plan.

    Parameters
    ----------
    geometry, path, plan
        What was planned for what.
    rates, accelerations : sequence of int
        Joints whose limits were promised.
    keeps_path : bool
        Whether the path was.
    """
    q, v, h = plan.positions, plan.velocities, plan.period
    if not (np.isfinite(q).all() and np.isfinite(v).all()):
        return ["not a number"]
    faults = []
    limits, hardest = np.array(geometry.rate_limits), np.array(geometry.acceleration_limits)
    steps, changes = np.abs(np.diff(q, axis=0)) / h, np.abs(np.diff(v[:-1], axis=0)) / h
    for j in rates:
        if max(np.abs(v[:, j]).max(), steps[:, j].max(initial=0.0)) > (1 + SHARE) * limits[j]:
            faults.append(f"rate of q{j + 1}")
    for j in accelerations:
        if changes[:, j].max(initial=0.0) > (1 + SHARE) * hardest[j]:
            faults.append(f"acceleration of q{j + 1}")
    hands = [hand_of(geometry, row) for row in q.tolist()]
    points = np.array([point for point, _ in hands])
    is_known = keeps_path and not isinstance(path, ArmPath)
    if is_known and _off(geometry, path, points, hands[0]).max() > OFF_PATH:
        faults.append("path")
    # The joints have to lead where their rates do: a jump of a position has no rate.
    jumps = np.abs(np.diff(q, axis=0) - 0.5 * h * (v[:-1] + v[1:]))[:-1]
    faults += [f"jump of q{j + 1}" for j in rates if jumps[:, j].max(initial=0) > h * limits[j]]
    return faults


def _off(geometry, path, points, first):
    """Return the distances of points from the line or the circle."""
    if isinstance(path, Circle):
        # Three of its points would do; the centre and the plane follow from its definition.
        q1, q2, q3, q4, q5, q6 = path.touch
        bent = math.atan2(geometry.elbow_offset, geometry.a3)
        fore = math.hypot(geometry.elbow_offset, geometry.a3)
        if path.through == "elbow":
            touch = (q1, q2, -bent, q4, q5, q6)
        else:
            x, z = (fore * part for part in (math.sin(q3 + bent), math.cos(q3 + bent)))
            lean = math.atan2(x, geometry.a2 + z)
            touch = (q1, -lean, q3, q4, q5, q6)
        hand, _ = hand_of(geometry, touch)
        wrist, _ = hand_of(dataclasses.replace(geometry, d6=0.0), touch)
        base = np.array((0.0, 0.0, geometry.base_height))
        if path.through == "elbow":
            out = (wrist - base) / np.linalg.norm(wrist - base)
            c, s = math.cos(path.plane), math.sin(path.plane)
            ahead = turn("z", q1) @ turn("y", q2) @ np.array((c, s, 0.0))
        else:
            out = np.array((math.sin(q1), -math.cos(q1), 0.0))
            ahead = np.array((math.cos(q1), math.sin(q1), 0.0))
        centre = hand - path.radius * out
        away = points - centre
        u, w = away @ ahead, away @ out
        normal = away - np.outer(u, ahead) - np.outer(w, out)
        return np.hypot(np.hypot(u, w) - path.radius, np.linalg.norm(normal, axis=1))
    direction = np.array(path.direction) / np.linalg.norm(path.direction)
    origin = first[0]
    if not isinstance(path, Line):
        origin, _ = hand_of(geometry, path.start)
    away = points - origin
    return np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
