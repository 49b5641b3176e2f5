"""Margins of the loop that a pair's law closes, on the linear part of a pair.

A law is linearised as it runs, about a steady motion: its own step is differentiated with respect
to everything that it remembers. The pair is a mass with viscous friction behind regulators of
second order with a dead time, and a law sees them through their monitors. Coulomb friction is left
out: it damps, so a loop that is stable here is so with any seals, and one that is not lives on its
friction.

References
----------
K. J. Åström, R. M. Murray, "Feedback systems", 2nd ed., 2021, section 10.3: phase margin, delay
margin and greatest sensitivity.
"""

import copy
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.cylinder.law import AnyPairLaw
from controllers.cylinder.types import PairModel, PairReference, PairState

_SPEED = 20e-3
"""Of the steady motion, m/s: the seals slide."""
_WARM = 400
"""Cycles until what a law remembers has settled on that motion."""
_SHARE = 1e-3
"""Of what a memory changes by in a cycle: by so much it is varied."""
_WIDTHS = (1e-8, 1e-1, 1e-8, 1e-6, 1e-4)
"""By so much what a law takes is varied: m and Pa as measured; m, m/s and m/s² of its reference."""
_POINTS = 1500
_QUICK = 1e-3
"""A monitor's filter is this part of a cycle at least: none at all, to rounding."""
_NO_GAIN = 1e-300
"""Of a law that does nothing; its logarithm is a number."""

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Path = tuple[str, ...]


class LoopMargins(NamedTuple):
    """The distance of a loop from instability.

    Parameters
    ----------
    stable : bool
        Without Coulomb friction.
    crossover : float
        Greatest frequency at which the loop's gain is 1, rad/s; 0 if it never is.
    phase : float
        Least phase margin, rad; negative: of a loop that is not stable.
    delay : float
        Dead time that the loop bears beyond the model's, s; 0: it is not stable as it is.
    sensitivity : float
        Greatest sensitivity: 1 over the least distance from -1.
    """

    stable: bool
    crossover: float
    phase: float
    delay: float
    sensitivity: float


class _Linear(NamedTuple):
    """``x' = a x + b y + e r``, ``u = c x + d y + f r`` of a law.

    y: position (m) and difference (Pa); r: position, velocity and acceleration of the reference.
    """

    a: Array
    b: Array
    c: Array
    d: Array
    e: Array
    f: Array


def loop_margins(law: AnyPairLaw, model: PairModel) -> LoopMargins:
    """Return the margins of the loop that a law closes around a pair as the model says it is.

    Parameters
    ----------
    law : PairLaw
        It is not changed.
    model : PairModel
        The pair.
    """
    return margins_around(law, (model,))[0]


def margins_around(law: AnyPairLaw, models: Sequence[PairModel]) -> tuple[LoopMargins, ...]:
    """Return the margins of the loop that a law closes around each of some pairs.

    Parameters
    ----------
    law : PairLaw
        It is linearised about a motion of the first one; it is not changed.
    models : sequence of PairModel
        The pairs.
    """
    linear = _linearise(law, models[0])
    return tuple(_margins(linear, _Pair(model, law.period), law.period) for model in models)


def reference_response(law: AnyPairLaw, model: PairModel, frequencies: Array) -> Complex:
    """Return what becomes of sines in the linear loop: the reading over the reference.

    Parameters
    ----------
    law : PairLaw
        It is not changed.
    model : PairModel
        The pair, without its Coulomb friction.
    frequencies : ndarray, shape (n,)
        Hz.

    Returns
    -------
    ndarray of complex, shape (n,)
        Meaningful where the loop is stable; see `loop_margins`.
    """
    linear, pair = _linearise(law, model, asked=True), _Pair(model, law.period)
    w = 2.0 * math.pi * frequencies
    z = np.exp(1j * w * law.period)
    asked: Complex = np.column_stack([np.ones_like(w), 1j * w, -w * w])
    fed = _solve(z, linear.a, np.asarray(asked @ linear.e.T)) @ linear.c + asked @ linear.f
    return np.asarray(pair.seen(z)[:, 0] * fed / (1.0 + pair.loop(linear, z)))


def measured_loop(law: AnyPairLaw, frequencies: Array, seen: Complex) -> Complex:
    """Return the response of the loop of a law around a pair that was measured.

    Parameters
    ----------
    law : PairLaw
        It is not changed.
    frequencies : ndarray, shape (n,)
        Hz.
    seen : ndarray of complex, shape (n, 2)
        What a law reads of the position (m) and of the pressures' difference (Pa) in the cycle in
        which it sends a difference of the setpoints of 1 Pa.

    Returns
    -------
    ndarray of complex, shape (n,)
        Broken at the setpoints; -1 is the critical point.
    """
    linear = _linearise(law, law.model)
    z = np.exp(2j * math.pi * frequencies * law.period)
    return _around(linear, z, seen)


