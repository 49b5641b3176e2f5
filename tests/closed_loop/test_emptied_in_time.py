"""A chamber as full as it may be is empty by when a rig begins to believe that it is."""

from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend, build_rig
from rig.experiment.plan import load_plan
from rig.mechanisms.pneumatic.mechanism import PneumaticMechanism

CONFIGS = Path(__file__).parents[2] / "configs"
EMPTY = 20e3
"""Pa gauge."""


@pytest.mark.parametrize(
    "experiment", ["cylinder-sine", "joint-circle", "cylinder-sine-10mm", "cylinder-valves-sine"]
)
@pytest.mark.parametrize("seed", np.random.default_rng(8).integers(0, 10_000, 2).tolist())
def test_the_fullest_chamber_is_empty_by_then_and_was_not_at_once(experiment, seed):
    blind = ["joint.camera=null"] if experiment.startswith("joint") else []
    plan = load_plan(experiment, [f"simulation.seed={seed}", *blind], configs=CONFIGS)
    settings = plan.profile.mechanism_settings
    with build_rig(plan.profile, Backend.SIM) as rig:
        rig.devices.pop("camera", None)
        mechanism = rig.mechanism
        assert isinstance(mechanism, PneumaticMechanism)
        regulators = mechanism._regulators
        count, full = len(mechanism.channels), settings.limits.pressure[1]
        plant = rig.clock.world
        period = plan.profile.loop.period

        def follow(seconds, safe):
            for _ in range(round(seconds / period)):
                now = rig.clock.now()
                for device in rig.devices.values():
                    device.check(now)
                    if safe:
                        device.make_safe()
                if not safe:
                    regulators.set_pressure((full,) * count)
                rig.clock.sleep_until(now + period)

        rig.arm()
        follow(1.5, safe=False)
        columns = [column.name for column in rig.truth_columns]
        places = [columns.index(f"truth.pressure_{channel}") for channel in mechanism.channels]

        def fullest():
            return max(plant.truth()[place] for place in places)

        assert fullest() > 0.9 * full
        follow(0.005, safe=True)
        assert fullest() > EMPTY
        follow(mechanism.venting_time - 0.005, safe=True)
        assert fullest() < EMPTY
