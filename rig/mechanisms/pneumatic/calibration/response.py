"""Response of the regulators: dead time, natural frequency and damping, from steps.

All chambers step up and down together, so nothing moves. To each step of the monitored pressure a
second order with a dead time is fitted,

    p(t) = p_0 + (p_1 - p_0) h(t - dead time),    h of  w^2 / (s^2 + 2 z w s + w^2),

and the repetitions tell how well it is known. Time counts from the cycle that sent the new
set-point, not from the plan: where in a cycle a plan has its step would else pass for scatter.
A first step up and down is not judged: it comes from wherever the regulator's hysteresis was left,
and those that follow come from where the one before has left it. Air fills faster than it leaves.
The middle of both directions is estimated, and its mean over the chambers is the bandwidth and the
damping in force. The dead time in force is the longest of any chamber and direction: a controller
has to bear it. Each direction has its own scatter, which often one of the two makes up alone: the
interval has the degrees of freedom that are left then (Welch and Satterthwaite), and not those of
two directions that scatter alike.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate, middle_of
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Panel, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile, format_quantity
from rig.mechanisms.pneumatic.calibration.pneumatics import PneumaticProcedure
from rig.mechanisms.pneumatic.calibration.pressure_steps import PressureSteps

REPEATS: Final = 16
_HEIGHT: Final = 40e3
_RAMP: Final = 1e-3
_DWELL: Final = 0.6
_LEAST: Final = 0.3
_BOUND: Final = 3e3


class Response(PneumaticProcedure):
    """Procedure for step response and dead time of the regulators."""

    name = "response"
    title = "step response and dead time of the regulators"

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the repetitions that are not done."""
        base = profile.mechanism_settings.base_pressure
        names: list[str] = []
        levels: list[float] = []
        for k in range(REPEATS):
            pair = [f"up {k + 1}", f"down {k + 1}"]
            if not all(name in done for name in pair):
                names += pair
                levels += [base + _HEIGHT, base]
        plan = PressureSteps(
            ("", "", *names), (base + _HEIGHT, base, *levels), ramp=_RAMP, dwell=_DWELL,
            judged=_DWELL + _RAMP,
        )  # fmt: skip
        return self._of(profile).together(plan, room=0.0, approach=1.0)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit every step of every channel."""
        channels = self._of(profile).channels
        base = profile.mechanism_settings.base_pressure
        sides = {side: [f"{side} {k + 1}" for k in range(REPEATS)] for side in ("up", "down")}
        data.require(name for names in sides.values() for name in names)
        estimates: list[Estimate] = []
        rests: list[Array] = []
        panels: list[Panel] = []
        means: list[Array] = []
        sides_found: dict[str, tuple[float, float]] = {}
        model = profile.mechanism_settings.regulator_response
        for channel in channels:
            found: dict[str, Array] = {}
            for side, names in sides.items():
                rows = []
                for number, name in enumerate(names):
                    part = data[name]
                    before = base if side == "up" else base + _HEIGHT
                    t = part["t"] - _sent(part["t"], part[f"applied.{channel}"], before)
                    pressure = part[f"reading.pressure_{channel}"]
                    q, fitted = _fit_step(channel, t, pressure)
                    rows.append(q[:3])
                    rests.append(pressure - fitted)
                    if number == 0:
                        known = _step(t, (model.bandwidth, model.damping, 1e-3, *q[3:]))
                        panels.append(_panel(f"{channel}, {side}", t, pressure, fitted, known))
                found[side] = np.array(rows)
            for index, (name, unit) in enumerate(
                (("bandwidth", "rad/s"), ("damping", "1"), ("dead_time", "s"))
            ):
                up, down = (rows[:, index].tolist() for rows in found.values())
                estimates.append(middle_of(f"{channel}.{name}", unit, up, down))
            means.append(np.array([e.value for e in estimates[-3:]]))
            for side, fits in found.items():
                sides_found[f"{channel} {side}"] = (
                    float(fits[:, 0].mean()),
                    float(fits[:, 2].mean()),
                )
        bandwidth, damping, _ = np.mean(means, axis=0)
        bandwidths, dead_times = np.transpose(list(sides_found.values()))
        # Of every chamber, whichever way its pressure goes.
        dead_time = float(f"{dead_times.max():.3g}")
        values = {
            "regulator_response": {
                "bandwidth": f"{bandwidth:.6g} rad/s",
                "damping": float(f"{damping:.6g}"),
                "dead_time": quantity(dead_time, "s"),
                "spread": float(f"{np.abs(bandwidths / bandwidth - 1.0).max():.3g}"),
            }
        }
        each = [f"{name} {format_quantity(dead, 's')}" for name, (_, dead) in sides_found.items()]
        reasons = {
            "regulator_response.bandwidth": "the mean of all chambers and both directions",
            "regulator_response.damping": "the mean of all chambers and both directions",
            "regulator_response.dead_time": (
                "the longest of all chambers and both directions, which a law has to bear "
                f"({', '.join(each)}); the estimates are the middle of both directions"
            ),
            "regulator_response.spread": (
                "by how much of the bandwidth the farthest chamber and direction is off it"
            ),
        }
        residuals = np.concatenate(rests)
        return (
            Finding(
                profile.mechanism,
                values,
                estimates,
                residuals,
                "Pa",
                _BOUND,
                2 * REPEATS,
                panels,
                reasons=reasons,
            ),
        )


def _sent(t: Array, setpoint: Array, before: float) -> float:
    """Return when a step of the set-point was sent, s: the mean of its parts if it has several."""
    parts = np.diff(setpoint, prepend=before)
    whole = setpoint[-1] - before
    return float(t @ parts / whole) if whole else float(t[0])


def _fit_step(channel: str, t: Array, pressure: Array) -> tuple[Array, Array]:
    from scipy.optimize import least_squares

    start, end = float(pressure[:5].mean()), float(pressure[-50:].mean())
    if abs(end - start) < _LEAST * _HEIGHT:
        raise CalibrationRefused(
            f"{channel}: the pressure moved by {abs(end - start) / 1e3:.3g} kPa at a step of "
            f"{_HEIGHT / 1e3:g} kPa: too little to tell a response; is the supply open?"
        )
    scale = end - start

    def residuals(q: Array) -> Array:
        return (
            pressure - _step(t, (q[0], q[1], q[2], start + q[3] * scale, end + q[4] * scale))
        ) / scale

    found = least_squares(
        residuals, (40.0, 1.0, 3e-3, 0.0, 0.0), x_scale=(10.0, 0.3, 3e-3, 0.01, 0.01),
        bounds=((5.0, 0.2, 0.0, -0.2, -0.2), (400.0, 3.0, 0.1, 0.2, 0.2)),
    )  # fmt: skip
    q = found.x
    whole = np.array([q[0], q[1], q[2], start + q[3] * scale, end + q[4] * scale])
    return whole, _step(t, whole)


def _step(t: Array, q: Sequence[float] | Array) -> Array:
    """Return the response to a step at 0, Pa."""
    w, z, dead, start, end = (float(x) for x in q)
    s = np.maximum(t - dead, 0.0)
    # One formula below and above critical damping, smooth through it: a fit that begins there
    # would not find its way out of a branch of its own.
    square = w * w * (z * z - 1.0)
    if abs(square) < 1e-8 * w * w:
        even, odd = 1.0 + 0.5 * square * s * s, s * (1.0 + square * s * s / 6.0)
    elif square < 0.0:
        rate = math.sqrt(-square)
        even, odd = np.cos(rate * s), np.sin(rate * s) / rate
    else:
        rate = math.sqrt(square)
        even, odd = np.cosh(rate * s), np.sinh(rate * s) / rate
    h = 1.0 - np.exp(-z * w * s) * (even + z * w * odd)
    return np.asarray(start + (end - start) * h)


def _panel(title: str, t: Array, y: Array, fitted: Array, before: Array) -> Panel:
    return Panel(
        title, "time (ms)", "monitor (kPa)", "residual (kPa)",
        1e3 * t, y / 1e3, fitted / 1e3, before / 1e3,
    )  # fmt: skip
