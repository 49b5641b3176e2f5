"""An electro-pneumatic regulator: from the setpoint to the opening of its main valve.

The stages, in order: converter, play (hysteresis), bow (static linearity error), pilot stage
(second order with a rate limit), main valve (overlap, proportional, first order).
All pressures gauge, Pa.
"""

import math

from drivers.sim.plants.compiled import inlined


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
    return opening + (wanted - opening) * dt / (time_constant + dt)
