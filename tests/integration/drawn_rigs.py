"""Healthy rigs of one pair, drawn as labs buy them: other cylinders, rates and regulators."""

import math
import random

from planted import drawn_unit

from rig.assembly import REGISTRY
from rig.config import find_configs, load_profile


def drawn_pair(seed, slower=1.0):
    """Return the profile of a rig that was measured well, and whose unit differs as units do.

    Parameters
    ----------
    seed : int
        Of the draw.
    slower : float
        How many times slower the rig's regulators are than its profile says; 1: healthy.
    """
    rng = random.Random(f"pair {seed}")
    rate = rng.choice((500, 640, 800, 1000))  # the shipped gains swing where it is slower
    bore = rng.choice((12e-3, 16e-3, 20e-3, 25e-3))
    stroke = rng.uniform(40e-3, 150e-3)
    home = stroke * rng.uniform(0.35, 0.65)
    side = min(20e-3, 0.7 * min(home, stroke - home))
    bandwidth = rng.uniform(36.0, 60.0)  # the shipped gains bear it
    dead = rng.uniform(3e-3, 8e-3)
    area = bore**2 * math.pi / 4.0
    size = bore / 16e-3  # the seal's rubbing goes with its circumference
    mass = rng.uniform(0.8, 1.5) * 0.138 * size**2
    overrides = {
        "loop.rate": rate,
        "cylinder.bore": bore,
        "cylinder.rod": bore * 0.3125,
        "cylinder.stroke": stroke,
        "cylinder.home": home,
        "cylinder.moving_mass": mass,
        "cylinder.friction.coulomb": 10.4 * size,
        "cylinder.friction.breakaway": 13.4 * size,
        "cylinder.limits.pair_force": 330e3 * area,
        "cylinder.limits.position": f"[{-side}, {side}]",
        "cylinder.limits.reading_age": max(15e-3, 4.0 / rate),
        "cylinder.regulator_response.bandwidth": bandwidth,
        "cylinder.regulator_response.dead_time": dead + 11e-3,  # valve, tube, monitor
        "devices.encoder-agonist.stroke": stroke,
        "devices.encoder-antagonist.stroke": stroke,
        "plant.cylinder.bore": bore,
        "plant.cylinder.rod": bore * 0.3125,
        "plant.cylinder.stroke": stroke,
        "plant.home": home,
        "plant.friction_scale": size,
        "plant.regulator.bandwidth": bandwidth / slower,
        "plant.regulator.dead_time": dead,
        "plant.regulator.repeatability": rng.uniform(0.0, 0.005),
    }
    said = [f"{key}={value}" for key, value in overrides.items()]
    return drawn_unit(load_profile("cylinder", REGISTRY, said, find_configs(None)), seed)
