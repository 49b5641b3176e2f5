"""Drawn Cartesian paths past and through singularities, under every kind of law.

    python tests/benchmarks/arm_paths.py 300 [--from SEED] [--ours] [--into FILE]

Near misses of 0 to 10 mm, exact hits, dwells and turn-backs, at shoulder, elbow, wrist or two of
them at once, on the paper's arm. A plan is judged by kinematics of the tests' own; the least time
of its curve under the same limits is a linear programme's, which shares nothing with the planner.
"""

import argparse
import dataclasses
import json
import math
import re
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog
from scipy.sparse import diags, vstack

sys.path.insert(0, str(Path(__file__).parents[1] / "unit" / "controllers" / "arm"))

from drawn_cases import WIDE, hand_of
from twist_oracle import off_line

from controllers.arm.esc import Esc, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import DwellLine, Line, TurnBack
from controllers.arm.plain import (
    DampedLeastSquares,
    DampedSettings,
    Inverse,
    InverseSettings,
    ServoHalt,
    ServoHaltSettings,
)
from controllers.motion import InfeasibleMotion

PERIOD = 5e-3
POINTS = 1200
ARM = ArmGeometry(**WIDE)
KINDS = (
    "shoulder missed", "wrist missed", "shoulder hit", "wrist hit", "wrist hit across",
    "turn-back", "turn-back, turning", "dwell", "wrist and shoulder", "wrist and elbow",
)  # fmt: skip
RIVALS = {
    "dls": (DampedLeastSquares, DampedSettings()),
    "servo-halt": (ServoHalt, ServoHaltSettings()),
    "inverse": (Inverse, InverseSettings()),
}


def draw(seed):
    """Return a path's kind and the path; it stays within the arm's reach by at least 20 mm."""
    rng = np.random.default_rng((300, seed))
    kind = KINDS[seed % len(KINDS)]
    while True:
        path = _draw(rng, kind)
        if not isinstance(path, Line) or _is_within_reach(path):
            return kind, path


def _draw(rng, kind):
    speed, miss = float(rng.uniform(0.05, 0.25)), float(rng.choice((1e-5, 1e-4, *[1e-2] * 6)))
    miss *= float(rng.uniform(0.01, 1.0))
    q1, q4, q6 = rng.uniform(-2.5, 2.5, 3).tolist()
    q3, q5 = float(rng.uniform(0.8, 2.0)), float(rng.choice((-1.0, 1.0)) * rng.uniform(0.5, 1.2))
    q2 = float(rng.uniform(0.2, 0.8))
    axis, rate = tuple(rng.normal(size=3).tolist()), float(rng.choice((0.0, rng.normal() * 0.2)))
    up = float(rng.uniform(-0.5, 0.5))
    across, ahead = (-math.sin(q1), math.cos(q1), up), (math.cos(q1), math.sin(q1), up)
    if kind == "turn-back":
        rate = 0.0
    if kind.startswith("turn-back") or kind in ("dwell", "wrist and elbow"):
        slow = 0.4 * speed
        out = (math.cos(q1), math.sin(q1), float(rng.uniform(-0.2, 0.4)))
        start = (q1, q2 + 0.2, q3, q4, q5, q6)
        if kind == "wrist and elbow":
            touch = (q1, float(rng.uniform(0.8, 1.2)), 0.0, 0.0, 0.0, q6)
            return TurnBack(touch=touch, direction=out, speed=slow, turn_rate=0.0, distance=0.15)
        if kind == "dwell":
            return DwellLine(
                start=start, direction=out, speed=slow, depth=0.03, dwell=float(rng.uniform(1, 5))
            )
        return TurnBack(
            start=start, direction=out, speed=slow, axis=axis, turn_rate=rate or 0.1 * (rate != 0)
        )
    distance = {"shoulder missed": miss, "shoulder hit": 0.0, "wrist and shoulder": miss}.get(kind)
    direction = across if distance else ahead
    if kind in ("wrist missed", "wrist and shoulder"):
        q5, direction = miss / ARM.d6, across if distance else tuple(rng.normal(size=3).tolist())
    if kind == "wrist hit":
        q4 = q5 = rate = 0.0
    if kind == "wrist hit across":
        q5, direction = 0.0, tuple(rng.normal(size=3).tolist())
    return Line(
        middle=(q1, q2, q3, q4, q5, q6), shoulder_distance=distance, direction=direction,
        before=float(rng.uniform(0.05, 0.15)), after=float(rng.uniform(0.05, 0.15)),
        speed=speed, axis=axis, turn_rate=rate,
    )  # fmt: skip


