"""An arm's hand without our kinematics: rotations by scipy, the Jacobian by finite differences."""

import math
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation as Turn


def hand_of(geometry, q):
    """Return the tool point (m) and the tool's rotation, link by link."""
    at = np.array([0.0, 0.0, geometry.base_height])
    turn = Turn.identity()
    links = (
        ("z", q[0], (geometry.a1, geometry.shoulder_offset, 0.0)),
        ("y", q[1], (0.0, 0.0, geometry.a2)),
        ("y", q[2], (geometry.elbow_offset, 0.0, geometry.a3)),
        ("z", q[3], (0.0, 0.0, 0.0)),
        ("y", geometry.wrist_sign * q[4], (0.0, 0.0, 0.0)),
        ("z", q[5], (0.0, 0.0, geometry.d6)),
    )
    for axis, angle, link in links:
        turn = turn * Turn.from_euler(axis, angle)
        at = at + turn.apply(link)
    return at, turn


def jacobian_of(geometry, q, step=1e-6):
    """Return J by central differences, shape (6, 6): velocity over angular velocity."""
    columns = []
    for joint in range(6):
        ahead, behind = np.array(q, float), np.array(q, float)
        ahead[joint] += step
        behind[joint] -= step
        (p1, r1), (p0, r0) = hand_of(geometry, ahead), hand_of(geometry, behind)
        columns.append(np.concatenate((p1 - p0, (r1 * r0.inv()).as_rotvec())) / (2.0 * step))
    return np.array(columns).T


def off_line(geometry, positions, twist):
    """Return how far the hand gets off the line of a twist (m) and the tool off its turn (rad)."""
    hands = [hand_of(geometry, q) for q in positions]
    gone = np.array([at - hands[0][0] for at, _ in hands])
    turns = [turn * hands[0][1].inv() for _, turn in hands]
    v, w = np.array(twist[:3]), np.array(twist[3:])
    if v.any():
        progress = gone @ v / (v @ v)
    else:
        steps = [(b * a.inv()).as_rotvec() @ w / (w @ w) for a, b in pairwise(turns)]
        progress = np.concatenate(([0.0], np.cumsum(steps)))
    away = np.linalg.norm(gone - np.outer(progress, v), axis=1).max()
    beside = max(
        (turn * Turn.from_rotvec(w * s).inv()).magnitude()
        for turn, s in zip(turns, progress, strict=True)
    )
    return float(away), float(beside), progress


def drawn_case(rng, geometry, number):
    """Return a posture at or beside a singularity and a twist through it.

    Of shoulder, elbow, wrist, two of them, all three, or none.
    """
    kind = ("wrist", "shoulder", "elbow", "two", "three", "none")[number % 6]
    miss = (0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)[number // 6 % 8]
    q = rng.uniform([-1, -1, 0.4, -2, -1.2, -2], [1, 1, 2, 2, 1.2, 2])
    if kind in ("wrist", "two", "three"):
        q[4] = miss
    if kind in ("elbow", "three"):
        q[2] = miss - geometry.elbow_angle
    if kind in ("shoulder", "two", "three"):
        elbow = q[2] + geometry.elbow_angle
        lean = math.atan2(
            geometry.forearm * math.sin(elbow),
            geometry.a2 + geometry.forearm * math.cos(elbow),
        )
        radius = math.hypot(
            geometry.a2 + geometry.forearm * math.cos(elbow), geometry.forearm * math.sin(elbow)
        )
        q[1] = math.asin((miss - geometry.a1) / radius) - lean
    way = rng.normal(size=3)
    twist = np.concatenate((way / np.linalg.norm(way) * rng.uniform(0.02, 0.3), np.zeros(3)))
    if rng.random() < 0.6:
        twist[3:] = rng.normal(size=3) * 0.4
    if rng.random() < 0.1:  # the tool turns and its point stays
        twist[:3] = 0.0
        twist[3:] = rng.normal(size=3) * 0.4
    return kind, tuple(q.tolist()), tuple(twist.tolist())
