"""What is true of the friction of a simulated joint's pairs, by an algebra of its own.

Breakaway is what the plant's own contacts take in a tug of its own, without controller, noise or
anything that an earlier tug has left: from home, with regulators that follow without error, after
all four pressures have swung until nothing is held in the wires. It is the sum of what seals and
ball take of the pulls and of the seat's torque, so that a ring that leans adds nothing to it, and
its greatest value on average over 21 ms before the pair is 5 mm/s fast.

At home a pair's wires pull with the ball's radius for their lever. While the ring leans evenly
between its pairs, the wire of rod a is pulled in as fast as that of rod b is let out, so that with
the chambers' pulls A and B, the rods' friction f, and what the ball leaves of a wire's pull,

    exp(-m_a) (A - f_a) - exp(m_b) (B + f_b) = s sqrt(1/2) (W + all four wires at the ring) / r,

where a rod's friction is c + v b and grows with its pressure, m is a wire's coefficient times how
far it is wound, s the seat's arm, and W the ring's weight. This is linear in the pulls. On the way
back the rods have changed places; what a pair shows in the mean of both ways is true of it.
"""

import math
from dataclasses import replace

import numpy as np

from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.spherical_joint_wire import wire_path
from rig.assembly.simulated import make_plant

DRAWN = {"joint friction": ("simulation.perturbation.friction=0.3",)}
_MOST_SEALS = 0.2
"""Of what grows with the tensions: an interval takes the seals' share to lie anywhere up to it."""
PAIRS = (("pair 1-3", 0, 2), ("pair 4-2", 3, 1))
_FULL, _SWUNG, _REST = 0.5, 2.0, 0.5
"""Until the chambers are full, and for how long their pressures swing and rest, s."""
_ENDS = ("anchor_x", "anchor_y", "anchor_z", "adjust_x", "adjust_y", "adjust_z")


def pulls_of(plant, sums, speed, pairs=PAIRS):
    """Return the chambers' pulls (N) that slide both pairs at a speed, given their sums."""
    units, wires, joint = plant.parameters, plant.wire_parameters, plant.joint_parameters[0]
    radius = joint["ball_radius"]
    wound = [wire_path(*wires[list(_ENDS)][k].item(), radius)[1] for k in range(4)]
    rows, right = [], []
    # How the pull at the ring comes from that of the chamber: R = g P + h.
    at_ring = {}
    for _, a, b in pairs:
        for k, sign in ((a, -1.0), (b, 1.0)):
            capstan = math.exp(sign * wires["friction"][k] * wound[k])
            grown = units["pressure_friction"][k] / units["area"][k]
            still = units["coulomb"][k] + units["viscous"][k] * speed
            at_ring[k] = capstan * (1.0 + sign * grown), capstan * sign * still
    seat = joint["seat_arm"] * math.sqrt(0.5) / radius
    for (_, a, b), total in zip(pairs, sums, strict=True):
        row = np.array([-seat * at_ring[k][0] for k in range(4)])
        row[a] += at_ring[a][0]
        row[b] -= at_ring[b][0]
        rows.append(row)
        load = joint["weight"] + sum(offset for _, offset in at_ring.values())
        right.append(seat * load - at_ring[a][1] + at_ring[b][1])
        rows.append(np.array([float(k in (a, b)) for k in range(4)]))
        right.append(total)
    return np.linalg.solve(np.array(rows), np.array(right))


def drawn_for(profile, seed):
    """Return the options that let lie what the intervals hold as open.

    These are the seals' share of what grows with the tensions, the ring's part in the ball's
    friction, which wires make up for, and the wires' stiffness.
    """
    rng = np.random.default_rng([seed, 7])
    share = rng.uniform(0.0, _MOST_SEALS)
    name = f"friction.{PAIRS[0][0]}.load"
    settings, tolerance = profile.plant.settings, profile.mechanism_settings.tolerance

    def growth(**scales):
        other = replace(profile, plant=replace(profile.plant, settings=replace(settings, **scales)))
        return true_of_sliding(other)[profile.mechanism, name]

    none = growth(seal_load_scale=0.0)
    ring = none - growth(seal_load_scale=0.0, ring_friction_scale=0.0)
    more = rng.uniform(-1.0, 1.0) * tolerance.friction
    stiffness = settings.wire.stiffness * (1.0 + tolerance.stiffness * rng.standard_normal())
    seals = growth() - none
    drawn = {
        "seal_load_scale": share / (1.0 - share) * none / seals,
        "ring_friction_scale": 1.0 + more,
        "wire_friction_scale": 1.0 - more * ring / (none - ring),
        "wire.stiffness": stiffness,
    }
    return tuple(f"plant.{name}={value:.6g}" for name, value in drawn.items())