def _is_within_reach(path):
    """Return whether the wrist stays 20 mm inside the boundary, by the tests' own kinematics."""
    q1, q2, q3, q4, q5, q6 = path.middle
    if path.shoulder_distance is not None:
        lean = math.atan2(ARM.a3 * math.sin(q3), ARM.a2 + ARM.a3 * math.cos(q3))
        radius = math.hypot(ARM.a3 * math.sin(q3), ARM.a2 + ARM.a3 * math.cos(q3))
        q2 = math.asin(path.shoulder_distance / radius) - lean
    hand, tool = hand_of(ARM, (q1, q2, q3, q4, q5, q6))
    way = np.array(path.direction) / np.linalg.norm(path.direction)
    room = 2.0 * ARM.d6 if path.turn_rate else 0.0  # whichever way it turns
    for gone in np.linspace(-path.before, path.after, 40):
        wrist = hand + gone * way - ARM.d6 * tool[:, 2]
        if not 0.15 + room < np.linalg.norm(wrist) < ARM.reach - 0.02 - room:
            return False
    return True


def least_time(curve, path):
    """Return the least time along a curve of joints under rates and accelerations, s.

    The squares of speed at the curve's points are the unknowns of a linear programme: as they
    bound each other from above alone, the greatest sum of them is the fastest motion.

    Parameters
    ----------
    curve : ndarray, shape (n, 6)
        rad.
    path
        The hand and the tool go no faster along it than it says.
    """
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    keep = np.concatenate(([True], steps > 1e-9))
    q = curve[keep]
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))))
    grid = np.linspace(0.0, s[-1], POINTS)
    spline = CubicSpline(s, q)
    tangent, bend = spline(grid, 1), spline(grid, 2)
    rates, hardest = np.array(ARM.rate_limits), np.array(ARM.acceleration_limits)
    most = np.min((rates / np.maximum(np.abs(tangent), 1e-12)) ** 2, axis=1)
    step = grid[1]
    hands = [hand_of(ARM, row)[0] for row in spline(grid).tolist()]
    gone = np.linalg.norm(np.gradient(np.array(hands), grid, axis=0), axis=1)
    most = np.minimum(most, (path.speed / np.maximum(gone, 1e-12)) ** 2)
    # q'' = bend b + tangent b'/2 with b the square of the speed, at the middle of each step.
    rows, bounds = [], []
    n = len(grid)
    for j in range(6):
        t = 0.5 * (tangent[1:, j] + tangent[:-1, j]) / (2.0 * step)
        k = 0.5 * (bend[1:, j] + bend[:-1, j]) / 2.0
        row = diags([k - t, k + t], [0, 1], shape=(n - 1, n))
        rows += [row, -row]
        bounds += [np.full(n - 1, hardest[j])] * 2
    limits = np.column_stack((np.zeros(n), most))
    limits[0] = limits[-1] = 0.0
    found = linprog(-np.ones(n), vstack(rows).tocsr(), np.concatenate(bounds), bounds=limits)
    assert found.status == 0, found.message
    speed = np.sqrt(np.maximum(found.x, 0.0))
    return float(np.sum(2.0 * step / np.maximum(speed[1:] + speed[:-1], 1e-12)))


def off_path(path, plan):
    """Return how far the hand is off its line at most, m."""
    way = np.array(path.direction)
    return off_line(ARM, plan.positions.tolist(), (*way, 0.0, 0.0, 0.0))[0]