def modelled_loop(law: AnyPairLaw, model: PairModel, frequencies: Array) -> Complex:
    """Return what `measured_loop` would be if a pair were as the model says."""
    z = np.exp(2j * math.pi * frequencies * law.period)
    return _around(_linearise(law, model), z, _Pair(model, law.period).seen(z))


def _around(law: _Linear, z: Complex, seen: Complex) -> Complex:
    inner = _solve(z, law.a, seen @ law.b.T)
    return np.asarray(-(inner @ law.c + seen @ law.d))


def _margins(linear: _Linear, pair: "_Pair", period: float) -> LoopMargins:
    closed = pair.closed(linear)
    stable = bool(np.max(np.abs(np.linalg.eigvals(closed))) < 1.0)
    w = np.geomspace(1.0, 0.999 * math.pi / period, _POINTS)
    loop = pair.loop(linear, np.exp(1j * w * period))
    sensitivity = float(np.max(1.0 / np.abs(1.0 + loop)))
    gain = np.log(np.maximum(np.abs(loop), _NO_GAIN))
    crossings = np.flatnonzero(gain[:-1] * gain[1:] < 0.0)
    if not len(crossings):
        return LoopMargins(stable, 0.0, math.pi, math.inf if stable else 0.0, sensitivity)
    share = gain[crossings] / (gain[crossings] - gain[crossings + 1])
    at = w[crossings] * (w[crossings + 1] / w[crossings]) ** share
    left = np.angle(-pair.loop(linear, np.exp(1j * at * period)))
    phase = float(left[np.argmin(np.abs(left))])
    delay = float(np.min(np.mod(left, 2.0 * math.pi) / at)) if stable else 0.0
    return LoopMargins(stable, float(at[-1]), abs(phase) if stable else -abs(phase), delay,
                       sensitivity)  # fmt: skip


class _Pair:
    """A pair in discrete time: regulators, mass, monitors, and the cycle that a reading is old."""

    def __init__(self, model: PairModel, period: float) -> None:
        w, z = model.regulator_bandwidth, model.regulator_damping
        # Difference of the pressures, its rate, position, velocity, difference as monitored.
        flow = np.zeros((5, 5))
        flow[0, 1] = flow[2, 3] = 1.0
        flow[1, :2] = -w * w, -2.0 * z * w
        flow[3, [0, 2, 3]] = model.area, -model.stiffness, -model.viscous
        flow[3] /= model.mass
        monitor = 1.0 / max(model.regulator_monitor_time, _QUICK * period)
        flow[4, 0], flow[4, 4] = monitor, -monitor
        push = np.array([0.0, w * w, 0.0, 0.0, 0.0])
        whole, part = divmod(model.air_dead_time / period, 1.0)
        self._late = int(whole)
        self._step, _ = _held(flow, push, period)
        settled, self._now = _held(flow, push, (1.0 - part) * period)
        self._before = settled @ _held(flow, push, part * period)[1]

    def loop(self, law: _Linear, z: Complex) -> Complex:
        """Return the frequency response, broken at the setpoint; -1 is the critical point."""
        return _around(law, z, self.seen(z))

    def seen(self, z: Complex) -> Complex:
        """Return what a law reads of the position and the difference, for a setpoint of 1."""
        late = z[:, None] ** self._late
        push = (self._now + self._before / z[:, None]) / late
        moved = _solve(z, self._step, push)
        return np.asarray(moved[:, [2, 4]] / z[:, None])

    def closed(self, law: _Linear) -> Array:
        """Return the matrix of a cycle of the closed loop."""
        n, waiting = len(law.a), self._late + 1  # setpoints that have not acted yet
        size = 5 + 2 + waiting + n
        seen, queue, memory = slice(5, 7), 7, slice(7 + waiting, size)
        u = np.zeros(size)  # this cycle's setpoint from what is known
        u[seen], u[memory] = law.d, law.c
        setpoints = np.vstack([u, np.eye(size)[queue : queue + waiting]])  # the newest first
        matrix = np.zeros((size, size))
        matrix[:5, :5] = self._step
        matrix[:5] += np.outer(self._now, setpoints[self._late])
        matrix[:5] += np.outer(self._before, setpoints[self._late + 1])
        matrix[5, 2] = matrix[6, 4] = 1.0
        matrix[queue : queue + waiting] = setpoints[:waiting]
        matrix[memory, seen], matrix[memory, memory] = law.b, law.a
        return matrix


def _solve(z: Complex, matrix: Array, right: Complex) -> Complex:
    """Return the solutions x of ``(z - matrix) x = right``, one row for each z."""
    systems = z[:, None, None] * np.eye(len(matrix)) - matrix
    return np.asarray(np.linalg.solve(systems, right[..., None])[..., 0])


