"""What every plant does: the same seed gives the same physics, and its truth has names."""

import math

import pytest

from rig.assembly import REGISTRY
from rig.assembly.simulated import make_plant
from rig.hal import Plant
from rig.hal.offers import lacking
from rig.testing.of_experiment import OfExperiment
from rig.testing.rehearsal import Rehearsal, rehearse


class PlantSuite(OfExperiment):
    """The plant of an experiment's rig."""

    @pytest.fixture
    def plant(self, rehearsal: Rehearsal) -> Plant:
        """Return a plant that nobody has touched."""
        made: Plant = make_plant(rehearsal.plan.profile)
        return made

    def test_it_offers_all_that_the_simulation_asks_for(self, plant: Plant) -> None:
        assert lacking(plant, Plant) == ()

    def test_its_settings_are_known(self, rehearsal: Rehearsal) -> None:
        entry = rehearsal.plan.profile.plant
        assert entry is not None
        assert isinstance(entry.settings, REGISTRY.settings("plant", entry.model))

    def test_its_truth_has_a_value_for_each_column(
        self, plant: Plant, rehearsal: Rehearsal
    ) -> None:
        names = [name for name, _ in plant.truth_columns]
        assert len(set(names)) == len(names)
        assert len(plant.truth()) == len(names)
        for row in rehearsal.truth:
            assert len(row) == len(names)
            assert not any(math.isnan(value) for value in row)

    def test_the_same_seed_gives_the_same_physics(self, rehearsal: Rehearsal) -> None:
        again = rehearse(self.configs, self.experiment, self.options)
        assert again.truth == rehearsal.truth

    def test_its_channels_have_names_of_their_own(self, plant: Plant) -> None:
        assert plant.channel_names
        assert len(set(plant.channel_names)) == len(plant.channel_names)

    def test_its_row_says_the_same_channels(self, plant: Plant, rehearsal: Rehearsal) -> None:
        entry = rehearsal.plan.profile.plant
        assert entry is not None
        assert REGISTRY.plant_channels(entry.model) in ((), plant.channel_names)

    def test_a_fault_that_it_does_not_know_is_refused(self, plant: Plant) -> None:
        with pytest.raises(ValueError, match="no fault 'nonsense'"):
            plant.inject("nonsense")

    def test_the_past_is_left_alone(self, plant: Plant) -> None:
        plant.advance(0.02)
        before = plant.truth()
        plant.advance(0.01)
        assert plant.truth() == before
