"""What is true of simulated arms and legs that are calibrated, and what is drawn for each."""

from dataclasses import asdict

from drivers.sim.perturbation import draw
from rig.assembly.simulated import make_plant

# Coarser steps and fewer poses say the same of the intervals for less.
_ARM = (
    "simulation.perturbation.joint_zero=2 deg",
    "simulation.perturbation.joint_reversed=0.2",
    "simulation.perturbation.link_length=2 mm",
    "simulation.perturbation.marker=20 um",
    "loop.rate=25", "plant.timestep=2 ms", "arm.limits.reading_age=100 ms",
    "arm.geometry.rate_limits=[1.6, 1.6, 1.6, 2.4, 2.4, 2.4]",
)  # fmt: skip
_LEGS = ("simulation.perturbation.joint_zero=3 deg", "loop.rate=50", "legs.jig.dwell=0.3 s")

DRAWN = {
    "arm zeros": _ARM,
    # Wide poses come after the directions are known.
    "arm links": (*_ARM, "simulation.perturbation.joint_reversed=0", "arm.metrology.poses=14"),
    "legs zeros": _LEGS,
    "legs scale": (
        *_LEGS,
        "simulation.perturbation.joint_scale=0.01",
        "simulation.perturbation.joint_reversed=0.2",
    ),
}


def true_of_drives(profile, seed, procedure, folders):
    """Return offset and scale of every joint: ``shown = ± (1 + scale) angle - zero``."""
    draws = draw(asdict(profile.simulation.perturbation), seed)
    true = {}
    joints = make_plant(profile).channel_names
    for device in profile.mechanism_settings.servos:
        for name in profile.devices[device].settings.joints:
            k = joints.index(name)
            gain = 1.0 + draws.joints.scale[k]
            sign = -1.0 if draws.joints.reversed[k] else 1.0
            true[device, f"{name}.offset"] = draws.channels["joint_zero"][k] / (sign * gain)
            true[device, f"{name}.scale"] = 1.0 / gain
    return true


def true_of_links(profile, seed, procedure, folders):
    geometry = profile.mechanism_settings.geometry
    names = ("a2", "a3", "d6", "base_height", "elbow_offset", "shoulder_offset", "a1")
    lengths = draw(asdict(profile.simulation.perturbation), seed).joints.lengths
    true = {
        ("arm", name): getattr(geometry, name) + error
        for name, error in zip(names, lengths, strict=False)
    }
    return true | true_of_drives(profile, seed, procedure, folders)


TRUE = {
    "arm zeros": true_of_drives,
    "arm links": true_of_links,
    "legs zeros": true_of_drives,
    "legs scale": true_of_drives,
}
