"""One antagonistic pair: two cylinders with regulators that pull a carriage by wires."""

import math
from typing import ClassVar

import numpy as np

from drivers.sim.plants.lending import Kernel, Lending, Memory
from drivers.sim.plants.pair_kernel import (
    PAIR_PARAMETERS,
    PAIR_STATE,
    advance_pair,
    tell_pair,
)
from drivers.sim.plants.parameters import scale_seals
from drivers.sim.plants.pneumatic_plant import (
    EXTENSION,
    PRESSURE,
    TENSION,
    WIDTH,
    Array,
)
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.push import Push
from drivers.sim.plants.regulator_plant import RegulatorPlant
from drivers.sim.plants.settings import (
    CarriageSettings,
    CylinderPlantSettings,
    PlantSettings,
    SealFriction,
)

_SUPPLY, _POSITION, _CARRIAGE_SPEED = (
    list(PAIR_STATE.names or ()).index(name) for name in ("supply", "position", "speed")
)


def stop_damping(carriage: CarriageSettings) -> float:
    """Return the damping (N s/m) with which a carriage comes back from a stop as it should.

    References
    ----------
    Schwager and Pöschel, "Coefficient of restitution and linear-dashpot model revisited", Granular
    Matter 9 (2007): a stop that pushes and never pulls lets go before its spring is at rest.
    """
    low, high = 0.0, 1.0
    for _ in range(50):
        ratio = 0.5 * (low + high)
        turn = math.sqrt(1.0 - ratio * ratio)
        angle = math.pi - math.atan2(2.0 * ratio * turn, turn * turn - ratio * ratio)
        if math.exp(-ratio / turn * angle) > carriage.restitution:
            low = ratio
        else:
            high = ratio
    return 2.0 * low * math.sqrt(carriage.stop_stiffness * carriage.mass)


def pair_parameters(
    settings: CylinderPlantSettings,
    carriage: CarriageSettings,
    seals: SealFriction,
    units: np.random.Generator,
) -> Array:
    """Return the `PAIR_PARAMETERS` of a carriage and supply line, the seat's friction drawn."""
    seat = seals.seat * (1.0 + settings.friction_spread * units.uniform(-1.0, 1.0))
    parameters = np.zeros(1, PAIR_PARAMETERS)
    parameters[0] = (
        settings.feed.supply_time,
        settings.feed.supply_volume,
        settings.home,
        carriage.mass,
        seat,
        carriage.seat_stiffness,
        carriage.seat_damping,
        min(settings.home, settings.cylinder.stroke - settings.home),
        carriage.stop_stiffness,
        stop_damping(carriage),
    )
    return parameters


class PairTruth:
    """The truth about a pair of `PneumaticPlant`."""

    channel_names: ClassVar[tuple[str, ...]] = ("agonist", "antagonist")

    truth_columns = (
        ("position", "m"),
        ("velocity", "m/s"),
        ("extension_agonist", "m"),
        ("extension_antagonist", "m"),
        ("pressure_agonist", "Pa"),
        ("pressure_antagonist", "Pa"),
        ("tension_agonist", "N"),
        ("tension_antagonist", "N"),
        ("supply", "Pa"),
    )
    """Names and units of `truth`."""

    pair: Array
    _cells: "memoryview[float]"

    def truth(self) -> tuple[float, ...]:
        """Return what no device measures, as `truth_columns` names it."""
        cells, pair = self._cells, self.pair.view(float)
        return (
            pair.item(_POSITION),
            pair.item(_CARRIAGE_SPEED),
            cells[EXTENSION],
            cells[WIDTH + EXTENSION],
            cells[PRESSURE] - ATMOSPHERE,
            cells[WIDTH + PRESSURE] - ATMOSPHERE,
            cells[TENSION],
            cells[WIDTH + TENSION],
            pair.item(_SUPPLY) - ATMOSPHERE,
        )


class AntagonisticPairPlant(PairTruth, RegulatorPlant):
    """Physics of one antagonistic pair, integrated at 20 kHz.

    It starts at rest at home, vented and with the supply closed: nothing moves before
    ``set_supply(True)`` and a setpoint.

    Parameters
    ----------
    settings : PlantSettings
        Nominal parameters.
    seed : int
        Of the units' deviations and of the monitors' noise: equal seeds give equal runs.
    """

    Settings = PlantSettings

    def __init__(self, settings: PlantSettings, seed: int) -> None:
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
        return self.lend_kernel((advance_pair, tell_pair), bodies, timing)

    def _integrate(self, steps: int) -> None:
        advance_pair(
            self.channels,
            self.parameters,
            self.queues,
            self.pair,
            self.pair_parameters,
            steps,
            self._dt,
        )
