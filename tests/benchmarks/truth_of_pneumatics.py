"""Calibrations of simulated pneumatic rigs as drawn, and what is true of each of them."""

import math
import shutil
from dataclasses import asdict
from pathlib import Path

import pytest

from drivers.sim.perturbation import draw, perturb_geometry
from drivers.sim.plants.spherical_joint_parameters import home_lengths
from rig.assembly import Backend
from rig.assembly.simulated import make_plant
from rig.calibration.recording import Recording
from rig.calibration.session import record
from rig.experiment.metrics import Evaluation, evaluation_from_json
from rig.mechanisms.cylinder.calibration import friction as pair_friction
from rig.mechanisms.cylinder.calibration.pneumatics import PairPneumatics
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.run_facts import EVALUATION
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

# Without a controller in the loop a slower one gives the same answer for less.
_REGULATORS = (
    "simulation.perturbation.setpoint_gain=0.02",
    "simulation.perturbation.setpoint_offset=3 kPa",
    "simulation.perturbation.monitor_gain=0.01",
    "simulation.perturbation.monitor_offset=2 kPa",
    "loop.rate=100",
)
_ENCODERS = (
    "simulation.perturbation.encoder_scale=0.01",
    "simulation.perturbation.encoder_offset=2 mm",
    "loop.rate=500",
)
_MEASURED = (*_REGULATORS[:-1], *_ENCODERS)
_WIRES = ("simulation.perturbation.wire_offset=2 mm", "loop.rate=100")
_NEARER = "simulation.perturbation.wire_offset=0.5 mm"
"""Rods that disagree by less than `limits.mismatch`: nobody has measured the wires yet."""
_EXACT_MONITORS = "plant.regulator.monitor_error=0"
"""What is told by monitors that nobody has calibrated is told in their own pascals."""
_FRICTION = (
    "simulation.perturbation.friction=0.3",
    "simulation.perturbation.stribeck=0.3",
)
_LEAK = (
    "simulation.perturbation.leak=2e-12 m^3/(s Pa)",
    "simulation.perturbation.friction=0.3",
    "loop.rate=500",
)

DRAWN = {
    "regulators": _REGULATORS,
    "encoders": _ENCODERS,
    "wires": (*_WIRES, _EXACT_MONITORS),
    "wires after encoders regulators": (*_MEASURED, _NEARER),
    "response": (),
    "friction": _FRICTION,
    "cylinder-locked leak": _LEAK,
    "joint-locked leak": _LEAK,
    "joint regulators": _REGULATORS,
    "joint encoders": _ENCODERS,
    # Nobody knows its geometry better when the wires are measured.
    "joint wires": (
        *_WIRES, _EXACT_MONITORS, "plant.wire_offset=0.5 mm",
        "simulation.perturbation.geometry=0.02",
    ),
    "joint wires after encoders regulators": (
        *_MEASURED, _NEARER, "plant.wire_offset=0.5 mm",
        "simulation.perturbation.geometry=0.02",
    ),
    "joint response": (),
}  # fmt: skip


def pneumatics_of(profile):
    return {"cylinder": PairPneumatics, "joint": JointPneumatics}[profile.mechanism](profile)


def true_of_regulators(profile, seed, procedure, folders):
    drawn = draw(asdict(profile.simulation.perturbation), seed).channels
    units = make_plant(profile).parameters
    true = {}
    for k, channel in enumerate(pneumatics_of(profile).channels):
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
    drawn = draw(asdict(profile.simulation.perturbation), seed).channels
    true = {}
    for k, device in enumerate(pneumatics_of(profile).encoders):
        scale = 1.0 + drawn["encoder_scale"][k]
        true[device, "scale"] = 1.0 / scale
        true[device, "offset"] = -drawn["encoder_offset"][k] / scale
    return true


