"""Friction with memory: LuGre for seals, Dahl for a dry seat.

References
----------
.. [1] C. Canudas de Wit, H. Olsson, K. J. Åström and P. Lischinsky, "A new model for control of
   systems with friction", IEEE Trans. Autom. Control 40(3), 1995, pp. 419-425.
.. [2] H. Olsson, "Control systems with friction", thesis, Lund, 1996: the damping of the bristles
   has to fade with the velocity, or the model can give energy.
.. [3] P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
"""

import math

from drivers.sim.plants.compiled import inlined


@inlined
def stribeck_force(
    speed: float, coulomb: float, breakaway: float, stribeck_velocity: float
) -> float:
    """Return the steady friction without its viscous part, N [1]."""
    fade = speed / stribeck_velocity
    return coulomb + (breakaway - coulomb) * math.exp(-fade * fade)


@inlined
def step_bristle(bristle: float, speed: float, stiffness: float, limit: float, dt: float) -> float:
    """Return the deflection of the bristles after one step, m.

    ``dz/dt = v - sigma_0 |v| z / g`` [1], implicit in z: at 0.8 m/s the explicit step
    would be unstable.

    Parameters
    ----------
    bristle : float
        Deflection z, m.
    speed : float
        Sliding speed, m/s.
    stiffness : float
        sigma_0, N/m.
    limit : float
        Friction force g at which they yield, N.
    dt : float
        s.
    """
    return (bristle + dt * speed) / (1.0 + dt * stiffness * abs(speed) / limit)


@inlined
def bristle_damping(speed: float, damping: float, stribeck_velocity: float) -> float:
    """Return sigma_1 as it fades with the speed, N s/m [2]."""
    fade = speed / stribeck_velocity
    return damping * math.exp(-fade * fade)


@inlined
def limit_bristle(bristle: float, stiffness: float, limit: float) -> float:
    """Return the deflection that a friction of `limit` N can hold, m: the rest slips."""
    most = limit / stiffness
    return min(max(bristle, -most), most)
