"""What a walk or a squat asks of the legs, by mathematics of the tests' own.

Written from the paper and from what the motions' docstrings say. Nothing of the inverse
kinematics, of the paths or of the time laws that are judged is used here.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog
from scipy.sparse import diags, vstack

from controllers.gait.motions import SquatSettings

FINE = 6000
"""Points of a phase's way."""


class Stage(NamedTuple):
    """A phase: its name, time (s), way of the hips from the ankles, and whether feet stand."""

    name: str
    duration: float
    start: np.ndarray
    travel: np.ndarray
    lift: np.ndarray
    bob: float
    share: float
    standing: tuple

    def hips(self, xi):
        """Return both hips from their ankles, shape (n, 2, 3), m."""
        at = self.start + xi[:, None, None] * self.travel
        at[..., 2] -= np.sin(math.pi * xi)[:, None] * self.lift
        if self.bob:
            s = np.minimum(np.minimum(xi, 1.0 - xi) / self.share, 1.0)
            at[..., 2] += self.bob * (3.0 * s**2 - 2.0 * s**3)[:, None]
        return at


def span(geometry, knee):
    """Return the distance of hip and ankle at a knee's angle, m."""
    a, b = geometry.thigh, geometry.shank
    return math.sqrt(a * a + b * b + 2.0 * a * b * math.cos(knee))


def hip_height(motion, geometry):
    """Return the square of the hips' height above the ankles, m²."""
    if motion.hip is not None:
        return motion.hip**2
    aside = motion.sway * geometry.hip_half_spacing
    return span(geometry, motion.knee_min) ** 2 - (motion.step + abs(motion.ahead)) ** 2 - aside**2


def stages_of(motion, geometry):
    """Return the phases of a walk or a squat."""
    half = np.array(((0.0, -geometry.hip_half_spacing, 0.0), (0.0, geometry.hip_half_spacing, 0.0)))
    nothing = np.zeros(2)
    if isinstance(motion, SquatSettings):
        top = np.array((0.0, 0.0, span(geometry, motion.knee_min)))
        deep = np.array((0.0, 0.0, motion.depth))
        time, both = motion.time / motion.speed, (True, True)
        ways = (("down", top, -deep), ("up", top - deep, deep))
        return [
            Stage(f"{name} {k + 1}", time, np.tile(at, (2, 1)), np.tile(way, (2, 1)), nothing,
                  0.0, 1.0, both)
            for k in range(motion.repeats)
            for name, at, way in ways
        ]  # fmt: skip
    high = math.sqrt(hip_height(motion, geometry))
    bob, share = 0.0, 1.0
    if motion.bob is not None:
        out = math.hypot(motion.sway * geometry.hip_half_spacing, motion.ahead)
        bob = math.sqrt(span(geometry, motion.bob.support_knee) ** 2 - out**2) - high
        share = motion.bob.share
    ankles, waist = half.copy(), np.array((motion.ahead, 0.0, high))
    swings = 0 if motion.first == "right" else 1
    found = []
    for number in range(motion.landings + 1):
        stands = 1 - swings
        over = np.array((ankles[stands, 0] + motion.ahead, motion.sway * half[stands, 1], high))
        time = (motion.shift_time if number else motion.first_shift_time) / motion.speed
        start, travel = waist + half - ankles, np.tile(over - waist, (2, 1))
        both = (True, True)
        found.append(Stage(f"shift {number}", time, start, travel, nothing, 0.0, 1.0, both))
        waist = over
        if number == motion.landings:
            break
        far = motion.step if number == 0 else 2.0 * motion.step
        travel, lift = np.zeros((2, 3)), np.zeros(2)
        travel[swings, 0], lift[swings] = -far, motion.lift
        name = f"swing {('right', 'left')[swings]} {number + 1}"
        time, start = motion.swing_time / motion.speed, waist + half - ankles
        alone = (bool(stands == 0), bool(stands == 1))
        found.append(Stage(name, time, start, travel, lift, bob, share, alone))
        ankles[swings, 0] += far
        swings = stands
    return found


