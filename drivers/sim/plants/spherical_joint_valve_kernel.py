"""Kernel of the spherical joint on proportional valves: a whole cycle of substeps per call.

It differs from `drivers.sim.plants.spherical_joint_kernel` in the step of a channel alone. A kernel
that took that step as an argument could not be kept in numba's cache.
"""

from collections.abc import Callable

from drivers.sim.plants.channel import step_supply
from drivers.sim.plants.compiled import Record, cached_kernel
from drivers.sim.plants.spherical_joint_kernel import drawn_by, lay_wires, move_ring
from drivers.sim.plants.spherical_joint_truth import tell_truth
from drivers.sim.plants.valve_kernel import step_valve_channel


def _build(sources: int) -> Callable[..., None]:
    def advance_valve_joint(
        channels: Record,
        parameters: Record,
        queues: Record,
        wires: Record,
        wire_parameters: Record,
        joints: Record,
        joint_parameters: Record,
        truth: Record,
        steps: int,
        dt: float,
    ) -> None:
        digest = sources  # noqa: F841 - makes the sources part of the cache key
        joint, q = joints[0], joint_parameters[0]
        for _ in range(steps):
            step_supply(joint, q, drawn_by(channels), dt)
            lay_wires(joint, q, channels, wires, wire_parameters)
            for k in range(channels.shape[0]):
                wire = wires[k]
                step_valve_channel(
                    channels[k], parameters[k], queues[k], joint.supply, wire.stretch, wire.rate, dt
                )
            move_ring(joint, q, channels, wires, wire_parameters, dt)
        tell_truth(truth, channels, parameters, wires, joint, q)

    return advance_valve_joint


advance_valve_joint: Callable[..., None] = cached_kernel(_build)
"""Integrate a joint on valves; see `drivers.sim.plants.spherical_joint_kernel.advance_joint`."""
