"""Whether what a refusal of a walk or a squat says is true, by `gait_oracle`."""

import math
import re
from dataclasses import replace

import numpy as np
from gait_oracle import FINE, Curve, hip_height, joints_of, stages_of

from controllers.gait.geometry import AXIS_NAMES
from controllers.motion import InfeasibleMotion

OF_LAWS = 0.02
"""By which a time that is said to be needed may be more than the least, relative."""
_NUMBER = r"(-?[\d.]+(?:e[+-]?\d+)?)"


def false_claim(message, motion, law, geometry, period):
    """Return what is not true of a refusal; empty if all of it is.

    Parameters
    ----------
    message : str
        Of the refusal.
    motion
        A walk or a squat.
    law : GaitLaw
        That refused it.
    geometry : LegGeometry
        Of the legs.
    period : float
        s.
    """
    message, _, times = message.partition(" With ")
    wrong = times and _of_times(times, motion, law)
    if wrong:
        return wrong
    for pattern, check in _CLAIMS.items():
        found = re.fullmatch(pattern.replace("#", _NUMBER), message)
        if found:
            return check(found.groups(), motion, law, geometry, period)
    return f"nobody knows how to judge: {message}"


def _of_times(said, motion, law):
    """Judge "# at # s instead of # s … the whole motion would fit", by doing it in one go."""
    times = re.findall(r"(\w+) at ([\d.e+-]+) s instead of ([\d.e+-]+) s", said)
    if not times or not all(_near(old, getattr(motion, key)) for key, _, old in times):
        return "the times that were asked for"
    longer = replace(motion, **{key: float(new) for key, new, _ in times})
    fits = said.endswith("the whole motion would fit.")
    try:
        law.prepare(longer)
    except InfeasibleMotion as error:
        wrong = fits or "it would be refused, too: " not in said
        return f"with these times: {error}" if wrong else ""
    return "" if fits else "with these times it would not be refused"


def _stage(name, motion, geometry, period):
    """Return a stage whose time is a number of periods."""
    elapsed = first = 0.0
    for stage in stages_of(motion, geometry):
        elapsed += stage.duration
        last = round(elapsed / period) * period
        if stage.name == name:
            return stage._replace(duration=last - first)
        first = last
    raise AssertionError(f"there is no {name}")


def _near(said, true, share=2e-3):
    return abs(float(said) - true) <= share * abs(true) + 1e-12


def _of_reach(said, motion, law, geometry, period):
    name, percent, distance, least, most = said
    if not (
        _near(least, 1e3 * abs(geometry.thigh - geometry.shank), 1e-5)
        and _near(most, 1e3 * (geometry.thigh + geometry.shank), 1e-5)
    ):
        return "the reach"
    stage = _stage(name, motion, geometry, period)
    about = np.clip(float(percent) / 100.0 + np.linspace(-6e-4, 6e-4, 200), 0.0, 1.0)
    there = 1e3 * np.linalg.norm(stage.hips(about), axis=2)
    away = np.abs(there - float(distance)).min(axis=0).min()
    if away > 2e-3:
        return f"the distance, by {away:.4f} mm"
    if float(least) <= float(distance) <= float(most):
        return "it is within reach"
    return ""


def _of_smooth(said, motion, law, geometry, period):
    name, rate, acceleration, needed, has = said
    stage = _stage(name, motion, geometry, period)
    if not (_near(rate, geometry.max_rate) and _near(has, stage.duration)):
        return "what was asked for"
    if not _near(acceleration, law.settings.acceleration * motion.speed**2):
        return "the bound of accelerations"
    curve = Curve(geometry, stage)
    # A bob's curvature jumps: between two points much may be hidden.
    for points in (700, 3000, 9000):
        least = curve.least_time(float(rate), float(acceleration), points)
        if (1.0 - 5e-3) * least <= float(needed) <= (1.0 + OF_LAWS) * least:
            break
    else:
        return f"{needed} s are said to be needed, {least:.4f} are"
    return "" if stage.duration < float(needed) else "there is time enough"


def _of_trapezoid(said, motion, law, geometry, period):
    name, norm, limit, needed, has = said
    stage = _stage(name, motion, geometry, period)
    curve, ramp = Curve(geometry, stage), law.settings.ramp / motion.speed
    peak, top = curve.trapezoid_peak(stage.duration, ramp)
    if not (_near(has, stage.duration) and _near(norm, top)):
        return f"a norm of {top:.4f} rad/s"
    if peak <= geometry.max_rate:
        return f"it keeps the rates: {peak:.4f} rad/s"
    ramp = min(ramp, 0.5 * stage.duration)
    if not _near(needed, curve.length / float(limit) + ramp):
        return "the time that is needed"
    eased, _ = curve.trapezoid_peak(float(needed), ramp)
    return "" if _near(geometry.max_rate, eased, 5e-3) else f"then {eased:.4f} rad/s"


