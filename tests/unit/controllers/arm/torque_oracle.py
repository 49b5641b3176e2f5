"""What the drives of an arm need, and how fast a path can be under them: MuJoCo and an LP.

Neither shares anything with the planner but the drawing.
"""

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog
from scipy.sparse import diags, vstack

POINTS = 700
_ROUNDS = 12


def document(geometry, dynamics, payload):
    """Return an arm of given centres and moments in MuJoCo's language."""
    axes = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", f"0 {geometry.wrist_sign} 0", "0 0 1")
    ends = (
        (geometry.a1, geometry.shoulder_offset, 0.0),
        (0.0, 0.0, geometry.a2),
        (geometry.elbow_offset, 0.0, geometry.a3),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    )
    places = ((0.0, 0.0, geometry.base_height), *ends)
    text = ""
    for axis, place, rotor, mass, centre, moments in zip(
        axes, places, dynamics.rotors, dynamics.masses, dynamics.centres, dynamics.moments,
        strict=True,
    ):  # fmt: skip
        text += f'<body pos="{numbers(place)}"><joint axis="{axis}" armature="{rotor}"/>'
        text += inertial(mass, centre, moments)
    hand = np.array((0.0, 0.0, geometry.d6)) + payload.centre
    text += f'<body pos="{numbers(hand)}">'
    text += inertial(payload.mass, (0.0, 0.0, 0.0), payload.moments) + "</body>"
    return (
        '<mujoco><compiler angle="radian" boundmass="1e-9" boundinertia="1e-12"/>'
        f'<option gravity="0 0 -9.80665"/><worldbody>{text}{"</body>" * 6}</worldbody></mujoco>'
    )


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def inertial(mass, centre, moments):
    return f'<inertial mass="{mass}" pos="{numbers(centre)}" diaginertia="{numbers(moments)}"/>'


class Needs:
    """Torques of an arm by MuJoCo's inverse dynamics, with friction of the tests' own."""

    def __init__(self, model, dynamics):
        self._model, self._data = model, mujoco.MjData(model)
        self._model.dof_damping[:] = self._model.dof_frictionloss[:] = 0.0
        self._model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.dry, self.viscous = np.array(dynamics.friction), np.array(dynamics.viscous)

    def moved(self, q, rates, accelerations):
        """Return the torques without friction, shape (n, 6)."""
        rows = []
        for row in zip(q, rates, accelerations, strict=True):
            self._data.qpos[:], self._data.qvel[:], self._data.qacc[:] = row
            mujoco.mj_inverse(self._model, self._data)
            rows.append(self._data.qfrc_inverse.copy())
        return np.array(rows)

    def of(self, q, rates, accelerations):
        """Return the torques."""
        rubbed = self.dry * np.sign(rates) + self.viscous * rates
        return self.moved(q, rates, accelerations) + rubbed


def halfway(plan):
    """Return joints, rates and accelerations halfway between a plan's samples."""
    q, v = plan.positions[:-1], plan.velocities[:-1]
    return 0.5 * (q[1:] + q[:-1]), 0.5 * (v[1:] + v[:-1]), np.diff(v, axis=0) / plan.period


def least_time(geometry, dynamics, needs, plan, hands, speed):
    """Return the least time along a plan's curve under rates, accelerations and torques, s.

    The unknowns of a linear programme are the squares of the speed; viscous friction, which goes
    with its root, is taken by its tangent at the solution before.

    Parameters
    ----------
    geometry, dynamics, needs
        Of the arm.
    plan : ArmPlan
        Its joints are the curve.
    hands : function
        From joints to the tool point.
    speed : float
        Of the hand at most, m/s.
    """
    steps = np.linalg.norm(np.diff(plan.positions, axis=0), axis=1)
    q = plan.positions[np.concatenate(([True], steps > 1e-9))]
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))))
    spline, grid = CubicSpline(s, q), np.linspace(0.0, s[-1], POINTS)
    step = grid[1]
    rates, hardest = np.array(geometry.rate_limits), np.array(geometry.acceleration_limits)
    most = np.min((rates / np.maximum(np.abs(spline(grid, 1)), 1e-12)) ** 2, axis=1)
    way = np.gradient(np.array([hands(row) for row in spline(grid).tolist()]), grid, axis=0)
    most = np.minimum(most, (speed / np.maximum(np.linalg.norm(way, axis=1), 1e-12)) ** 2)
    middle = 0.5 * (grid[1:] + grid[:-1])
    at, tangent, bend = (spline(middle, order) for order in range(3))
    still = np.zeros_like(at)
    weight = needs.moved(at, still, still)
    m, b = needs.moved(at, still, tangent) - weight, needs.moved(at, tangent, bend) - weight
    held = weight + needs.dry * np.sign(tangent)
    limits, x = np.array(dynamics.torque_limits), 0.05 * most  # slow enough for its tangent to hold
    for _ in range(_ROUNDS):
        root = np.sqrt(np.maximum(0.5 * (x[1:] + x[:-1]), 1e-4 * x.max()))[:, None]
        rubs = needs.viscous * tangent
        programme = [row(tangent[:, j], bend[:, j], step) for j in range(6)]
        bounds = [(hardest[j], hardest[j]) for j in range(6)]
        programme += [row(m[:, j], (b + 0.5 * rubs / root)[:, j], step) for j in range(6)]
        free = held + 0.5 * rubs * root
        bounds += [((limits - free)[:, j], (limits + free)[:, j]) for j in range(6)]
        x, before = solved(programme, bounds, most), x
        if np.abs(x - before).max() < 1e-4 * x.max():
            break
    root = np.sqrt(x)
    return float(np.sum(2.0 * step / np.maximum(root[1:] + root[:-1], 1e-12)))


def row(m, b, step):
    """Return a limit's row: m u + b x at the middle of each step, of x at its ends."""
    n = len(m)
    return diags([0.5 * b - m / (2.0 * step), 0.5 * b + m / (2.0 * step)], [0, 1], shape=(n, n + 1))


def solved(programme, bounds, most):
    n = len(most)
    upper, sides = [], []
    for matrix, (high, low) in zip(programme, bounds, strict=True):
        upper += [matrix, -matrix]
        sides += [np.broadcast_to(high, n - 1), np.broadcast_to(low, n - 1)]
    ends = np.column_stack((np.zeros(n), most))
    ends[0] = ends[-1] = 0.0
    found = linprog(-np.ones(n), vstack(upper).tocsr(), np.concatenate(sides), bounds=ends)
    assert found.status == 0, found.message
    return np.maximum(found.x, 0.0)
