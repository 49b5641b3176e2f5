"""What is true of the friction of a simulated joint's pairs, by an algebra of its own.

Breakaway is what other tugs say without noise: how unlike each other they are, an interval has to
hold. There are four times as many of them, so that their mean is known twice as well; they take
longer than the calibration itself, so that every fourth one is asked.

At home a pair's wires pull with the ball's radius for their lever. While the ring leans evenly
between its pairs, the wire of rod a is pulled in as fast as that of rod b is let out, so that with
the chambers' pulls A and B, the rods' friction f, and what the ball leaves of a wire's pull,

    exp(-m_a) (A - f_a) - exp(m_b) (B + f_b) = s sqrt(1/2) (W + all four wires at the ring) / r,

where a rod's friction is c + v b and grows with its pressure, m is a wire's coefficient times how
far it is wound, s the seat's arm, and W the ring's weight. This is linear in the pulls. On the way
back the rods have changed places; what a pair shows in the mean of both ways is true of it.
"""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from drivers.sim.plants.spherical_joint_wire import wire_path
from rig.assembly import Backend
from rig.assembly.simulated import make_plant
from rig.calibration.excitation import Strokes
from rig.calibration.joint.on_ball import belief_of
from rig.calibration.joint.tugs import StrokesAndTugs
from rig.calibration.procedures import joint_friction
from rig.calibration.recording import Recording
from rig.calibration.session import record
from rig.experiment.metrics import evaluation_from_json
from rig.run_folder import EVALUATION, RunFolder
from rig.runtime.log import read_log

DRAWN = {"joint friction": ("simulation.perturbation.friction=0.3",)}
PAIRS = (("pair 1-3", 0, 2), ("pair 4-2", 3, 1))
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


def true_of_breakaway(profile, procedure, out):
    """Return what tugs after another rest say with the chambers' true pressures."""
    usual = joint_friction._settings(profile)
    few = Strokes(usual.strokes.travel, usual.strokes.speeds[-1:], usual.strokes.turn)
    settings = StrokesAndTugs(few, rounds=4, rest=0.45)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(joint_friction, "_settings", lambda _: settings)
        result, folders = record(procedure, profile, Backend.SIM, out)
    assert result.exit_code == 0, result.message
    log = read_log(RunFolder.open(folders[-1]).log_path)
    names = [column.name for column in log.columns]
    values = log.values.copy()
    for channel in ("ch1", "ch2", "ch3", "ch4"):
        # A reading is one cycle old when it is used.
        true = log.values[:-1, names.index(f"truth.pressure_{channel}")]
        values[1:, names.index(f"reading.pressure_{channel}")] = true
    segments, _ = evaluation_from_json(RunFolder.open(folders[-1]).read_json(EVALUATION))
    recording = Recording([(log._replace(values=values), segments)], [Path(folders[-1])])
    for folder in folders:
        shutil.rmtree(folder)
    told = joint_friction._tugs(profile, _belief(profile), recording, settings)
    return {
        (profile.mechanism, f"friction.{name}.breakaway"): float(np.mean([*map(np.mean, sides)]))
        for name, sides in told.items()
    }


def true_of_joint_friction(profile, seed, procedure, folders):
    """Return everything that is true of the pairs, breakaway for every fourth seed."""
    true = true_of_sliding(profile)
    if seed % 4 == 0:
        true |= true_of_breakaway(profile, procedure, folders[-1].parent / "others")
    return true


TRUE = {"joint friction": true_of_joint_friction}


def _belief(profile):
    """Return the plant's friction, to take from a tug what it has because of other tensions."""
    plant = make_plant(profile)
    units, wires, joint = plant.parameters, plant.wire_parameters, plant.joint_parameters[0]
    return belief_of(profile)._replace(
        ring=float(joint["seat_arm"] / joint["ball_radius"]),
        wire=float(wires["friction"].mean()),
        seals=float((units["pressure_friction"] / units["area"]).mean()),
    )
