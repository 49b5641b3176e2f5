"""Kernel of the spherical joint: four channels and the ring, a whole cycle of substeps per call.

The ball stands at the origin with the ring towards +z. The ring turns about the ball's centre
with all three degrees of freedom; nothing but wires and friction holds it. A wire's stretch is
``length - free - extension``: it is pulled in when its rod retracts.
"""

import math
from collections.abc import Callable

import numpy as np

from drivers.sim.plants.channel import step_channel, step_supply
from drivers.sim.plants.compiled import Record, cached_kernel, inlined
from drivers.sim.plants.spherical_joint_friction import capstan_tension, step_seat
from drivers.sim.plants.spherical_joint_truth import tell_truth
from drivers.sim.plants.spherical_joint_wire import compiled_wire_path

JOINT_STATE = np.dtype(
    [
        ("supply", float),  # supply line, Pa absolute
        ("supply_target", float),  # input: what the line is connected to, Pa absolute
        ("qw", float),  # orientation of the ring, a unit quaternion from ring to ball
        ("qx", float),
        ("qy", float),
        ("qz", float),
        ("rate_x", float),  # angular velocity of the ring in the ball's axes, rad/s
        ("rate_y", float),
        ("rate_z", float),
        ("seat_x", float),  # deflection of the seat in the ball's axes, rad
        ("seat_y", float),
        ("seat_z", float),
        ("push_x", float),  # input: what somebody pushes the ring's centre of mass with, N
        ("push_y", float),
    ]
)
"""State and inputs that belong to no single channel."""

JOINT_PARAMETERS = np.dtype(
    [
        (name, float)
        for name in (
            "supply_time",
            "supply_volume",
            "ball_radius",
            "inertia_tilt",
            "inertia_spin",
            "weight",
            "centre_height",
            "seat_arm",  # friction torque over load, m
            "seat_stiffness",
            "seat_damping",
            "tilt_stop",
            "stop_stiffness",
            "stop_damping",
            "marker_x",  # in the ring's axes, m
            "marker_y",
            "marker_z",
        )
    ]
)
"""Parameters of ring, seat and supply line, SI."""

WIRE_STATE = np.dtype(
    [
        ("length", float),  # from adjust point to anchor, m
        ("bristle", float),  # deflection on the ball, m
        ("tension", float),  # at the ring, N
        ("wrap", float),  # angle on the ball, rad
        ("arm_x", float),  # about which its tension turns the ring, m
        ("arm_y", float),
        ("arm_z", float),
        ("inwards", float),  # how fast the ring pulls it in, m/s
        ("stretch", float),  # m
        ("rate", float),  # of the stretch, m/s
    ]
)
"""State of a wire on the ball, and what the ring does to it at the beginning of a step."""

WIRE_PARAMETERS = np.dtype(
    [
        (name, float)
        for name in (
            "anchor_x",  # in the ring's axes, m
            "anchor_y",
            "anchor_z",
            "adjust_x",  # in the ball's axes, m
            "adjust_y",
            "adjust_z",
            "free",  # length at which the wire is just taut behind a retracted rod, m
            "friction",  # coefficient on the ball
            "stiffness",  # of the wire that sticks to the ball, N/m
            "damping",  # N s/m
        )
    ]
)
"""Parameters of a wire, SI."""


@inlined
def turn_ring(joint: Record, dt: float) -> None:
    """Turn the orientation by the angular velocity of this step."""
    hx, hy, hz = 0.5 * dt * joint.rate_x, 0.5 * dt * joint.rate_y, 0.5 * dt * joint.rate_z
    w, x, y, z = joint.qw, joint.qx, joint.qy, joint.qz
    w, x, y, z = (
        w - hx * x - hy * y - hz * z,
        x + hx * w + hy * z - hz * y,
        y + hy * w + hz * x - hx * z,
        z + hz * w + hx * y - hy * x,
    )
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    joint.qw, joint.qx, joint.qy, joint.qz = w * scale, x * scale, y * scale, z * scale


@inlined
def stop_torque(joint: Record, q: Record, ux: float, uy: float, uz: float) -> tuple[float, float]:
    """Return the horizontal torque of the end stop on a ring with axis u; it only pushes back."""
    across = math.sqrt(ux * ux + uy * uy)
    beyond = math.atan2(across, uz) - q.tilt_stop
    if beyond <= 0.0:
        return 0.0, 0.0
    tx, ty = -uy / across, ux / across
    rate = tx * joint.rate_x + ty * joint.rate_y
    torque = max(q.stop_stiffness * beyond + q.stop_damping * rate, 0.0)
    return -torque * tx, -torque * ty


@inlined
def accelerate_ring(
    joint: Record,
    q: Record,
    torque: tuple[float, float, float],
    axis: tuple[float, float, float],
    dt: float,
) -> None:
    """Apply a torque to the ring, a symmetric top about its axis (Euler's equation)."""
    tx, ty, tz = torque
    ux, uy, uz = axis
    wx, wy, wz = joint.rate_x, joint.rate_y, joint.rate_z
    gyration = (q.inertia_spin - q.inertia_tilt) * (ux * wx + uy * wy + uz * wz)
    tx -= gyration * (wy * uz - wz * uy)
    ty -= gyration * (wz * ux - wx * uz)
    tz -= gyration * (wx * uy - wy * ux)
    along = (1.0 / q.inertia_spin - 1.0 / q.inertia_tilt) * (ux * tx + uy * ty + uz * tz)
    joint.rate_x = wx + dt * (tx / q.inertia_tilt + along * ux)
    joint.rate_y = wy + dt * (ty / q.inertia_tilt + along * uy)
    joint.rate_z = wz + dt * (tz / q.inertia_tilt + along * uz)


