"""Calibrations of simulated rigs with drawn parameters, and what is true of each of them.

What is true is computed here from the plant's own records, with algebra of its own.
"""

import math
import shutil
from pathlib import Path

import numpy as np
import truth_of_camera
import truth_of_servos

from drivers.sim.perturbation import draw
from rig.assembly import REGISTRY, Backend
from rig.assembly.simulated import make_plant
from rig.calibration.catalogue import procedures
from rig.calibration.recording import Recording
from rig.calibration.session import read_instruments, record
from rig.config import find_configs, load_profile
from rig.experiment.metrics import evaluation_from_json
from rig.run_folder import EVALUATION, RunFolder
from rig.runtime.log import read_log

# What is drawn for each procedure, beside what each seed draws anyway (units, noise). Without a
# controller in the loop a slower one gives the same answer for less.
DRAWN = {
    "regulators": (
        "simulation.perturbation.setpoint_gain=0.02",
        "simulation.perturbation.setpoint_offset=3 kPa",
        "simulation.perturbation.monitor_gain=0.01",
        "simulation.perturbation.monitor_offset=2 kPa",
        "loop.rate=100",
    ),
    "encoders": (
        "simulation.perturbation.encoder_scale=0.01",
        "simulation.perturbation.encoder_offset=2 mm",
        "loop.rate=500",
    ),
    "wires": ("simulation.perturbation.wire_offset=2 mm", "loop.rate=100"),
    "response": (),
    "friction": ("simulation.perturbation.friction=0.3",),
    **truth_of_camera.DRAWN,
    **truth_of_servos.DRAWN,
}
"""By procedure, with the rig's name before it if it is not the cylinder's."""


def calibrate(procedure, seed, out):
    """Calibrate one simulated rig; return (name, estimate, true value) of each quantity."""
    options = [*DRAWN[procedure], f"simulation.seed={seed}"]
    rig, _, name = procedure.rpartition(" ")
    profile = load_profile(rig or "cylinder", REGISTRY, options, find_configs())
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


def true_of_regulators(profile, seed, procedure, folders):
    drawn = draw(profile.simulation.perturbation, seed).channels
    units = make_plant(profile).parameters
    true = {}
    for k, channel in enumerate(("agonist", "antagonist")):
        gain = 1.0 + drawn["monitor_gain"][k]
        unit = units[k]
        true |= {
            f"{channel}.setpoint.offset": drawn["setpoint_offset"][k],
            f"{channel}.setpoint.gain": 1.0 + drawn["setpoint_gain"][k],
            f"{channel}.setpoint.linearity": unit["bow"],
            f"{channel}.setpoint.hysteresis": unit["hysteresis"] + 2.0 * unit["dead_band"],
            f"{channel}.monitor.gain": 1.0 / gain,
            f"{channel}.monitor.offset": -drawn["monitor_offset"][k] / gain,
        }
    return {("regulators", name): value for name, value in true.items()}


def true_of_encoders(profile, seed, procedure, folders):
    drawn = draw(profile.simulation.perturbation, seed).channels
    true = {}
    for k, channel in enumerate(("agonist", "antagonist")):
        scale = 1.0 + drawn["encoder_scale"][k]
        true[f"encoder-{channel}", "scale"] = 1.0 / scale
        true[f"encoder-{channel}", "offset"] = -drawn["encoder_offset"][k] / scale
    return true


def true_of_wires(profile, seed, procedure, folders):
    plant = profile.plant.settings
    offset = draw(profile.simulation.perturbation, seed).wire_offset
    pull = _area(plant) * profile.mechanism_settings.base_pressure
    return {
        ("cylinder", "home"): plant.home + offset,
        ("cylinder", "wire.stiffness"): plant.wire.stiffness,
        ("cylinder", "wire.stretch"): pull / plant.wire.stiffness,
    }


def true_of_response(profile, seed, procedure, folders):
    """Return what the same steps say without the monitors' noise and quantisation."""
    return _noiseless(profile, procedure, folders)


def true_of_friction(profile, seed, procedure, folders):
    plant = make_plant(profile)
    units, seat = plant.parameters, plant.pair_parameters[0]["seat"]
    base = profile.mechanism_settings.base_pressure
    loaded = units["pressure_friction"].sum() * base + 2.0 * seat * units["area"][0] * base
    true = {
        ("cylinder", "friction.coulomb"): units["coulomb"].sum() + loaded,
        ("cylinder", "friction.viscous"): units["viscous"].sum(),
    }
    # Seals with little friction do not slip often enough to tell their breakaway.
    breakaway = ("cylinder", "friction.breakaway")
    found = _noiseless(profile, procedure, folders)
    return true | ({breakaway: found[breakaway]} if breakaway in found else {})


TRUE = {
    "regulators": true_of_regulators,
    "encoders": true_of_encoders,
    "wires": true_of_wires,
    "response": true_of_response,
    "friction": true_of_friction,
    **truth_of_camera.TRUE,
    **truth_of_servos.TRUE,
}


def _area(plant):
    return 0.25 * math.pi * (plant.cylinder.bore**2 - plant.cylinder.rod**2)


def _noiseless(profile, procedure, folders):
    """Return what the procedure finds in the same run with the chambers' true pressures."""
    folder = RunFolder.open(folders[-1])
    log = read_log(folder.log_path)
    names = [column.name for column in log.columns]
    values = log.values.copy()
    for channel in ("agonist", "antagonist"):
        true = values[:, names.index(f"truth.pressure_{channel}")].copy()
        # A reading is one cycle old when it is used.
        values[1:, names.index(f"reading.pressure_{channel}")] = true[:-1]
    segments, _ = evaluation_from_json(folder.read_json(EVALUATION))
    recording = Recording([(log._replace(values=values), segments)], [Path(folder.log_path)])
    return {
        (finding.target, e.name): e.value
        for finding in procedure.identify(profile, recording, {})
        for e in finding.estimates
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
