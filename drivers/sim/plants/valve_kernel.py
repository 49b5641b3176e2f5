"""Kernel of the antagonistic pair on proportional valves: a whole cycle of substeps per call."""

from collections.abc import Callable

from drivers.sim.plants.channel import move_piston, step_supply
from drivers.sim.plants.compiled import Record, cached_kernel, inlined
from drivers.sim.plants.pair_kernel import step_carriage
from drivers.sim.plants.pneumatics import ATMOSPHERE, mass_flow, step_pressure
from drivers.sim.plants.spool import spool_flows, step_spool


@inlined
def step_valve_channel(
    state: Record,
    p: Record,
    queue: Record,
    supply: float,
    stretch: float,
    rate: float,
    dt: float,
) -> None:
    """Step one channel: forces at the old position, then speed, air and position.

    Parameters
    ----------
    state, p : record
        `drivers.sim.plants.channel.STATE`, changed in place, and `SPOOL_PARAMETERS`.
    queue : ndarray
        Signals on their way to the spool, one per step of the dead time.
    supply : float
        Supply pressure, Pa absolute.
    stretch, rate : float
        Of the channel's wire, m and m/s.
    dt : float
        s.
    """
    step_spool(state, p, queue, dt)
    inflow, outflow = spool_flows(state, p, supply)
    if state.leak > 0.0:
        outflow += mass_flow(state.leak, p.ratio_out, state.pressure, ATMOSPHERE)
    move_piston(state, p, stretch, rate, dt)
    volume = p.dead_volume + p.area * (p.stroke - state.extension)
    new_volume = volume - p.area * state.speed * dt
    state.pressure = step_pressure(state.pressure, volume, new_volume, inflow, outflow, dt)
    shown = state.pressure - ATMOSPHERE
    state.monitor += (shown - state.monitor) * dt / (p.monitor_time + dt)
    state.extension += dt * state.speed


def _build(sources: int) -> Callable[..., None]:
    def advance_valve_pair(
        channels: Record,
        parameters: Record,
        queues: Record,
        pairs: Record,
        pair_parameters: Record,
        steps: int,
        dt: float,
    ) -> None:
        digest = sources  # noqa: F841 - makes the sources part of the cache key
        agonist, antagonist = channels[0], channels[1]
        first, second = parameters[0], parameters[1]
        pair, q = pairs[0], pair_parameters[0]
        for _ in range(steps):
            step_supply(pair, q, agonist.drawn + antagonist.drawn, dt)
            stretch_a = q.home - agonist.extension - pair.position
            stretch_b = q.home - antagonist.extension + pair.position
            rate_a = -agonist.speed - pair.speed
            rate_b = -antagonist.speed + pair.speed
            step_valve_channel(agonist, first, queues[0], pair.supply, stretch_a, rate_a, dt)
            step_valve_channel(antagonist, second, queues[1], pair.supply, stretch_b, rate_b, dt)
            step_carriage(pair, q, agonist.tension, antagonist.tension, dt)

    return advance_valve_pair


advance_valve_pair: Callable[..., None] = cached_kernel(_build)
"""Integrate a pair on valves; see `drivers.sim.plants.pair_kernel.advance_pair`."""
