"""Air: flow through an orifice and the pressure in a chamber. All pressures absolute, Pa.

References
----------
.. [1] ISO 6358-1:2013, Pneumatic fluid power: determination of flow-rate characteristics.
.. [2] E. Richer and Y. Hurmuzlu, "A high performance pneumatic force actuator system:
   part I", J. Dyn. Syst. Meas. Control 122(3), 2000, pp. 416-425.
"""

import math

from drivers.sim.plants.compiled import inlined

ATMOSPHERE = 101_325.0
"""Ambient pressure, Pa."""

TEMPERATURE = 293.15
"""Ambient temperature, and that of the air everywhere, K: also the reference of [1]."""

GAS_CONSTANT = 287.05
"""Specific gas constant of air, J/(kg K)."""

REFERENCE_DENSITY = 1.185
"""Density at the reference conditions (ANR) of [1], kg/m³."""

FILLING = 1.4
"""Exponent of air that flows in: adiabatic [2]."""

EXHAUSTING = 1.0
"""Exponent of air that flows out: isothermal [2]."""

COMPRESSION = 1.2
"""Exponent of the piston's work on the air: between the two [2]."""

_LAMINAR_RATIO = 0.995
"""Above this ratio the flow is taken as linear: the slope of [1] is infinite at 1."""


@inlined
def flow_function(ratio: float, critical_ratio: float) -> float:
    """Return the flow over the choked flow, after ISO 6358 [1].

    Parameters
    ----------
    ratio : float
        Downstream over upstream pressure, 0 … 1.
    critical_ratio : float
        Ratio b below which the flow is choked.

    Returns
    -------
    float
        1 when choked, 0 without a pressure difference.
    """
    if ratio <= critical_ratio:
        return 1.0
    if ratio >= 1.0:
        return 0.0
    if ratio > _LAMINAR_RATIO:
        at_edge = (_LAMINAR_RATIO - critical_ratio) / (1.0 - critical_ratio)
        return math.sqrt(1.0 - at_edge * at_edge) * (1.0 - ratio) / (1.0 - _LAMINAR_RATIO)
    subsonic = (ratio - critical_ratio) / (1.0 - critical_ratio)
    return math.sqrt(1.0 - subsonic * subsonic)


@inlined
def mass_flow(
    conductance: float, critical_ratio: float, upstream: float, downstream: float
) -> float:
    """Return the mass flow through an orifice, kg/s; none against the pressure (check valve).

    Parameters
    ----------
    conductance : float
        Sonic conductance C, m³/(s Pa).
    critical_ratio : float
        Critical pressure ratio b.
    upstream, downstream : float
        Absolute pressures, Pa.
    """
    if upstream <= downstream:
        return 0.0
    choked = conductance * upstream * REFERENCE_DENSITY
    return choked * flow_function(downstream / upstream, critical_ratio)


@inlined
def step_pressure(
    pressure: float,
    volume: float,
    new_volume: float,
    inflow: float,
    outflow: float,
    dt: float,
) -> float:
    """Return the chamber's pressure after one step, Pa absolute.

    The pressure equation of [2],
    ``dp/dt = R T / V (1.4 inflow - 1.0 outflow) - 1.2 p/V dV/dt``, split in two: the piston's
    work is integrated exactly (``p V^1.2`` stays), so that a closed chamber is a conservative
    spring whatever the step, and the flows are added to that.

    Parameters
    ----------
    pressure : float
        Before the step, Pa absolute.
    volume, new_volume : float
        Before and after the step, m³.
    inflow, outflow : float
        kg/s, both positive.
    dt : float
        s.
    """
    compressed = pressure * math.exp(COMPRESSION * math.log(volume / new_volume))
    added = GAS_CONSTANT * TEMPERATURE / new_volume
    return compressed + dt * added * (FILLING * inflow - EXHAUSTING * outflow)
