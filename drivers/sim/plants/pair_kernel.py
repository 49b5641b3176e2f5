"""Kernel of the antagonistic pair: a whole cycle of substeps per call.

The carriage moves along ``position``, positive towards the agonist. At the rods' `home` and the
carriage's zero both wires are just taut, so the agonist's stretch is
``home - extension - position`` and the antagonist's ``home - extension + position``.
"""

from collections.abc import Callable

import numpy as np

from drivers.sim.plants.channel import step_channel, step_supply
from drivers.sim.plants.compiled import Record, cached_kernel, inlined
from drivers.sim.plants.friction import limit_bristle, step_bristle

PAIR_STATE = np.dtype(
    [
        ("supply", float),  # supply line, Pa absolute
        ("supply_target", float),  # input: what the line is connected to, Pa absolute
        ("position", float),  # carriage, m
        ("speed", float),  # carriage, m/s
        ("bristle", float),  # seat, m
        ("friction", float),  # seat, N
        ("push", float),  # input: what somebody pushes the carriage with, N
    ]
)
"""State and inputs that belong to no single channel."""

PAIR_PARAMETERS = np.dtype(
    [
        (name, float)
        for name in (
            "supply_time",
            "supply_volume",
            "home",
            "mass",
            "seat",
            "seat_stiffness",
            "seat_damping",
            "stop",
            "stop_stiffness",
            "stop_damping",
        )
    ]
)
"""Parameters of the carriage and the supply line, SI; `seat` is friction over tension, and
`stop` how far the carriage goes either way before it meets its mechanical stop."""

_LEAST_FRICTION = 1e-6
"""Keeps the bristle equation defined without tension, N."""


@inlined
def seat_friction(pair: Record, q: Record, load: float, dt: float) -> float:
    """Step the seat's bristles and return its friction, N: Dahl, in proportion to the load.

    When the load falls, what the seat no longer holds slips away without giving energy back.
    """
    limit = max(q.seat * load, _LEAST_FRICTION)
    held = limit_bristle(pair.bristle, q.seat_stiffness, limit)
    bristle = step_bristle(held, pair.speed, q.seat_stiffness, limit, dt)
    force: float = q.seat_stiffness * bristle + q.seat_damping * (bristle - held) / dt
    pair.bristle = bristle
    return force


@inlined
def carriage_stop(position: float, speed: float, q: Record) -> float:
    """Return the force of the carriage's mechanical stops, N; they push and never pull."""
    force = 0.0
    if position > q.stop:
        force = min(q.stop_stiffness * (q.stop - position) - q.stop_damping * speed, 0.0)
    elif position < -q.stop:
        force = max(q.stop_stiffness * (-q.stop - position) - q.stop_damping * speed, 0.0)
    return float(force)


@inlined
def step_carriage(pair: Record, q: Record, agonist: float, antagonist: float, dt: float) -> None:
    """Step the carriage under the tensions of both wires, N."""
    pair.friction = seat_friction(pair, q, agonist + antagonist, dt)
    force = agonist - antagonist - pair.friction
    force += carriage_stop(pair.position, pair.speed, q) + pair.push
    pair.speed += dt * force / q.mass
    pair.position += dt * pair.speed


def _build(sources: int) -> Callable[..., None]:
    def advance_pair(
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
        pair, q = pairs[0], pair_parameters[0]
        for _ in range(steps):
            step_supply(pair, q, agonist.drawn + antagonist.drawn, dt)
            stretch_a = q.home - agonist.extension - pair.position
            stretch_b = q.home - antagonist.extension + pair.position
            rate_a = -agonist.speed - pair.speed
            rate_b = -antagonist.speed + pair.speed
            step_channel(agonist, parameters[0], queues[0], pair.supply, stretch_a, rate_a, dt)
            step_channel(antagonist, parameters[1], queues[1], pair.supply, stretch_b, rate_b, dt)
            step_carriage(pair, q, agonist.tension, antagonist.tension, dt)

    return advance_pair


advance_pair: Callable[..., None] = cached_kernel(_build)
"""Integrate a pair over `steps` substeps of `dt` seconds.

Parameters
----------
channels, parameters : ndarray, shape (2,)
    `STATE`, changed in place, and `PARAMETERS` of agonist and antagonist.
queues : ndarray, shape (2, k)
    Setpoints on their way to the pilot stages, changed in place.
pairs, pair_parameters : ndarray, shape (1,)
    `PAIR_STATE`, changed in place, and `PAIR_PARAMETERS`.
steps : int
    Number of substeps.
dt : float
    Substep, s.
"""


@inlined
def tell_pair(bodies: Record, truth: Record) -> None:
    """Write the carriage's position, m, as `rig.hal.plant.LentPlant` says."""
    truth[0] = bodies[3][0].position