def true_of_wires(profile, seed, procedure, folders):
    plant = profile.plant.settings
    draws = draw(asdict(profile.simulation.perturbation), seed)
    offset = draws.wire_offset
    pull = _area(plant) * profile.mechanism_settings.base_pressure
    homes = {"home": plant.home + offset}
    if profile.mechanism == "joint":
        wires = make_plant(profile).wire_parameters
        joint = perturb_geometry(profile.nominal_settings.geometry, draws)
        lengths = home_lengths(wires, joint.ball_radius)
        own = [long - free for long, free in zip(lengths, wires["free"], strict=True)]
        homes = {"home": sum(own) / len(own)} | {f"home.ch{k + 1}": x for k, x in enumerate(own)}
    return {(profile.mechanism, name): value for name, value in homes.items()} | {
        (profile.mechanism, "wire.stiffness"): plant.wire.stiffness,
        (profile.mechanism, "wire.stretch"): pull / plant.wire.stiffness,
    }


def true_of_response(profile, seed, procedure, folders):
    """Return what the same steps say without the monitors' noise and quantisation."""
    return _noiseless(profile, procedure, folders)


def true_of_friction(profile, seed, procedure, folders):
    """Return the friction that the chambers have to overcome.

    The piston that pulls has more pressure behind it than the other one, and so more friction: the
    seat carries a little less than the chambers' pulls. The breakaway is what glides at other mean
    pressures say without noise: how unlike each other breakaways are, its interval has to hold.
    """
    plant = make_plant(profile)
    units, seat = plant.parameters, plant.pair_parameters[0]["seat"]
    base, area = profile.mechanism_settings.base_pressure, units["area"][0]
    loaded = units["pressure_friction"].sum() * base + 2.0 * seat * area * base
    share = 1.0 / (1.0 + seat * units["pressure_friction"].mean() / area)
    breakaway = ("cylinder", "friction.breakaway")
    return {
        ("cylinder", "friction.coulomb"): share * (units["coulomb"].sum() + loaded),
        ("cylinder", "friction.viscous"): share * units["viscous"].sum(),
        ("cylinder", "friction.stribeck_velocity"): units["stribeck_velocity"][0],
        breakaway: _others(profile, procedure, folders[-1].parent)[breakaway],
    }


def true_of_leak(profile, seed, procedure, folders):
    leaks = draw(asdict(profile.simulation.perturbation), seed).leaks
    channels = pneumatics_of(profile).channels
    return {
        (profile.mechanism, f"leak.{channel}.conductance"): leak
        for channel, leak in zip(channels, leaks, strict=False)
    }


TRUE = {
    "cylinder-locked leak": true_of_leak,
    "joint-locked leak": true_of_leak,
    "regulators": true_of_regulators,
    "encoders": true_of_encoders,
    "wires": true_of_wires,
    "wires after encoders regulators": true_of_wires,
    "response": true_of_response,
    "friction": true_of_friction,
    "joint regulators": true_of_regulators,
    "joint encoders": true_of_encoders,
    "joint wires": true_of_wires,
    "joint wires after encoders regulators": true_of_wires,
    "joint response": true_of_response,
}


def _area(plant):
    return 0.25 * math.pi * (plant.cylinder.bore**2 - plant.cylinder.rod**2)


def _others(profile, procedure, out):
    """Return what glides at other mean pressures say with the chambers' true pressures.

    Began they with the same mean pressure, the first of them would be the very same glides.
    """
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pair_friction, "_BASES", (0.95, 1.15, 0.85, 1.05, 1.0))
        result, folders = record(procedure, profile, Backend.SIM, out / "others")
        assert result.exit_code == 0, result.message
        found = _noiseless(profile, procedure, folders)
    for folder in folders:
        shutil.rmtree(folder)
    return found


def _noiseless(profile, procedure, folders):
    """Return what the procedure finds in the same run with the chambers' true pressures."""
    folder = RunFolder.open(folders[-1])
    log = read_log(folder.log_path)
    names = [column.name for column in log.columns]
    values = log.values.copy()
    for channel in pneumatics_of(profile).channels:
        true = values[:, names.index(f"truth.pressure_{channel}")].copy()
        # A reading is one cycle old when it is used.
        values[1:, names.index(f"reading.pressure_{channel}")] = true[:-1]
    segments, _ = evaluation_from_json(folder.read_json(EVALUATION, Evaluation))
    recording = Recording([(log._replace(values=values), segments)], [Path(folder.log_path)])
    return {
        (finding.target, e.name): e.value
        for finding in procedure.identify(profile, recording, {})
        for e in finding.estimates
    }
