"""Runs of the pair in which something breaks: drawn channel, moment and magnitude."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from rig.assembly import build_rig
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
CHANNELS = ("agonist", "antagonist")


class Drawn(NamedTuple):
    """One fault of one run."""

    at: float
    device: str
    fault: str
    value: float | None
    names: tuple[str, ...]
    """What the message must say."""


def on_plant(fault, low=None, high=None):
    def draw(rng, channel):
        value = None if low is None else rng.uniform(low, high)
        return "plant", f"{CHANNELS[channel]}.{fault}", value, ("regulators", CHANNELS[channel])

    return draw


def off_monitor(low, high):
    def draw(rng, channel):
        value = rng.uniform(low, high) * rng.choice([-1.0, 1.0])
        name = CHANNELS[channel]
        return "plant", f"{name}.monitor_offset", value, ("regulators", name, "monitor")

    return draw


def by_channel(fault, *words):
    def draw(rng, channel):
        return "plant", fault, channel, tuple(word.format(CHANNELS[channel]) for word in words)

    return draw


def on_encoder(fault, low=None, high=None, signed=False):
    def draw(rng, channel):
        value = None if low is None else rng.uniform(low, high)
        if signed:
            value *= rng.choice([-1.0, 1.0])
        name = f"encoder-{CHANNELS[channel]}"
        return name, fault, value, (name,)

    return draw


def supply(rng, channel):
    return "plant", "supply_lost", rng.uniform(0.0, 30e3), ("regulators", "supply pressure is lost")


FAULTS = {
    "tube-off": on_plant("leak", 2e-8, 5e-8),
    "slow": on_plant("regulator_slow", 2.0, 4.0),
    "monitor-off": off_monitor(22e3, 60e3),
    "stuck-held": on_plant("regulator_stuck"),
    "stuck-at": on_plant("regulator_stuck", 50e3, 250e3),
    "stuck-closed": by_channel("regulator_closed", "regulators", "{}"),
    "stuck-open": by_channel("regulator_open", "regulators", "{} is stuck open"),
    "drift": on_encoder("drift", 2e-3, 10e-3, signed=True),
    "frozen": on_encoder("frozen"),
    "mirrored": on_encoder("mirrored"),
    "scale": on_encoder("scale", 1.2, 1.6),
    "supply-lost": supply,
    "wire-cut": by_channel("wire_cut", "the wire of {} is slack or cut"),
    "narrow-tube-off": on_plant("leak", 1.5e-8, 2e-8),
    "small-leak": on_plant("leak", 1e-10, 2e-9),
}


def drawn(kind, seed):
    """Return the fault of a kind that a seed draws: in the sine, after it has begun."""
    rng = np.random.default_rng([seed, list(FAULTS).index(kind)])
    at = rng.uniform(2.2, 4.2)
    return Drawn(at, *FAULTS[kind](rng, int(rng.integers(2))))


def run(folder, backend, fault, seed, more=(), experiment="cylinder-sine"):
    """Return the result, and when it ended after the fault, s of the rig's clock."""
    value = "" if fault.value is None else f", value: {fault.value}"
    what = f"at: {fault.at}, device: {fault.device}, fault: {fault.fault}{value}"
    options = [
        "reference.tones=[{frequency: 0.5 Hz, periods: 3}]",
        "approach=0.5 s",
        "metrics={}",
        "figures=[]",
        f"simulation.seed={seed}",
        f"simulation.faults=[{{{what}}}]",
        *more,
    ]
    plan = load_plan(experiment, options, configs=CONFIGS)
    result = run_experiment(plan, backend, folder, report=False)
    log = read_log(RunFolder.open(result.path).log_path)
    return result, float(log.t[-1]) + start_of(backend) - fault.at


_starts = {}


def start_of(backend):
    """Return the rig's time when the loop begins, s: connecting takes some of it."""
    if backend not in _starts:
        with build_rig(load_plan("cylinder-sine", [], configs=CONFIGS).profile, backend) as rig:
            rig.arm()
            _starts[backend] = rig.clock.now()
    return _starts[backend]