def true_of_sliding(profile):
    """Return Coulomb and viscous friction at base pressure, and what grows with the tensions."""
    plant = make_plant(profile)
    usual = 2.0 * plant.parameters["area"][0] * profile.mechanism_settings.base_pressure

    def forces(total, speed):
        ways = []
        for pairs in (PAIRS, [(name, b, a) for name, a, b in PAIRS]):
            pulls = pulls_of(plant, (total, total), speed, pairs)
            ways.append([pulls[a] - pulls[b] for _, a, b in pairs])
        return np.mean(ways, axis=0)

    coulomb, grown, viscous = forces(usual, 0.0), forces(1.5 * usual, 0.0), forces(usual, 0.05)
    true = {}
    for k, (name, _, _) in enumerate(PAIRS):
        true |= {
            f"friction.{name}.coulomb": coulomb[k],
            f"friction.{name}.viscous": (viscous[k] - coulomb[k]) / 0.05,
            f"friction.{name}.load": (grown[k] - coulomb[k]) / (0.5 * usual),
        }
    return {(profile.mechanism, name): float(value) for name, value in true.items()}


def true_of_breakaway(profile):
    """Return the mean of the greatest friction to both sides, N, of each pair."""
    base = profile.mechanism_settings.base_pressure
    true = {}
    for name, a, b in PAIRS:
        ways = [greatest(*tug(make_plant(profile), *rods, base)) for rods in ((a, b), (b, a))]
        true[profile.mechanism, f"friction.{name}.breakaway"] = float(np.mean(ways))
    return true


def tug(plant, a, b, base):
    """Return friction (N) and way (m), each ms, of a pair whose rod a is pulled in by 20 N/s."""
    area, radius = plant.parameters["area"][0], plant.joint_parameters["ball_radius"][0]
    ends = [plant.wire_parameters[list(_ENDS)][k].item() for k in range(4)]
    arms = np.array([wire_path(*end, radius)[2:] for end in ends])
    about = (arms[a] - arms[b]) / np.linalg.norm(arms[a] - arms[b])
    lever = 0.5 * (arms[a] - arms[b]) @ about
    plant.parameters["bow"] = plant.parameters["hysteresis"] = 0.0
    plant.parameters["dead_band"] = 1.0
    plant.set_supply(True)
    rows, k, force = [], 0, 0.0
    while force < 80.0 and (not rows or rows[-1][1] < 1e-3):
        t, k = 1e-3 * k, k + 1
        swung = np.interp(t, (_FULL, _FULL + _SWUNG), (0.5, 0.0), left=0.0)
        swing = 1.0 + swung * math.sin(8.0 * math.tau * (t - _FULL))
        force = 20.0 * max(t - _FULL - _SWUNG - _REST, 0.0)
        for channel in range(4):
            pressure = base * swing * min(t / _FULL, 1.0)
            pressure += (float(channel == a) - float(channel == b)) * 0.5 * force / area
            plant.set_pressure_setpoint(channel, pressure)
        plant.advance(t + 1e-3)
        out = plant.channels["extension"].copy()
        if force == 0.0:
            start = out
            continue
        pulls = (plant.channels["pressure"] - ATMOSPHERE) * area
        left = plant.wires["tension"]
        turned = np.array(plant.ring_rotation())
        seat = sum(
            pull * np.array(wire_path(*(turned @ end[:3]), *end[3:], radius)[2:])
            for pull, end in zip(left, ends, strict=True)
        )
        taken = pulls[a] - left[a] + left[b] - pulls[b] + seat @ about / lever
        rows.append((taken, 0.5 * (start[a] - out[a] + out[b] - start[b])))
    return np.array(rows).T


def greatest(friction, way):
    """Return the greatest friction on average over 21 ms before the pair is 5 mm/s fast, N."""
    bump = np.hanning(23)[1:-1] ** 2
    friction, way = (np.convolve(x, bump / bump.sum(), "valid") for x in (friction, way))
    fast = (np.gradient(way, 1e-3) > 5e-3) & (way > 0.15e-3)
    return friction[: np.flatnonzero(fast)[0]].max()


def true_of_joint_friction(profile, seed, procedure, folders):
    """Return everything that is true of the pairs."""
    return true_of_sliding(profile) | true_of_breakaway(profile)


TRUE = {"joint friction": true_of_joint_friction}
