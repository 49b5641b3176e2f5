"""The tube between a regulator and its chamber: inertia, capacity and friction of its air.

The tube is cut in three equal segments. Each has one mass flow; the pressures stand between them,
with the regulator's outlet at one end and the chamber at the other. The delay of sound and the
conductance follow from that. All pressures absolute, Pa.

References
----------
.. [1] E. Richer and Y. Hurmuzlu, "A high performance pneumatic force actuator system: part I",
   J. Dyn. Syst. Meas. Control 122(3), 2000: delay and attenuation of a tube.
.. [2] H. Blasius, "Das Ähnlichkeitsgesetz bei Reibungsvorgängen in Flüssigkeiten", 1913: friction
   of turbulent flow in a smooth tube, 0.3164 Re^-1/4.
"""

import math

from drivers.sim.plants.compiled import Record, inlined
from drivers.sim.plants.pneumatics import COMPRESSION, GAS_CONSTANT, TEMPERATURE

SEGMENTS = 3
_VISCOSITY = 1.81e-5
"""Of air at room temperature, Pa s."""


@inlined
def step_flow(
    flow: float, upstream: float, downstream: float, segment: float, bore: float, dt: float
) -> float:
    """Return the mass flow (kg/s) through one segment after one step.

    The friction is taken with the flow after the step, so that any flow is stable.

    Parameters
    ----------
    flow : float
        Before the step, kg/s.
    upstream, downstream : float
        Pressures at its ends, Pa absolute.
    segment, bore : float
        Length and bore, m.
    dt : float
        s.
    """
    area = 0.25 * math.pi * bore * bore
    density = 0.5 * (upstream + downstream) / (GAS_CONSTANT * TEMPERATURE)
    reynolds = max(4.0 * abs(flow) / (math.pi * bore * _VISCOSITY), 1.0)
    friction = max(64.0 / reynolds, 0.3164 / math.sqrt(math.sqrt(reynolds)))
    moving = max(abs(flow), 0.25 * math.pi * bore * _VISCOSITY)  # where Re is 1
    resistance = friction * segment / bore * moving / (2.0 * density * area * area)
    inertance = segment / area
    return (flow + dt / inertance * (upstream - downstream)) / (1.0 + dt / inertance * resistance)


@inlined
def step_tube(state: Record, p: Record, dt: float) -> None:
    """Step the flows of a channel's tube and the pressures between them.

    The ends belong to others: `outlet` and `pressure` of the channel.
    """
    segment = p.tube_length / SEGMENTS
    bore = p.tube_bore
    state.flow_in = step_flow(state.flow_in, state.outlet, state.tube_first, segment, bore, dt)
    state.flow = step_flow(state.flow, state.tube_first, state.tube_second, segment, bore, dt)
    state.flow_out = step_flow(state.flow_out, state.tube_second, state.pressure, segment, bore, dt)
    per_mass = dt * COMPRESSION * GAS_CONSTANT * TEMPERATURE * SEGMENTS / p.tube_volume
    state.tube_first += per_mass * (state.flow_in - state.flow)
    state.tube_second += per_mass * (state.flow - state.flow_out)
