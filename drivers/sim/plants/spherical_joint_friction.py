"""Dry friction of the joint: each wire on the ball, and the ring in its seat.

References
----------
.. [1] P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
.. [2] L. Euler, "Remarques sur l'effet du frottement dans l'équilibre", 1762: a rope round a
   post holds with exp(mu alpha).
"""

import math

from drivers.sim.plants.compiled import inlined
from drivers.sim.plants.friction import step_bristle

_LEAST_FORCE = 1e-6
"""Keeps the bristle equation of a slack wire defined, N."""

_LEAST_TORQUE = 1e-8
"""Keeps the bristle equation of an unloaded seat defined, N m."""


@inlined
def capstan_tension(
    tension: float,
    bristle: float,
    speed: float,
    angle: float,
    stiffness: float,
    damping: float,
    dt: float,
) -> tuple[float, float]:
    """Return the tension behind the ball and the wire's new deflection on it.

    Sliding inwards the ball takes ``1 - exp(-mu alpha)`` of the cylinder's tension, sliding
    outwards it adds ``exp(mu alpha) - 1`` [2]; between the two the wire sticks elastically [1].
    When the tension falls, what the ball no longer holds slips without giving energy back.

    Parameters
    ----------
    tension : float
        On the cylinder's side, N.
    bristle : float
        Deflection of the wire on the ball, m.
    speed : float
        Of the wire towards the cylinder, m/s.
    angle : float
        Friction coefficient times wrapped angle, mu alpha.
    stiffness, damping : float
        Of the sticking wire, N/m and N s/m.
    dt : float
        s.

    Returns
    -------
    tension : float
        On the ring's side, N.
    bristle : float
        After the step, m.
    """
    if tension <= 0.0:
        return 0.0, 0.0
    grip = math.exp(angle)
    inwards, outwards = tension * (1.0 - 1.0 / grip), tension * (grip - 1.0)
    held = min(max(bristle, -outwards / stiffness), inwards / stiffness)
    limit = max(inwards if speed > 0.0 else outwards, _LEAST_FORCE)
    new = step_bristle(held, speed, stiffness, limit, dt)
    friction = stiffness * new + damping * (new - held) / dt
    return max(tension - friction, 0.0), new


@inlined
def step_seat(
    x: float,
    y: float,
    z: float,
    rate_x: float,
    rate_y: float,
    rate_z: float,
    stiffness: float,
    limit: float,
    dt: float,
) -> tuple[float, float, float, float, float, float]:
    """Return the seat's deflection after a step, rad, and its rate, rad/s.

    Dahl's model [1] for a vector: the three components share one limit, so that the friction of
    a sliding ring points against its angular velocity, whatever its direction.

    Parameters
    ----------
    x, y, z : float
        Deflection, a rotation vector, rad.
    rate_x, rate_y, rate_z : float
        Angular velocity of the ring, rad/s.
    stiffness : float
        N m/rad.
    limit : float
        Torque at which the seat yields, N m.
    dt : float
        s.
    """
    limit = max(limit, _LEAST_TORQUE)
    held = stiffness * math.sqrt(x * x + y * y + z * z)
    if held > limit:
        x, y, z = x * limit / held, y * limit / held, z * limit / held
    rate = math.sqrt(rate_x * rate_x + rate_y * rate_y + rate_z * rate_z)
    keep = 1.0 / (1.0 + dt * stiffness * rate / limit)
    new_x, new_y, new_z = (
        (x + dt * rate_x) * keep,
        (y + dt * rate_y) * keep,
        (z + dt * rate_z) * keep,
    )
    return new_x, new_y, new_z, (new_x - x) / dt, (new_y - y) / dt, (new_z - z) / dt