def judge(seed, rivals):
    """Return kind, outcome and what was measured of ours, and the outcomes of the rivals."""
    kind, path = draw(seed)
    dwells = isinstance(path, DwellLine)
    law = LookAhead(LookAheadSettings(), ARM, PERIOD)
    if dwells:  # time is what that law optimises
        law = Esc(EscSettings(from_rest=True), ARM, PERIOD)
    others = {name: rival(*RIVALS[name], path) for name in rivals}
    told = ""
    try:
        plan = law.prepare(path)
    except InfeasibleMotion as error:
        path = as_told(path, str(error))
        if path is None:
            return kind, str(error), {}, others
        plan, told = law.prepare(path), ", at the speed that its refusal names"
    shares = np.abs(np.diff(plan.positions, axis=0)).max(axis=0) / PERIOD / ARM.rate_limits
    rates = np.vstack((np.zeros(6), plan.velocities))  # from rest; the last row is at rest again
    change = np.abs(np.diff(rates, axis=0)).max(axis=0, initial=0.0) / PERIOD
    found = {
        "rate": float(shares.max()),
        "acceleration": float((change / ARM.acceleration_limits).max()),
        "off": off_path(path, plan),
    }
    if not dwells:
        found["optimum"] = plan.duration / least_time(plan.positions, path)
    return kind, plan.outcome + told, found, others


def as_told(path, refusal):
    """Return a dwell as its refusal says that it would fit; None if it does not say."""
    fits = re.search(r"at (\S+) m/s with a dwell of (\S+) s it would fit", refusal)
    if fits is None:
        return None
    speed, dwell = map(float, fits.groups())
    return dataclasses.replace(path, speed=speed, dwell=dwell)


def rival(law, settings, path):
    """Return how a rival does: ``done``, ``off by …``, ``over …``, ``halts`` or ``refused``."""
    if isinstance(path, DwellLine) and law is Inverse:
        return "refused"
    try:
        plan = law(settings, ARM, PERIOD).prepare(path)
    except (InfeasibleMotion, np.linalg.LinAlgError):
        return "refused"
    if plan.outcome != "done":
        return "halts"
    if (plan.peak_rates > 1.001 * np.array(ARM.rate_limits)).any():
        return "over a rate"
    return "off its path" if off_path(path, plan) > 1e-4 else "done"


def judged(count, first, rivals, file):
    """Yield what ``judge`` says of each seed; those in the file are read from it, others added."""
    known = {}
    if file is not None and file.exists():
        rows = [json.loads(line) for line in file.read_text("utf-8").splitlines()]
        known = {row[0]: row[1:] for row in rows}
    for seed in range(first, first + count):
        if seed not in known:
            known[seed] = judge(seed, rivals)
            if file is not None:
                with file.open("a", encoding="utf-8") as out:
                    out.write(json.dumps([seed, *known[seed]]) + "\n")
        yield known[seed]


def main():
    """Write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int)
    parser.add_argument("--from", dest="first", type=int, default=0)
    parser.add_argument("--ours", action="store_true", help="leave the rivals out")
    parser.add_argument("--into", type=Path, help="a file of results, to go on from")
    asked = parser.parse_args()
    outcomes, worst, rivals = defaultdict(Counter), defaultdict(float), defaultdict(Counter)
    names = () if asked.ours else RIVALS
    for kind, outcome, found, others in judged(asked.count, asked.first, names, asked.into):
        outcomes[kind][outcome] += 1
        for name, value in found.items():
            told = f"{name} (dwell)" if kind == "dwell" else name
            worst[told] = max(worst[told], value)
        for name, end in others.items():
            rivals[name][end] += 1
        if others:  # the planner that refuses what the plain inverse cannot do at the speed given
            rivals["refusing"]["done" if others["inverse"] == "done" else "refused"] += 1
    lines = [f"{kind:22} {dict(counts)}" for kind, counts in (outcomes | rivals).items()]
    lines += [f"{name:22} {value:.6g}" for name, value in worst.items()]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