def _of_norm(said, motion, law, geometry, period):
    name, length, needed, norm, has = said
    curve = Curve(geometry, stage := _stage(name, motion, geometry, period))
    if not (_near(length, curve.length) and _near(has, stage.duration)):
        return f"a curve of {curve.length:.4f} rad in {stage.duration:.4f} s"
    means = [
        Curve(geometry, _stage(each.name, motion, geometry, period)).length
        / _stage(each.name, motion, geometry, period).duration
        for each in stages_of(motion, geometry)
    ]
    bound = min(law.settings.norm_factor * max(means), geometry.max_rate / curve.shares.max())
    if not (_near(norm, bound) and _near(needed, curve.length / bound)):
        return f"a norm of {bound:.4f} rad/s"
    return "" if stage.duration <= float(needed) * (1.0 + 1e-4) else "there is time enough"


def _peak_of_jerk(motion, geometry, period):
    """Return the greatest mean rate over a period under minimum jerk, rad/s."""
    peak = 0.0
    for each in stages_of(motion, geometry):
        stage = _stage(each.name, motion, geometry, period)
        share = np.linspace(0.0, 1.0, round(stage.duration / period) + 1)
        xi = 10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5
        # Along the length of the way, of the leg that goes farther.
        fine = np.linspace(0.0, 1.0, FINE)
        ways = np.linalg.norm(np.diff(stage.hips(fine), axis=0), axis=2).sum(axis=0)
        steps = np.linalg.norm(np.diff(stage.hips(fine), axis=0), axis=2)[:, int(ways.argmax())]
        gone = np.concatenate(([0.0], np.cumsum(steps)))
        q = joints_of(geometry, stage.hips(np.interp(xi * gone[-1], gone, fine)))
        peak = max(peak, np.abs(np.diff(q, axis=0)).max() / period)
    return float(peak)


def _of_slower(said, motion, law):
    """Judge "at a speed of # instead of # it would fit", and that it would be refused, too."""
    slower, speed = said
    if speed is not None and not _near(speed, motion.speed):
        return "the speed"
    if not float(slower) < motion.speed:
        return "it is no slower"
    try:
        law.prepare(replace(motion, speed=float(slower)))
    except InfeasibleMotion as error:
        return "" if speed is None else f"at {slower}: {error}"
    if speed is None:
        return "it is not refused"
    if 1.01 * float(slower) < motion.speed:
        try:
            law.prepare(replace(motion, speed=1.01 * float(slower)))
        except InfeasibleMotion:
            return ""
        return f"more than {slower} would fit, too"
    return ""


def _of_other_speeds(said, motion, law):
    fits, instead, refused = said
    if fits is not None:
        return _of_slower((fits, instead), motion, law)
    return "" if refused is None else _of_slower((refused, None), motion, law)


def _of_rates(said, motion, law, geometry, period):
    _, _, joint, worst, limit, *others = said
    if not (_near(limit, geometry.max_rate) and joint in AXIS_NAMES):
        return "the limit"
    wrong = _of_other_speeds(others, motion, law)
    if wrong:
        return wrong
    if law.name != "min-jerk":
        return "" if float(worst) > float(limit) else "it is within its limit"
    peak = _peak_of_jerk(motion, geometry, period)
    return "" if _near(worst, peak, 1e-2) else f"{peak:.4f} rad/s"


def _of_range(said, motion, law, geometry, period):
    _, name, joint, angle, low, high = said
    sign = -1 if joint.startswith("right") else 1
    number = AXIS_NAMES.index(joint)
    lowest, highest = geometry.min_angle[number % 6], geometry.max_angle[number % 6]
    if sign < 0 and geometry.mirror[number % 6] < 0:
        lowest, highest = -highest, -lowest
    if not (_near(low, math.degrees(lowest), 1e-4) and _near(high, math.degrees(highest), 1e-4)):
        return "the range"
    stage = _stage(name, motion, geometry, period)
    angles = np.degrees(joints_of(geometry, stage.hips(np.linspace(0.0, 1.0, FINE)))[:, number])
    if np.abs(angles - float(angle)).min() > 0.05:
        return f"the joint goes from {angles.min():.3f} to {angles.max():.3f} deg"
    return "it is within" if float(low) <= float(angle) <= float(high) else ""


def _of_step(said, motion, law, geometry, period):
    step, aside, reach = map(float, said)
    right = (
        _near(step, 1e3 * motion.step)
        and _near(aside, 1e3 * motion.sway * geometry.hip_half_spacing)
        and _near(reach, 1e3 * (geometry.thigh + geometry.shank))
    )
    return "" if right and hip_height(motion, geometry) <= 0.0 else "the hips have a height"


def _of_bob(said, motion, law, geometry, period):
    knee, lower = map(float, said)
    own = stages_of(motion, geometry)
    bob = min(stage.bob for stage in own)
    right = _near(knee, math.degrees(motion.bob.support_knee)) and _near(lower, -1e3 * bob, 1e-2)
    return "" if right and bob <= 0.0 else f"it rises by {bob * 1e3:.4f} mm"


