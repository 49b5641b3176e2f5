"""Calibrations of simulated rigs with drawn parameters, and what is true of each of them.

What is true is computed here from the plant's own records, with algebra of its own.
"""

import shutil

import numpy as np
import truth_of_camera
import truth_of_joint_friction
import truth_of_pneumatics
import truth_of_servos

from rig.assembly import REGISTRY, Backend
from rig.calibration.catalogue import procedures
from rig.calibration.recording import Recording
from rig.calibration.session import read_instruments, record
from rig.cli import invoke
from rig.config import find_configs, load_profile

# What is drawn for each procedure, beside what each seed draws anyway (units, noise).
DRAWN = {
    **truth_of_pneumatics.DRAWN,
    **truth_of_joint_friction.DRAWN,
    **truth_of_camera.DRAWN,
    **truth_of_servos.DRAWN,
}
"""By procedure, with the rig's name before it if it is not the cylinder's, and after it what of it
is calibrated already, ``"joint wires after encoders regulators"``."""

LOW_SPEED = ("joint-ideal-low-speed friction", "joint-low-speed friction")
DRAWN_OF_A_FEW = dict.fromkeys(LOW_SPEED, DRAWN["joint friction"])
"""Of what is calibrated a few times alone: bounds that are shares make its intervals wide."""

DRAWN_FOR = {"joint friction": truth_of_joint_friction.drawn_for}
"""What is drawn anew for each profile and seed."""


def calibrated_before(rig, procedures_before, options, out):
    """Calibrate a rig as a person does; return the configurations with what came of it."""
    configs = out / "calibrated"
    shutil.rmtree(configs, ignore_errors=True)
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    words = [word for option in options for word in ("--set", option)]
    places = ["--configs", str(configs), "--out", str(out / "before"), "--on", "sim", "--yes"]
    for procedure in procedures_before:
        assert invoke(["calibrate", rig, procedure, *places, *words]) == 0
    shutil.rmtree(out / "before")
    return configs


def calibrate(procedure, seed, out):
    """Calibrate one simulated rig; return (name, estimate, true value) of each quantity."""
    options = [*(DRAWN | DRAWN_OF_A_FEW)[procedure], f"simulation.seed={seed}"]
    called, _, before = procedure.partition(" after ")
    rig, _, name = called.rpartition(" ")
    configs = find_configs()
    if before:
        configs = [calibrated_before(rig or "cylinder", before.split(), options, out), *configs]
    profile = load_profile(rig or "cylinder", REGISTRY, options, configs)
    if procedure in DRAWN_FOR:
        options += DRAWN_FOR[procedure](profile, seed)
        profile = load_profile(rig, REGISTRY, options, find_configs())
    chosen = procedures(profile)[name]
    if name == "lens":
        findings, folders = truth_of_camera.look_at_boards(chosen, profile, out)
    else:
        result, folders = record(chosen, profile, Backend.SIM, out)
        assert result.exit_code == 0, result.message
        readings = read_instruments(chosen, profile, folders, simulated=True)
        findings = chosen.identify(profile, Recording.of(folders), readings)
    true = TRUE[procedure](profile, seed, chosen, folders)
    rows = [
        (f"{finding.target}:{e.name}", e, true[finding.target, e.name])
        for finding in findings
        for e in finding.estimates
        if (finding.target, e.name) in true
    ]
    for folder in folders:
        shutil.rmtree(folder)
    return rows


TRUE = {
    **truth_of_pneumatics.TRUE,
    **truth_of_joint_friction.TRUE,
    **truth_of_camera.TRUE,
    **truth_of_servos.TRUE,
    **dict.fromkeys(LOW_SPEED, truth_of_joint_friction.true_of_joint_friction),
}


def covered(rows):
    """Return by quantity: how often the interval holds the truth, how often there was one."""
    counts: dict[str, list[int]] = {}
    for name, estimate, true in rows:
        count = counts.setdefault(name, [0, 0])
        count[0] += estimate.low <= true <= estimate.high
        count[1] += 1
    return counts


def normalised(rows):
    """Return by quantity the errors over their stated standard deviations."""
    errors: dict[str, list[float]] = {}
    for name, estimate, true in rows:
        errors.setdefault(name, []).append((estimate.value - true) / estimate.std)
    return {name: np.array(values) for name, values in errors.items()}
