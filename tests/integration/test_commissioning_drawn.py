"""The first motion of healthy rigs that differ from the shipped one, and of slow regulators."""

import pytest
from drawn_rigs import drawn_pair
from planted import PLANTED
from test_commissioning import find, perform, unit

from rig.assembly import REGISTRY
from rig.commissioning.session import steps_of
from rig.config import find_configs, load_profile


def first_motion(tmp_path, profile):
    skip = [step.name for step in steps_of(profile) if step.name != "first-motion"]
    return perform(tmp_path, profile, skip=skip)[0]


LONG = (
    "cylinder.stroke=80 mm", "cylinder.home=40 mm", "plant.cylinder.stroke=80 mm",
    "plant.home=40 mm", "devices.encoder-agonist.stroke=80 mm",
    "devices.encoder-antagonist.stroke=80 mm",
)  # fmt: skip


@pytest.mark.parametrize("said", [("loop.rate=500",), LONG], ids=["500 Hz", "80 mm"])
def test_another_rate_or_stroke_is_no_slow_regulator(tmp_path, said):
    profile = load_profile("cylinder", REGISTRY, said, find_configs(None))
    assert first_motion(tmp_path, profile) is None


def test_a_drawn_rig_passes_every_step(tmp_path):
    profile = drawn_pair(2)
    stopped, record, _ = perform(tmp_path, profile)
    assert stopped is None
    assert set(record["steps"]) == {step.name for step in steps_of(profile)}


@pytest.mark.parametrize("seed", [1002, 1008])
def test_a_regulator_of_less_than_half_the_bandwidth_is_refused(tmp_path, seed):
    stopped = first_motion(tmp_path, drawn_pair(seed, slower=2.2))
    assert stopped is not None
    assert "regulator" in stopped


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_drawn_healthy_rigs_move_for_the_first_time(tmp_path, seed):
    assert first_motion(tmp_path, drawn_pair(seed)) is None


@pytest.mark.slow
@pytest.mark.lengthy
def test_no_healthy_cylinder_of_a_thousand_is_refused_its_first_motion(tmp_path):
    for seed in range(1000):
        stopped = first_motion(tmp_path, unit("cylinder", seed))
        assert stopped is None, f"seed {seed}: {stopped}"


SOLD = ("cylinder", "cylinder-valves", "joint-real")
"""On regulators as they are sold and mounted, and on valves."""


@pytest.mark.parametrize("rig", SOLD)
def test_a_drawn_rig_on_regulators_as_sold_passes_every_step(tmp_path, rig):
    stopped, record, _ = perform(tmp_path, unit(rig, 4), seed=4)
    assert stopped is None
    assert len(record["digest"]) == 8


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5, 12))
@pytest.mark.parametrize("rig", SOLD)
def test_no_drawn_rig_on_regulators_as_sold_is_refused(tmp_path, rig, seed):
    stopped, _, _ = perform(tmp_path, unit(rig, seed), seed=seed)
    assert stopped is None


@pytest.mark.slow
@pytest.mark.parametrize("plant", PLANTED, ids=lambda plant: plant.__name__)
def test_a_defect_is_found_on_regulators_as_sold(tmp_path, plant):
    find(tmp_path, "cylinder", plant, 1)
