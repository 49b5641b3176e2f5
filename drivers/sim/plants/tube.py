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
from typing import NamedTuple

from drivers.sim.plants.compiled import Record, inlined, vanish
from drivers.sim.plants.pneumatics import COMPRESSION, GAS_CONSTANT, TEMPERATURE

SEGMENTS = 3
_VISCOSITY = 1.81e-5
"""Of air at room temperature, Pa s."""


class SegmentNumbers(NamedTuple):
    """The numbers of one segment, worked out once: divisions are what a substep is made of.

    Parameters
    ----------
    push : float
        Area over length, m: by how much (kg/s²) a pressure difference accelerates the flow.
    drag : float
        Of `unit`, for each of Reynolds number times friction factor, Pa/s: times the sum of the
        pressures at both ends it is by how much friction slows the flow.
    unit : float
        Mass flow at a Reynolds number of 1, kg/s.
    """

    push: float
    drag: float
    unit: float


def segment_numbers(length: float, bore: float) -> SegmentNumbers:
    """Return the numbers of a segment of some length and bore, m."""
    area = 0.25 * math.pi * bore * bore
    unit = 0.25 * math.pi * bore * _VISCOSITY
    return SegmentNumbers(
        area / length if length > 0.0 else 0.0,
        GAS_CONSTANT * TEMPERATURE * unit / (bore * area),
        unit,
    )


@inlined
def step_flow(
    flow: float,
    upstream: float,
    downstream: float,
    push: float,
    drag: float,
    unit: float,
    dt: float,
) -> float:
    """Return the mass flow (kg/s) through one segment after one step.

    The friction is taken with the flow after the step, so that any flow is stable: the pressure
    ``f L/D G|G| / (2 rho A²)`` that it takes is ``drag (f Re) G / (p1 + p2)``, over `push`.

    Parameters
    ----------
    flow : float
        Before the step, kg/s.
    upstream, downstream : float
        Pressures at its ends, Pa absolute.
    push, drag, unit : float
        `SegmentNumbers`.
    dt : float
        s.
    """
    reynolds = abs(flow) / unit
    root = math.sqrt(reynolds)
    both = upstream + downstream
    slowed = dt * drag * max(64.0, 0.3164 * root * math.sqrt(root))
    return vanish((flow + dt * push * (upstream - downstream)) * both / (both + slowed))


@inlined
def step_tube(state: Record, p: Record, dt: float) -> None:
    """Step the flows of a channel's tube and the pressures between them.

    The ends belong to others: `outlet` and `pressure` of the channel.
    """
    push, drag, unit = p.tube_push, p.tube_drag, p.tube_unit
    before, first, second = state.outlet, state.tube_first, state.tube_second
    flow_in = step_flow(state.flow_in, before, first, push, drag, unit, dt)
    flow = step_flow(state.flow, first, second, push, drag, unit, dt)
    flow_out = step_flow(state.flow_out, second, state.pressure, push, drag, unit, dt)
    per_mass = dt * p.tube_rise
    state.flow_in, state.flow, state.flow_out = flow_in, flow, flow_out
    state.tube_first = first + per_mass * (flow_in - flow)
    state.tube_second = second + per_mass * (flow - flow_out)


def rise_per_mass(volume: float) -> float:
    """Return by how much the pressure between two segments rises with the air there, Pa/kg."""
    return COMPRESSION * GAS_CONSTANT * TEMPERATURE * SEGMENTS / volume if volume > 0.0 else 0.0
