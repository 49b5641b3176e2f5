"""One antagonistic pair on proportional valves, with a pressure sensor at each chamber."""

import numpy as np

from drivers.sim.plants.antagonistic_pair import PairTruth, pair_parameters
from drivers.sim.plants.lending import Kernel, Lending, Memory
from drivers.sim.plants.pair_kernel import PAIR_STATE, tell_pair
from drivers.sim.plants.parameters import scale_seals
from drivers.sim.plants.push import Push
from drivers.sim.plants.valve_kernel import advance_valve_pair
from drivers.sim.plants.valve_plant import ValvePlant
from drivers.sim.plants.valve_settings import ValvePairSettings


class ValvePairPlant(PairTruth, ValvePlant):
    """Physics of one antagonistic pair on proportional valves, integrated at 20 kHz.

    It starts at rest at home, exhausted and with the supply closed. Its faults are those of
    `ValvePlant`.

    Parameters
    ----------
    settings : ValvePairSettings
        Nominal parameters.
    seed : int
        Of the units' deviations and of the sensors' noise: equal seeds give equal runs.
    """

    Settings = ValvePairSettings

    def __init__(self, settings: ValvePairSettings, seed: int) -> None:
        self.settings = settings
        units, monitors = np.random.default_rng(seed).spawn(2)
        seals = scale_seals(settings.seals, settings.friction_scale, settings.stribeck_scale)
        self.pair = np.zeros(1, PAIR_STATE)
        push = Push(self.pair["push"], {"along": (1.0,)}, "carriage_push")
        super().__init__(settings, seals, units=units, monitors=monitors, line=self.pair, push=push)
        self.pair_parameters = pair_parameters(settings, settings.carriage, seals, units)

    def lend(
        self, period: float, rod_step: float, pressure_step: float, seed: int
    ) -> tuple[Kernel, Memory]:
        """Return its kernel; see `rig.hal.plant.LendingPlant`. The axis is the carriage."""
        bodies = (self.channels, self.parameters, self.queues, self.pair, self.pair_parameters)
        timing = Lending(period, rod_step, pressure_step, seed)
        return self.lend_kernel((advance_valve_pair, tell_pair), bodies, timing)

    def _integrate(self, steps: int) -> None:
        advance_valve_pair(
            self.channels,
            self.parameters,
            self.queues,
            self.pair,
            self.pair_parameters,
            steps,
            self._dt,
        )