def joints_of(geometry, hips):
    """Return the twelve joints under an upright waist over level feet, shape (n, 12), rad."""
    a, b = geometry.thigh, geometry.shank
    legs = []
    for x, y, z in np.moveaxis(hips, (1, 2), (0, 1)):
        high = np.hypot(y, z)
        beyond = np.maximum((a + b) ** 2 - x**2 - high**2, 0.0)
        knee = 2.0 * np.arcsin(np.sqrt(np.minimum(beyond / (4.0 * a * b), 1.0)))
        roll = np.arctan2(y, z)
        pitch = np.arctan2(-x, high) - np.arctan2(a * np.sin(knee), b + a * np.cos(knee))
        legs.append((0.0 * x, -roll, -knee - pitch, knee, pitch, roll))
    return np.concatenate(legs).T


class Curve:
    """The joints along a stage, over the length of their curve."""

    def __init__(self, geometry, stage):
        self.xi = np.sin(np.linspace(0.0, 0.5 * math.pi, FINE)) ** 2
        self.q = joints_of(geometry, stage.hips(self.xi))
        steps = np.diff(self.q, axis=0)
        sizes = np.linalg.norm(steps, axis=1)
        self.gone = np.concatenate(([0.0], np.cumsum(sizes)))
        self.length = float(self.gone[-1])
        self.shares = np.abs(steps).max(axis=1) / np.maximum(sizes, 1e-15)
        self.shares[sizes < 1e-12] = 0.0

    def trapezoid_peak(self, duration, ramp):
        """Return the greatest rate of a joint under a trapezoid of the norm, and its top, rad/s."""
        ramp = min(ramp, 0.5 * duration)
        top = self.length / (duration - ramp)
        middle = 0.5 * (self.gone[1:] + self.gone[:-1])
        nearer = np.minimum(middle, self.length - middle)
        slow = np.sqrt(2.0 * top * nearer / ramp) if ramp else math.inf
        return float((np.minimum(top, slow) * self.shares).max()), top

    def least_time(self, rate, acceleration, points):
        """Return the least time under bounds of each joint's rate and acceleration, s.

        A linear programme in the squares of the speed along the curve.
        """
        keep = np.concatenate(([True], np.diff(self.gone) > 1e-9))
        grid = np.linspace(0.0, self.length, points)
        spline = CubicSpline(self.gone[keep], self.q[keep])
        tangent, bend = spline(grid, 1), spline(grid, 2)
        tangent, bend = (
            part[:, np.abs(tangent).max(axis=0) > 1e-9] for part in (tangent, bend)
        )  # joints that move
        most = (rate / np.abs(tangent).max(axis=1)) ** 2
        most[0] = most[-1] = 0.0
        step, rows = grid[1], []
        for j in range(tangent.shape[1]):
            t = 0.5 * (tangent[1:, j] + tangent[:-1, j]) / (2.0 * step)
            k = 0.25 * (bend[1:, j] + bend[:-1, j])
            row = diags([k - t, k + t], [0, 1], shape=(points - 1, points))
            rows += [row, -row]
        bounds = np.full(len(rows) * (points - 1), acceleration)
        found = linprog(
            -np.ones(points), vstack(rows).tocsr(), bounds,
            bounds=np.column_stack((np.zeros(points), most)),
        )  # fmt: skip
        assert found.status == 0, found.message
        speed = np.sqrt(np.maximum(found.x, 0.0))
        return float(np.sum(2.0 * step / np.maximum(speed[1:] + speed[:-1], 1e-12)))


def off_way(geometry, motion, plan, soles):
    """Return how far the hips are off the motion's way, as the joints have it, m.

    Both legs are to be at one place of their ways, wherever the plan says that this is.

    Parameters
    ----------
    soles : ndarray, shape (n, 2, 3)
        Where the test's own kinematics put them under the planned waist.
    """
    worst = 0.0
    side = np.array(((0, -geometry.hip_half_spacing, 0), (0, geometry.hip_half_spacing, 0)))
    stages = stages_of(motion, geometry)
    for number, stage in enumerate(stages):
        during = plan.phase_number == number
        xi = np.clip(plan.path[during], 1e-7, 1.0 - 1e-7)
        seen = plan.waist[during][:, None] + side - soles[during]
        seen[..., 2] -= geometry.ankle_height
        off = (seen - stage.hips(xi)).reshape(-1, 6)
        along = ((stage.hips(xi + 1e-7) - stage.hips(xi - 1e-7)) / 2e-7).reshape(-1, 6)
        ahead = np.sum(off * along, axis=1) / np.sum(along * along, axis=1)
        worst = max(worst, float(np.abs(off - ahead[:, None] * along).max(initial=0.0)))
    return worst
