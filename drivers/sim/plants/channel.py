"""One channel: regulator, chamber, piston and wire. Any rig with pulling cylinders is n of these.

A channel's state and its parameters are one record each of a structured array, so that a kernel
reads ``channel.pressure`` and Python allocates nothing per step. The rig couples its channels:
it steps each one with the stretch of its wire and takes the tension from the record.

The main valve's overlap and its flow's shape make the regulator's small-signal gain uneven, as
in the real one: filling is faster than exhausting at low pressure.
"""

import numpy as np

from drivers.sim.plants.compiled import Record, inlined
from drivers.sim.plants.friction import bristle_damping, step_bristle, stribeck_force
from drivers.sim.plants.pneumatics import (
    ATMOSPHERE,
    COMPRESSION,
    EXHAUSTING,
    FILLING,
    GAS_CONSTANT,
    TEMPERATURE,
    mass_flow,
    step_pressure,
)
from drivers.sim.plants.regulator import (
    bow,
    delay_setpoint,
    draw_at_reversal,
    follow_with_play,
    step_opening,
    step_pilot,
    step_switched_pilot,
)
from drivers.sim.plants.tube import SEGMENTS, step_tube

WORKING = 0.0
STUCK = 1.0
"""The regulator holds the pressure that it had and follows no setpoint; a spool stands still."""
STUCK_OPEN = 2.0
"""The main valve stands open to the supply."""
STUCK_CLOSED = 3.0
"""The main valve is closed both ways: the chamber is locked."""

STATE = np.dtype(
    [
        ("setpoint", float),  # input, as the converter puts it out: Pa gauge, or an opening
        ("mode", float),  # input, one of the constants above
        ("leak", float),  # input, sonic conductance to the atmosphere, m³/(s Pa)
        ("play", float),  # behind the hysteresis, Pa gauge
        ("pilot", float),  # Pa gauge
        ("pilot_rate", float),  # Pa/s
        ("opening", float),  # main valve, -1 … 1
        ("pressure", float),  # chamber, Pa absolute
        ("extension", float),  # rod, m
        ("speed", float),  # of the extension, m/s
        ("bristle", float),  # of the seals, m
        ("friction", float),  # of the seals, N, against the extension's speed
        ("tension", float),  # of the wire, N
        ("drawn", float),  # out of the supply line, kg/s
        ("sampled", float),  # setpoint that the regulator has taken, Pa gauge
        ("until_sample", float),  # s
        ("place", float),  # where the setpoint's queue begins
        ("side", float),  # on which the play was taken up last
        ("draw", float),  # the last number drawn
        ("error", float),  # of this approach, Pa
        ("seen", float),  # outlet's pressure as the switched pilot sees it, Pa gauge
        ("phase", float),  # what remains of the switched pilot's period, s
        ("duty", float),  # of its feed valve; negative: of its exhaust valve
        ("outlet", float),  # between regulator and tube, Pa absolute
        ("flow_in", float),  # through the three segments of the tube, kg/s
        ("flow", float),
        ("flow_out", float),
        ("tube_first", float),  # between them, Pa absolute
        ("tube_second", float),
        ("monitor", float),  # behind the monitor's filter, Pa gauge
        ("opening_rate", float),  # of a spool, 1/s
    ]
)
"""State and inputs of a channel."""