@inlined
def drawn_by(channels: Record) -> float:
    """Return what all channels draw from the supply line."""
    drawn = 0.0
    for k in range(channels.shape[0]):
        drawn += channels[k].drawn
    return drawn


@inlined
def lay_wires(joint: Record, q: Record, channels: Record, wires: Record, laid: Record) -> None:
    """Fill how the wires lie on the ball, and how the ring and the rods stretch them.

    Parameters
    ----------
    joint, q : record
        `JOINT_STATE` and `JOINT_PARAMETERS`.
    channels, wires, laid : ndarray, shape (n,)
        `STATE`, `WIRE_STATE` (changed in place) and `WIRE_PARAMETERS`.
    """
    w, x, y, z = joint.qw, joint.qx, joint.qy, joint.qz
    wx, wy, wz = joint.rate_x, joint.rate_y, joint.rate_z
    xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    yx, yy, yz = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    for k in range(channels.shape[0]):
        channel, wire, p = channels[k], wires[k], laid[k]
        ax, ay, az = p.anchor_x, p.anchor_y, p.anchor_z
        wire.length, wire.wrap, rx, ry, rz = compiled_wire_path(
            xx * ax + xy * ay + xz * az,
            yx * ax + yy * ay + yz * az,
            zx * ax + zy * ay + zz * az,
            p.adjust_x,
            p.adjust_y,
            p.adjust_z,
            q.ball_radius,
        )
        wire.arm_x, wire.arm_y, wire.arm_z = rx, ry, rz
        wire.inwards = rx * wx + ry * wy + rz * wz
        wire.stretch = wire.length - p.free - channel.extension
        wire.rate = -wire.inwards - channel.speed


@inlined
def move_ring(
    joint: Record, q: Record, channels: Record, wires: Record, laid: Record, dt: float
) -> None:
    """Turn the ring by weight, push, stop, seat and the wires that the channels pull.

    Parameters
    ----------
    joint, q, channels, wires, laid
        As for `lay_wires`, of the same step.
    dt : float
        s.
    """
    w, x, y, z = joint.qw, joint.qx, joint.qy, joint.qz
    xz, yz, zz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    tx, ty = stop_torque(joint, q, xz, yz, zz)
    tx -= q.weight * q.centre_height * yz + q.centre_height * zz * joint.push_y
    ty += q.weight * q.centre_height * xz + q.centre_height * zz * joint.push_x
    tz = q.centre_height * (xz * joint.push_y - yz * joint.push_x)
    load = q.weight
    for k in range(channels.shape[0]):
        wire, p = wires[k], laid[k]
        tension, wire.bristle = capstan_tension(
            channels[k].tension,
            wire.bristle,
            wire.inwards,
            p.friction * wire.wrap,
            p.stiffness,
            p.damping,
            dt,
        )
        wire.tension = tension
        tx += tension * wire.arm_x
        ty += tension * wire.arm_y
        tz += tension * wire.arm_z
        load += tension

    sx, sy, sz, slide_x, slide_y, slide_z = step_seat(
        joint.seat_x,
        joint.seat_y,
        joint.seat_z,
        joint.rate_x,
        joint.rate_y,
        joint.rate_z,
        q.seat_stiffness,
        q.seat_arm * load,
        dt,
    )
    joint.seat_x, joint.seat_y, joint.seat_z = sx, sy, sz
    tx -= q.seat_stiffness * sx + q.seat_damping * slide_x
    ty -= q.seat_stiffness * sy + q.seat_damping * slide_y
    tz -= q.seat_stiffness * sz + q.seat_damping * slide_z
    accelerate_ring(joint, q, (tx, ty, tz), (xz, yz, zz), dt)
    turn_ring(joint, dt)


def _build(sources: int) -> Callable[..., None]:
    def advance_joint(
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
                step_channel(
                    channels[k], parameters[k], queues[k], joint.supply, wire.stretch, wire.rate, dt
                )
            move_ring(joint, q, channels, wires, wire_parameters, dt)
        tell_truth(truth, channels, parameters, wires, joint, q)

    return advance_joint


advance_joint: Callable[..., None] = cached_kernel(_build)
"""Integrate a joint over `steps` substeps of `dt` seconds.

Parameters
----------
channels, parameters : ndarray, shape (n,)
    `STATE`, changed in place, and `PARAMETERS` of each channel.
queues : ndarray, shape (n, k)
    Setpoints on their way to the pilot stages, changed in place.
wires, wire_parameters : ndarray, shape (n,)
    `WIRE_STATE`, changed in place, and `WIRE_PARAMETERS` of each channel's wire.
joints, joint_parameters : ndarray, shape (1,)
    `JOINT_STATE`, changed in place, and `JOINT_PARAMETERS`.
truth : ndarray, shape (32,)
    What is true in the end, as `TRUTH_COLUMNS` names it.
steps : int
    Number of substeps.
dt : float
    Substep, s.
"""


@inlined
def tell_joint(bodies: Record, truth: Record) -> None:
    """Write where the marker is, m, as `rig.hal.plant.LentPlant` says."""
    for k in range(3):
        truth[k] = bodies[7][k]
