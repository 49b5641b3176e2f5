"""A proportional spool valve: from the signal of its opening to the flows of its ports.

The stages, in order: dead time of the electronics, play (hysteresis), the spool as a second order
with a greatest speed, and two ports with an overlap, a curve and a leak of their own each. An
opening is -1 (exhaust) … 1 (feed); all pressures absolute, Pa.
"""

import math

import numpy as np

from drivers.sim.plants.channel import STUCK, STUCK_CLOSED, STUCK_OPEN
from drivers.sim.plants.compiled import Record, inlined, vanish
from drivers.sim.plants.parameters import body_values
from drivers.sim.plants.pneumatics import ATMOSPHERE, mass_flow
from drivers.sim.plants.regulator import follow_with_play
from drivers.sim.plants.settings import ActuatorSettings, SealFriction, WireSettings
from drivers.sim.plants.valve_settings import SpoolSettings

SPOOL_PARAMETERS = np.dtype(
    [
        (name, float)
        for name in (
            "bandwidth",
            "damping",
            "slew",
            "hysteresis",
            "dead_steps",
            "zero",
            "overlap_in",
            "overlap_out",
            "conductance_in",
            "conductance_out",
            "progression_in",
            "progression_out",
            "ratio_in",
            "ratio_out",
            "leakage",
            "past",  # leak from the supply past the lands, by a fault, m³/(s Pa)
            "monitor_time",
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
        )
    ]
)
"""Parameters of a channel with a spool valve, SI; openings over half of the stroke."""


@inlined
def step_spool(state: Record, p: Record, queue: Record, dt: float) -> None:
    """Step the spool's position, `opening`, towards the signal of a dead time ago."""
    signal = state.setpoint
    if p.dead_steps >= 1.0:
        place = int(state.place)
        signal = float(queue[place])
        queue[place] = state.setpoint
        state.place = place + 1.0 if place + 1.0 < p.dead_steps else 0.0
    state.play = follow_with_play(state.play, signal, 0.5 * p.hysteresis)
    target = state.play
    if state.mode == STUCK:
        state.opening_rate = 0.0
        return
    if state.mode == STUCK_OPEN:
        target = 1.0
    elif state.mode == STUCK_CLOSED:
        target = p.zero
    pull = p.bandwidth * p.bandwidth * (target - state.opening)
    rate = (state.opening_rate + dt * pull) / (1.0 + dt * 2.0 * p.damping * p.bandwidth)
    rate = min(max(rate, -p.slew), p.slew)
    state.opening = min(max(state.opening + dt * rate, -1.0), 1.0)
    state.opening_rate = vanish(rate)


@inlined
def port_area(uncovered: float, overlap: float, progression: float, leakage: float) -> float:
    """Return a port's area over its greatest, for how far its land has moved towards it.

    Parameters
    ----------
    uncovered : float
        From the middle, over half of the stroke; negative: the other way.
    overlap : float
        Where the port begins to open.
    progression : float
        How much flatter than on average it begins to.
    leakage : float
        What passes the land in the middle. It fades as the land covers more.
    """
    beyond = (uncovered - overlap) / (1.0 - overlap)
    gap = leakage * math.exp(min(beyond, 0.0) / (overlap + 1e-3))
    if beyond <= 0.0:
        return gap
    share = min(beyond, 1.0)
    return share * (1.0 - progression * (1.0 - share)) + gap


@inlined
def spool_flows(state: Record, p: Record, supply: float) -> tuple[float, float]:
    """Return the mass flows (kg/s) into and out of the chamber."""
    moved, pressure = state.opening - p.zero, state.pressure
    fed = p.conductance_in * port_area(moved, p.overlap_in, p.progression_in, p.leakage) + p.past
    inflow = mass_flow(fed, p.ratio_in, supply, pressure)
    # A port that stands open lets the chamber empty into a supply that was vented.
    back = mass_flow(fed, p.ratio_in, pressure, supply)
    state.drawn = inflow - back
    let = p.conductance_out * port_area(-moved, p.overlap_out, p.progression_out, p.leakage)
    # And by its exhaust a rod that is pulled by hand draws air in.
    inflow += mass_flow(let, p.ratio_out, ATMOSPHERE, pressure)
    return inflow, back + mass_flow(let, p.ratio_out, pressure, ATMOSPHERE)


def draw_spool(
    rng: np.random.Generator,
    *,
    valve: SpoolSettings,
    cylinder: ActuatorSettings,
    wire: WireSettings,
    seals: SealFriction,
    friction_spread: float,
    dead_steps: float,
) -> tuple[float, ...]:
    """Return one channel's `SPOOL_PARAMETERS`: the settings and this unit's deviations.

    As in `drivers.sim.plants.parameters.draw_channel`, the draws do not depend on settings.
    """
    bandwidth, zero, friction = rng.uniform(-1.0, 1.0, 3)
    overlaps, conductances, progressions, ratios = rng.uniform(-1.0, 1.0, (4, 2))
    overlap_in, overlap_out = valve.overlap * (1.0 + valve.overlap_spread * overlaps)
    progression_in, progression_out = np.clip(
        valve.progression + valve.progression_spread * progressions, 0.0, 0.95
    )
    ratio_in, ratio_out = np.clip(
        valve.critical_ratio + valve.critical_ratio_spread * ratios, 0.0, 0.95
    )
    scale_in, scale_out = 1.0 + valve.conductance_spread * conductances
    values = {
        "bandwidth": valve.bandwidth * (1.0 + valve.bandwidth_spread * bandwidth),
        "damping": valve.damping,
        "slew": valve.slew,
        "hysteresis": valve.hysteresis,
        "dead_steps": dead_steps,
        "zero": valve.zero * zero,
        "overlap_in": overlap_in,
        "overlap_out": overlap_out,
        "conductance_in": valve.conductance_in * scale_in,
        "conductance_out": valve.conductance_out * scale_out,
        "progression_in": progression_in,
        "progression_out": progression_out,
        "ratio_in": ratio_in,
        "ratio_out": ratio_out,
        "leakage": valve.leakage,
        "past": 0.0,
        "monitor_time": valve.monitor_time,
        **body_values(cylinder, wire, seals, 1.0 + friction_spread * friction),
    }
    return tuple(float(values[name]) for name in SPOOL_PARAMETERS.names or ())