PARAMETERS = np.dtype(
    [
        (name, float)
        for name in (
            "full_scale",
            "hysteresis",
            "bow",
            "bandwidth",
            "damping",
            "pilot_rate",
            "dead_band",
            "band",
            "valve_time",
            "conductance_in",
            "conductance_out",
            "critical_ratio",
            "area",
            "stroke",
            "dead_volume",
            "mass",
            "coulomb",
            "breakaway",
            "stribeck_velocity",
            "viscous",
            "pressure_friction",
            "bristle_stiffness",
            "bristle_damping",
            "stop_stiffness",
            "stop_damping",
            "wire_stiffness",
            "wire_damping",
            "dead_steps",  # dead time in steps of the plant
            "sampling",
            "repeatability",  # Pa
            "least",  # Pa gauge
            "switched",  # 1: two switched pilot valves, 0: a linear pilot stage
            "pilot_period",
            "pilot_filter",
            "monitor_time",
            "tube_length",
            "tube_push",  # `SegmentNumbers` of each of its segments
            "tube_drag",
            "tube_unit",
            "tube_rise",  # Pa/kg, of the air between two of them
            "tube_volume",
            "outlet_volume",
        )
    ]
)
"""Parameters of a channel in SI units; `hysteresis`, `dead_band` and `band` in Pa."""

_LEAST_FRICTION = 1e-6
"""Keeps the bristle equation defined without friction, N."""


@inlined
def wire_tension(stretch: float, rate: float, stiffness: float, damping: float) -> float:
    """Return the tension of a wire, N: a spring and damper that cannot push.

    Parameters
    ----------
    stretch : float
        Beyond its free length, m; slack if negative.
    rate : float
        Of the stretch, m/s.
    stiffness, damping : float
        N/m and N s/m.
    """
    if stretch <= 0.0:
        return 0.0
    return max(stiffness * stretch + damping * rate, 0.0)


@inlined
def step_regulator(state: Record, p: Record, queue: Record, supply: float, dt: float) -> None:
    """Step everything from the setpoint to the main valve's opening.

    The pilot stage is fed by the same supply, so it cannot rise above it: without supply the
    pilot pressure falls and the main valve exhausts the chamber.
    """
    setpoint = delay_setpoint(state, p, queue, dt)
    error = draw_at_reversal(state, p, setpoint) if p.repeatability > 0.0 else 0.0
    state.play = follow_with_play(state.play, setpoint, 0.5 * p.hysteresis)
    if state.mode == STUCK:
        state.pilot_rate = 0.0
    else:
        wanted = max(bow(state.play, p.full_scale, p.bow) + error, p.least)
        target = min(wanted, supply - ATMOSPHERE)
        if p.switched:
            step_switched_pilot(state, p, target, supply, dt)
        else:
            state.pilot, state.pilot_rate = step_pilot(
                state.pilot, state.pilot_rate, target, p.bandwidth, p.damping, p.pilot_rate, dt
            )
    state.pilot = max(min(state.pilot, supply - ATMOSPHERE), 0.0)
    if state.mode == STUCK_OPEN:
        state.opening = 1.0
    elif state.mode == STUCK_CLOSED:
        state.opening = 0.0
    else:
        off = state.pilot - (state.outlet - ATMOSPHERE)
        state.opening = step_opening(state.opening, off, p.dead_band, p.band, p.valve_time, dt)


@inlined
def step_supply(line: Record, q: Record, drawn: float, dt: float) -> None:
    """Step the supply line's pressure: it follows its source, and sags as air is drawn, kg/s."""
    line.supply += (line.supply_target - line.supply) * dt / (q.supply_time + dt)
    if q.supply_volume > 0.0:
        line.supply -= dt * GAS_CONSTANT * TEMPERATURE / q.supply_volume * drawn
        line.supply = max(line.supply, ATMOSPHERE)


@inlined
def valve_flows(state: Record, p: Record, downstream: float, supply: float) -> tuple[float, float]:
    """Return the mass flows (kg/s) through the main valve, into and out of what follows it."""
    if state.opening > 0.0:
        conductance = state.opening * p.conductance_in
        inflow = mass_flow(conductance, p.critical_ratio, supply, downstream)
        # A valve that stands open lets the chamber empty into a supply that was vented.
        back = mass_flow(conductance, p.critical_ratio, downstream, supply)
        state.drawn = inflow - back
        return inflow, back
    state.drawn = 0.0
    conductance = -state.opening * p.conductance_out
    return 0.0, mass_flow(conductance, p.critical_ratio, downstream, ATMOSPHERE)


