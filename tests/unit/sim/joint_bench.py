"""A nominal joint for tests, and what the plant must not be asked: exact wires another way."""

import math
from dataclasses import dataclass, replace

import numpy as np

from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.regulator_settings import RegulatorSettings
from drivers.sim.plants.spherical_joint import SphericalJointPlant
from drivers.sim.plants.spherical_joint_settings import SphericalJointPlantSettings

AREA = math.pi / 4 * (0.016**2 - 0.005**2)
BASE = 0.12e6
CH1, CH2, CH3, CH4 = range(4)


@dataclass(frozen=True)
class Geometry:
    """Dimensions as a profile gives them."""

    ball_radius: float = 0.025
    ring_radius: float = 0.020
    anchor_angles: tuple = tuple(math.radians(angle) for angle in (90, 180, 270, 360))
    adjust_radius: float = 0.025
    adjust_depth: float = 0.025
    marker_height: float = 0.052628


SEALED = RegulatorSettings(conductance_in=0.0, conductance_out=0.0)
EQUAL = SphericalJointPlantSettings(
    friction_spread=0.0,
    wire_offset=0.0,
    tolerance=0.0,
    regulator=RegulatorSettings(linearity=0.0, bandwidth_spread=0.0, monitor_noise=0.0),
)
"""Four equal channels and the nominal geometry."""


def joint(seed=0, geometry=None, **changes):
    """Return a joint of equal units with some settings changed."""
    return SphericalJointPlant(replace(EQUAL, **changes), seed, geometry or Geometry())


def truth(plant):
    """Return the truth by name."""
    return {
        name: value for (name, _), value in zip(plant.truth_columns, plant.truth(), strict=True)
    }


def command(plant, pressures, until):
    """Give all setpoints, Pa, and let time pass."""
    for channel, pressure in enumerate(pressures):
        plant.set_pressure_setpoint(channel, pressure)
    plant.advance(until)


def at_base(plant, duration=0.6):
    """Open the supply and pull all wires with the base pressure."""
    plant.set_supply(True)
    command(plant, [BASE] * 4, duration)
    return plant


def rotation(axis, angle):
    """Return a rotation matrix (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def points(geometry=None):
    """Return anchors at home and adjust points, m, shapes (4, 3)."""
    g = geometry or Geometry()
    height = math.sqrt(g.ball_radius**2 - g.ring_radius**2)
    angles = np.array(g.anchor_angles)
    ones = np.ones(4)
    anchors = (g.ring_radius * np.cos(angles), g.ring_radius * np.sin(angles), height * ones)
    adjusts = (
        g.adjust_radius * np.cos(angles),
        g.adjust_radius * np.sin(angles),
        -g.adjust_depth * ones,
    )
    return np.stack(anchors, 1), np.stack(adjusts, 1)


def wire_lengths(matrix):
    """Return the four exact lengths of the nominal joint, m, while its wires touch the ball.

    With anchors on the ball and adjust points at sqrt(2) radii the exact wire is
    ``r (1 + psi - pi/4)``, psi the angle between its ends.
    """
    anchors, adjusts = points()
    ends = anchors @ np.asarray(matrix).T
    psi = np.arctan2(
        np.linalg.norm(np.cross(ends, adjusts), axis=1), np.sum(ends * adjusts, axis=1)
    )
    assert psi.min() > math.pi / 4
    return 0.025 * (1 + psi - math.pi / 4)


def energy(plant):
    """Return everything that could still do work, J (plus a constant), shape ().

    The gas behind ``p V^1.2 = const`` stores ``p V / 0.2``; displaced air, ``p_atm V``.
    """
    s, q, body = plant.channels, plant.joint_parameters[0], plant.joint[0]
    p, w = plant.parameters, plant.wire_parameters
    volume = p["dead_volume"] + p["area"] * (p["stroke"] - s["extension"])
    anchors = np.stack([w["anchor_x"], w["anchor_y"], w["anchor_z"]], 1)
    matrix = np.array(plant.ring_rotation())
    adjusts = np.stack([w["adjust_x"], w["adjust_y"], w["adjust_z"]], 1)
    lengths = exact_lengths(anchors @ matrix.T, adjusts, q["ball_radius"])
    stretch = np.maximum(lengths - w["free"] - s["extension"], 0.0)
    pushed_in = np.maximum(np.maximum(-s["extension"], s["extension"] - p["stroke"]), 0.0)
    total = np.sum(
        s["pressure"] * volume / 0.2
        + ATMOSPHERE * volume
        + 0.5 * p["mass"] * s["speed"] ** 2
        + 0.5 * p["bristle_stiffness"] * s["bristle"] ** 2
        + 0.5 * p["wire_stiffness"] * stretch**2
        + 0.5 * p["stop_stiffness"] * pushed_in**2
        + 0.5 * w["stiffness"] * plant.wires["bristle"] ** 2
    )
    rate = np.array([body["rate_x"], body["rate_y"], body["rate_z"]])
    seat = np.array([body["seat_x"], body["seat_y"], body["seat_z"]])
    axis = matrix[:, 2]
    total += 0.5 * q["inertia_tilt"] * (rate @ rate - (axis @ rate) ** 2)
    total += 0.5 * q["inertia_spin"] * (axis @ rate) ** 2
    total += 0.5 * q["seat_stiffness"] * seat @ seat
    total += q["weight"] * q["centre_height"] * axis[2]
    tilt = math.atan2(math.hypot(axis[0], axis[1]), axis[2])
    total += 0.5 * q["stop_stiffness"] * max(tilt - q["tilt_stop"], 0.0) ** 2
    return float(total)


def exact_lengths(ends, adjusts, radius):
    """Return exact wire lengths of any geometry, m: tangents and the arc between them."""
    a, b = np.linalg.norm(ends, axis=1), np.linalg.norm(adjusts, axis=1)
    psi = np.arctan2(
        np.linalg.norm(np.cross(ends, adjusts), axis=1), np.sum(ends * adjusts, axis=1)
    )
    to_a = np.sqrt(np.maximum(a**2 - radius**2, 0.0))
    to_b = np.sqrt(b**2 - radius**2)
    wrapped = psi - np.arctan2(to_a, radius) - np.arctan2(to_b, radius)
    straight = np.linalg.norm(ends - adjusts, axis=1)
    return np.where(wrapped > 0.0, to_a + to_b + radius * wrapped, straight)