def _held(flow: Array, push: Array, time: float) -> tuple[Array, Array]:
    """Return what a linear system comes to in a time, of its state and of a constant input."""
    from scipy.linalg import expm

    n = len(flow)
    both = np.zeros((n + 1, n + 1))
    both[:n, :n], both[:n, n] = flow, push
    come = expm(both * time)
    return come[:n, :n], come[:n, n]


def _linearise(law: AnyPairLaw, model: PairModel, *, asked: bool = False) -> _Linear:
    """Return a law's linear part about a steady motion; `asked`: memories of its reference, too."""
    fresh = type(law)(law.settings, model, law.period)
    motion = _Motion(fresh, model)
    for _ in range(_WARM):
        motion.step(fresh, 0.0, 0.0)
    changes = _changes(fresh, motion, asked=asked)
    paths = list(changes)
    at = np.array([_get(fresh, path) for path in paths])
    n = len(paths)
    found = np.zeros((n + 1, n + len(_WIDTHS)))
    widths = [*(_SHARE * changes[path] for path in paths), *_WIDTHS]
    for k, width in enumerate(widths):
        ends = []
        for side in (width, -width):
            other, then = copy.deepcopy((fresh, motion))
            if k < n:
                _set(other, paths[k], float(at[k]) + side)
            u = then.step(other, *(side if k == n + i else 0.0 for i in range(len(_WIDTHS))))
            ends.append(np.array([*(_get(other, path) for path in paths), u]))
        found[:, k] = (ends[0] - ends[1]) / (2.0 * width)
    y, r = slice(n, n + 2), slice(n + 2, None)
    return _Linear(
        found[:n, :n], found[:n, y], found[n, :n], found[n, y], found[:n, r], found[n, r]
    )


class _Motion:
    """A steady motion, followed exactly with the pressures that it takes."""

    def __init__(self, law: AnyPairLaw, model: PairModel) -> None:
        self._period = law.period
        self._base = model.base_pressure
        self._difference = (model.coulomb + model.viscous * _SPEED) / model.area
        self._t = 0.0
        law.reset(self._state(0.0, 0.0))

    def step(self, law: AnyPairLaw, position: float, difference: float, *asked: float) -> float:
        """Advance by a cycle, measured off by this much (m, Pa); return the setpoints' difference.

        A reading is a cycle old: so is the position that it shows. The reference is off by what is
        `asked` beside it: m, m/s, m/s².
        """
        self._t += self._period
        place, speed, turn = asked or (0.0, 0.0, 0.0)
        wanted = PairReference(_SPEED * self._t + place, _SPEED + speed, turn)
        first, second = law.update(self._state(position, difference), wanted)
        return first - second

    def _state(self, position: float, difference: float) -> PairState:
        half = 0.5 * (self._difference + difference)
        measured = _SPEED * (self._t - self._period) + position
        return PairState(self._t, measured, self._base + half, self._base - half)


def _changes(law: AnyPairLaw, motion: _Motion, *, asked: bool) -> dict[Path, float]:
    """Return by how much every number changes in a cycle that what is measured gets into.

    What changes by itself, as the phase of a dither, is no part of the loop; nor is what only the
    reference gets into, unless that is `asked` for.
    """
    other, then = copy.deepcopy((law, motion))
    alone, there = copy.deepcopy((law, motion))
    before = {path: _get(other, path) for path in _numbers(other)}
    changes = dict.fromkeys(before, 0.0)
    reached = set()
    for k in range(1, 9):
        reference = (1e-6 * math.cos(2.9 * k), 1e-4 * math.sin(1.3 * k), 1e-2 * math.cos(0.9 * k))
        measured = 1e-6 * math.sin(2.3 * k), 1e3 * math.cos(1.7 * k)
        then.step(other, *measured, *(reference if asked else ()))
        there.step(alone, 0.0, 0.0)
        for path, was in before.items():
            now = _get(other, path)
            changes[path] = max(changes[path], abs(now - was))
            before[path] = now
            if now != _get(alone, path):
                reached.add(path)
    return {path: changes[path] for path in changes if path in reached}


def _numbers(item: object, path: Path = ()) -> Iterator[Path]:
    for name, value in getattr(item, "__dict__", {}).items():
        if isinstance(value, float):
            yield (*path, name)
        elif hasattr(value, "__dict__") and not isinstance(value, type) and not callable(value):
            yield from _numbers(value, (*path, name))


def _get(item: object, path: Path) -> float:
    for name in path:
        item = getattr(item, name)
    assert isinstance(item, float)
    return item


def _set(item: object, path: Path, value: float) -> None:
    for name in path[:-1]:
        item = getattr(item, name)
    setattr(item, path[-1], value)