@inlined
def step_chamber(state: Record, p: Record, supply: float, dt: float) -> None:
    """Step the chamber's pressure over the piston's motion of this step, and the tube's."""
    volume = p.dead_volume + p.area * (p.stroke - state.extension)
    outflow = 0.0
    if state.leak > 0.0:
        outflow = mass_flow(state.leak, p.critical_ratio, state.pressure, ATMOSPHERE)
    if p.tube_length > 0.0:
        fed, exhausted = valve_flows(state, p, state.outlet, supply)
        step_tube(state, p, dt)
        gained = FILLING * fed - EXHAUSTING * exhausted - COMPRESSION * state.flow_in
        end = p.tube_volume / (2.0 * SEGMENTS)  # half a segment belongs to what it ends in
        state.outlet += dt * GAS_CONSTANT * TEMPERATURE / (p.outlet_volume + end) * gained
        volume += end
        # What goes to and fro in a tube gains and loses nothing: both ways the same exponent.
        inflow = COMPRESSION / FILLING * max(state.flow_out, 0.0)
        outflow += COMPRESSION / EXHAUSTING * max(-state.flow_out, 0.0)
    else:
        inflow, exhausted = valve_flows(state, p, state.pressure, supply)
        outflow += exhausted
    new_volume = volume - p.area * state.speed * dt
    state.pressure = step_pressure(state.pressure, volume, new_volume, inflow, outflow, dt)
    state.monitor += (state.outlet - ATMOSPHERE - state.monitor) * dt / (p.monitor_time + dt)


@inlined
def stop_force(extension: float, speed: float, p: Record) -> float:
    """Return the force of the end stops along the extension, N; they push and never pull."""
    force = 0.0
    if extension < 0.0:
        force = max(-p.stop_stiffness * extension - p.stop_damping * speed, 0.0)
    elif extension > p.stroke:
        force = min(p.stop_stiffness * (p.stroke - extension) - p.stop_damping * speed, 0.0)
    return float(force)


@inlined
def seal_friction(state: Record, p: Record, dt: float) -> float:
    """Step the seals' bristles and return their friction, N, opposed to the speed."""
    speed = state.speed
    load = p.pressure_friction * max(state.pressure - ATMOSPHERE, 0.0)
    limit = load + stribeck_force(speed, p.coulomb, p.breakaway, p.stribeck_velocity)
    limit = max(limit, _LEAST_FRICTION)
    bristle = step_bristle(state.bristle, speed, p.bristle_stiffness, limit, dt)
    damping = bristle_damping(speed, p.bristle_damping, p.stribeck_velocity)
    force = (
        p.bristle_stiffness * bristle + damping * (bristle - state.bristle) / dt + p.viscous * speed
    )
    state.bristle = bristle
    return float(force)


@inlined
def move_piston(state: Record, p: Record, stretch: float, rate: float, dt: float) -> None:
    """Step the piston's speed under its wire (stretch, m, and rate, m/s), seals, air and stops."""
    state.tension = wire_tension(stretch, rate, p.wire_stiffness, p.wire_damping)
    state.friction = seal_friction(state, p, dt)
    force = (
        state.tension
        - p.area * (state.pressure - ATMOSPHERE)
        - state.friction
        + stop_force(state.extension, state.speed, p)
    )
    state.speed += dt * force / p.mass


@inlined
def step_channel(
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
        `STATE`, changed in place, and `PARAMETERS`.
    queue : ndarray
        Setpoints on their way to the pilot stage, one per step of the dead time.
    supply : float
        Supply pressure, Pa absolute.
    stretch, rate : float
        Of the channel's wire, m and m/s.
    dt : float
        s.
    """
    if p.tube_length <= 0.0:
        state.outlet = state.pressure
    step_regulator(state, p, queue, supply, dt)
    move_piston(state, p, stretch, rate, dt)
    step_chamber(state, p, supply, dt)
    state.extension += dt * state.speed