def _of_balance(said, motion, law, geometry, period):
    name, what, margin, side, bound, *others = said[1:]
    margin = float(margin) if side == "inside" else -float(margin)
    wrong = _of_other_speeds(others, motion, law)
    if wrong:
        return wrong
    if not _near(bound, 1e3 * law.model.balance.min_margin):
        return "the bound"
    if what == "zero-moment point":  # of the timing; that the feet bear the robot is elsewhere
        return "" if margin < float(bound) else "it is within"
    own = 1e3 * static_margin(geometry, motion, name, period)
    return "" if abs(own - margin) < 0.2 else f"{own:.2f} mm"


def static_margin(geometry, motion, name, period):
    """Return the least distance of the centre of mass from the support's edge in a stage, m."""
    stage = _stage(name, motion, geometry, period)
    hips = stage.hips(np.linspace(0.0, 1.0, 2000))
    q, m = joints_of(geometry, hips), geometry.masses
    stands = stage.standing.index(True)
    ankle = -hips + np.array(
        ((0, -geometry.hip_half_spacing, 0), (0, geometry.hip_half_spacing, 0))
    )
    # Everything from the waist: links are at shares of straight thighs and shanks.
    body = np.array((m.upper_body_forward, 0.0, m.upper_body_height))
    moment = np.tile(m.upper_body * body, (len(q), 1))
    for leg in (0, 1):
        hip = np.array((0.0, (-1, 1)[leg] * geometry.hip_half_spacing, 0.0))
        roll, pitch = q[:, 6 * leg + 1], q[:, 6 * leg + 2]
        down = -np.column_stack(
            (np.sin(pitch), -np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch))
        )
        knee = hip + geometry.thigh * down
        foot = ankle[:, leg] - np.array((0.0, 0.0, m.foot_depth))
        moment += (m.hip_yaw + m.hip_roll) * hip
        moment += m.thigh * (hip + m.thigh_centre * (knee - hip))
        moment += m.shank * (knee + m.shank_centre * (ankle[:, leg] - knee))
        moment += m.ankle * ankle[:, leg] + m.foot * foot
    leg_mass = m.hip_yaw + m.hip_roll + m.thigh + m.shank + m.ankle + m.foot
    centre = moment / (m.upper_body + 2.0 * leg_mass)
    seen = centre - ankle[:, stands]
    sole = geometry.sole
    if all(stage.standing):  # the feet stand side by side or one ahead: the hull of both soles
        return _hull_margin(sole, centre, ankle)
    inside = (sole.front - seen[:, 0], seen[:, 0] + sole.back, sole.half_width - abs(seen[:, 1]))
    return float(np.min(inside))


def _hull_margin(sole, centre, ankle):
    from scipy.spatial import ConvexHull

    corners = [
        (x, y) for x in (-sole.back, sole.front) for y in (-sole.half_width, sole.half_width)
    ]
    worst = math.inf
    for k in range(0, len(centre), 20):
        points = [at[:2] + corner for at in ankle[k] for corner in corners]
        planes = ConvexHull(points).equations
        worst = min(worst, float(-(planes[:, :2] @ centre[k, :2] + planes[:, 2]).max()))
    return worst


def _of_periods(said, motion, law, geometry, period):
    name, has, step = said
    stage = next(each for each in stages_of(motion, geometry) if each.name == name)
    right = _near(has, stage.duration) and _near(step, period)
    return "" if right and stage.duration < 2.5 * period else "it is long enough"


_OTHER_SPEEDS = (
    r"(?:; at a speed of # instead of # it would fit|; at a speed of # it would be refused, too: .*"
    r"|; no speed was found at which it would fit)?\."
)
_CLAIMS = {
    r"(.+), # % of the way: the hip would be # mm from the ankle; the leg reaches # … # mm\.":
        _of_reach,
    r"(.+): with no joint faster than # rad/s nor accelerated by more than # rad/s\^2 the phase "
    r"needs at least # s instead of # s\.": _of_smooth,
    r"(.+): the joint rates would reach a norm of # rad/s, at which one joint passes its limit "
    r"\(# rad/s\); the phase needs at least # s instead of # s\.": _of_trapezoid,
    r"(.+): the joints' curve of # rad takes # s at a norm of # rad/s, but the phase lasts # s\.":
        _of_norm,
    r"at # s \((.+)\) (\w+) would need # rad/s, beyond its limit of # rad/s" + _OTHER_SPEEDS:
        _of_rates,
    r"at # s \((.+)\) (\w+) would be at # deg, outside # … # deg\.": _of_range,
    r"a step of # mm with # mm of sway is out of the reach of a leg of # mm\.": _of_step,
    r"bob: a support knee of # deg would lower the waist by # mm; it is straighter without\.":
        _of_bob,
    r"at # s \((.+)\) the (centre of mass|zero-moment point) would be # mm (inside|outside) the "
    r"edge of the support; the bound is # mm inside"
    r"(?:, and slower it would be [\d.]+ mm (?:in|out)side the edge of the support at best)?"
    + _OTHER_SPEEDS:
        _of_balance,
    r"(.+) lasts # s: less than two periods of # s\.": _of_periods,
}  # fmt: skip
