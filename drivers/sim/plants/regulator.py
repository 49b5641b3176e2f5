"""An electro-pneumatic regulator: from the setpoint to the opening of its main valve.

The stages, in order: converter, sampled input and dead time, play (hysteresis, and an error that
each reversal draws anew), bow (static linearity error), pilot stage (second order with a rate
limit, or two switched valves), main valve (overlap, proportional, first order).
All pressures gauge, Pa.
"""

import math

from drivers.sim.plants.compiled import Record, inlined, vanish
from drivers.sim.plants.pneumatics import ATMOSPHERE, flow_function

_DRAW_FACTOR, _DRAW_MODULUS = 16807.0, 2147483647.0
"""Of the generator of Park and Miller, whose numbers floating-point numbers hold exactly
("Random number generators: good ones are hard to find", Comm. ACM 31(10), 1988)."""


def quantize(pressure: float, full_scale: float, codes: float) -> float:
    """Return what a converter with `codes` steps over full scale puts out, saturated.

    Plain Python, because it runs once per setpoint and not in the kernel.
    """
    share = pressure / full_scale
    if not 0.0 <= share <= 1.0:
        share = 0.0 if share < 0.0 else 1.0
    return math.floor(share * codes + 0.5) / codes * full_scale


@inlined
def follow_with_play(follower: float, leader: float, half_width: float) -> float:
    """Return where play leaves the follower: a hysteresis loop of twice `half_width`."""
    return min(max(follower, leader - half_width), leader + half_width)


@inlined
def delay_setpoint(state: Record, p: Record, queue: Record, dt: float) -> float:
    """Return the setpoint (Pa) that gets to the pilot stage in this step.

    The input is sampled with a period of its own; what was sampled waits for the dead time in
    `queue`, which holds one number per step.
    """
    if p.sampling > 0.0:
        state.until_sample -= dt
        if state.until_sample <= 0.0:
            state.until_sample += p.sampling
            state.sampled = state.setpoint
    else:
        state.sampled = state.setpoint
    if p.dead_steps < 1.0:
        return float(state.sampled)
    place = int(state.place)
    delayed = float(queue[place])
    queue[place] = state.sampled
    state.place = place + 1.0 if place + 1.0 < p.dead_steps else 0.0
    return delayed


@inlined
def draw_at_reversal(state: Record, p: Record, leader: float) -> float:
    """Return the error of this approach, Pa: drawn anew when play is taken up on the other side."""
    pushed = leader - state.play
    side = 1.0 if pushed > 0.5 * p.hysteresis else -1.0 if pushed < -0.5 * p.hysteresis else 0.0
    if side not in (0.0, state.side):
        state.side = side
        state.draw = _DRAW_FACTOR * state.draw % _DRAW_MODULUS
        state.error = p.repeatability * (2.0 * state.draw / _DRAW_MODULUS - 1.0)
    return float(state.error)


@inlined
def bow(pressure: float, full_scale: float, depth: float) -> float:
    """Return the bent static characteristic: exact at both ends, `depth` off in the middle.

    Parameters
    ----------
    pressure : float
        Ideal value, Pa gauge.
    full_scale : float
        Pa gauge.
    depth : float
        Deviation in the middle over full scale, signed.
    """
    share = pressure / full_scale
    return pressure + 4.0 * depth * full_scale * share * (1.0 - share)


@inlined
def step_pilot(
    pilot: float,
    rate: float,
    target: float,
    bandwidth: float,
    damping: float,
    rate_limit: float,
    dt: float,
) -> tuple[float, float]:
    """Return the pilot pressure (Pa) and its rate (Pa/s) after one step, semi-implicit."""
    pull = bandwidth * bandwidth * (target - pilot)
    new_rate = (rate + dt * pull) / (1.0 + dt * 2.0 * damping * bandwidth)
    new_rate = min(max(new_rate, -rate_limit), rate_limit)
    return pilot + dt * new_rate, new_rate


@inlined
def step_switched_pilot(state: Record, p: Record, target: float, supply: float, dt: float) -> None:
    """Step a pilot chamber between a feed and an exhaust valve that are open or shut.

    At the start of each period the error of the outlet's pressure decides which of the two opens
    in it, and for how long; within the window that hysteresis and sensitivity leave, neither does.
    Both valves choke, so it fills and empties at different speeds, which depend on its pressure.
    """
    outlet = state.outlet - ATMOSPHERE
    state.seen += (outlet - state.seen) * dt / (p.pilot_filter + dt)
    state.phase -= dt
    if state.phase <= 0.0:
        state.phase += p.pilot_period
        error = target - state.seen
        full = p.pilot_rate / p.bandwidth  # the error that keeps a valve open throughout
        state.duty = min(max(error / full, -1.0), 1.0) if abs(error) > p.dead_band else 0.0
    pilot = state.pilot + ATMOSPHERE
    rate = 0.0
    if p.pilot_period - state.phase < abs(state.duty) * p.pilot_period:
        if state.duty > 0.0:
            if supply > pilot:
                rate = p.pilot_rate * flow_function(pilot / supply, p.critical_ratio)
        elif pilot > ATMOSPHERE:
            share = pilot / supply if supply > pilot else 1.0
            rate = -p.pilot_rate * share * flow_function(ATMOSPHERE / pilot, p.critical_ratio)
    state.pilot_rate = rate
    state.pilot += dt * rate


@inlined
def step_opening(
    opening: float, error: float, dead_band: float, band: float, time_constant: float, dt: float
) -> float:
    """Return the main valve's opening after one step.

    Parameters
    ----------
    opening : float
        -1 (exhaust fully open) … 1 (supply fully open).
    error : float
        Pilot less chamber pressure, Pa.
    dead_band : float
        Half width of the overlap, Pa.
    band : float
        Error beyond the overlap that opens the valve fully, Pa.
    time_constant, dt : float
        s.
    """
    beyond = error - min(max(error, -dead_band), dead_band)
    wanted = min(max(beyond / band, -1.0), 1.0)
    return vanish(opening + (wanted - opening) * dt / (time_constant + dt))
