"""One antagonistic pair: two cylinders with regulators that pull a carriage by wires."""

import math

import numpy as np

from drivers.sim.plants.channel import (
    PARAMETERS,
    REGULATING,
    STATE,
    STUCK,
    STUCK_CLOSED,
    STUCK_OPEN,
)
from drivers.sim.plants.pair_kernel import PAIR_PARAMETERS, PAIR_STATE, advance_pair
from drivers.sim.plants.parameters import draw_channel, scale_seals
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.regulator import quantize
from drivers.sim.plants.settings import PlantSettings

_NOISE_BLOCK = 4096
"""Monitor samples drawn at a time: numpy's cost per call is spread over them."""

_MODES = {
    "regulator_stuck": STUCK,
    "regulator_open": STUCK_OPEN,
    "regulator_closed": STUCK_CLOSED,
}

_EXTENSION, _SPEED, _PRESSURE, _TENSION = (
    list(STATE.names or ()).index(name) for name in ("extension", "speed", "pressure", "tension")
)
_SUPPLY, _POSITION, _CARRIAGE_SPEED = (
    list(PAIR_STATE.names or ()).index(name) for name in ("supply", "position", "speed")
)


class AntagonisticPairPlant:
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

    channel_names = ("agonist", "antagonist")

    known_faults = (*_MODES, "leak", "wire_cut", "supply_lost", "repair")
    """What `inject` understands."""

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

    def __init__(self, settings: PlantSettings, seed: int) -> None:
        self.settings = settings
        units, monitors = np.random.default_rng(seed).spawn(2)
        self._full_scale = settings.regulator.full_scale
        self._codes = float(2**settings.regulator.dac_bits - 1)
        self._dt = settings.substep
        self._steps = 0

        seals = scale_seals(settings.seals, settings.friction_scale)
        self.parameters = np.zeros(2, PARAMETERS)
        for channel in range(2):
            self.parameters[channel] = draw_channel(
                units,
                regulator=settings.regulator,
                cylinder=settings.cylinder,
                wire=settings.wire,
                seals=seals,
                friction_spread=settings.friction_spread,
            )
        seat = seals.seat * (1.0 + settings.friction_spread * units.uniform(-1.0, 1.0))
        self.pair_parameters = np.zeros(1, PAIR_PARAMETERS)
        self.pair_parameters[0] = (
            settings.regulator.supply_time,
            settings.home,
            settings.carriage.mass,
            seat,
            settings.carriage.seat_stiffness,
            settings.carriage.seat_damping,
        )

        self.channels = np.zeros(2, STATE)
        self.channels["pressure"] = ATMOSPHERE
        self.channels["extension"] = settings.home
        self.pair = np.zeros(1, PAIR_STATE)
        self.pair["supply"] = self.pair["supply_target"] = ATMOSPHERE
        self._channel_values = self.channels.view(float).reshape(2, -1)
        self._pair_values = self.pair.view(float)
        self._supply_open = False
        self._supply_pressure = settings.regulator.supply_pressure

        self._monitors = monitors
        self._noise: list[list[float]] = []
        self._sample = _NOISE_BLOCK
        self._next_noise()
        self._advance = advance_pair

    @property
    def time(self) -> float:
        """How far the plant has been integrated, s."""
        return self._steps * self._dt

    def advance(self, t: float) -> None:
        """Integrate to the last substep that is not after `t` (s); the past is left alone."""
        steps = int(t / self._dt + 1e-6) - self._steps
        if steps <= 0:
            return
        self._advance(
            self.channels, self.parameters, self.pair, self.pair_parameters, steps, self._dt
        )
        self._steps += steps
        self._next_noise()

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Take a setpoint, Pa gauge; the converter saturates and quantises it.

        Raises
        ------
        ValueError
            The setpoint is not a finite number: no converter can put it out.
        """
        if not math.isfinite(pressure):
            raise ValueError(f"plant: channel {channel} cannot take the setpoint {pressure}")
        self.channels[channel]["setpoint"] = quantize(pressure, self._full_scale, self._codes)

    def set_supply(self, open: bool) -> None:
        """Open the supply valve, or close it: it then vents the line and the regulators."""
        self._supply_open = open
        self._connect_supply()

    def pressure(self, channel: int) -> float:
        """Return what the regulator's monitor puts out, Pa gauge: the chamber and its noise."""
        true: float = self._channel_values.item(channel, _PRESSURE)
        return true - ATMOSPHERE + self._noise[self._sample][channel]

    def position(self, channel: int) -> float:
        """Return the true extension of a rod, m."""
        value: float = self._channel_values.item(channel, _EXTENSION)
        return value

    def speed(self, channel: int) -> float:
        """Return the true speed of a rod's extension, m/s."""
        value: float = self._channel_values.item(channel, _SPEED)
        return value

    def truth(self) -> tuple[float, ...]:
        """Return what no device measures, as `truth_columns` names it."""
        agonist, antagonist = self._channel_values.tolist()
        pair = self._pair_values
        return (
            pair.item(_POSITION),
            pair.item(_CARRIAGE_SPEED),
            agonist[_EXTENSION],
            antagonist[_EXTENSION],
            agonist[_PRESSURE] - ATMOSPHERE,
            antagonist[_PRESSURE] - ATMOSPHERE,
            agonist[_TENSION],
            antagonist[_TENSION],
            pair.item(_SUPPLY) - ATMOSPHERE,
        )

    def inject(self, fault: str, value: float | None = None) -> None:
        """Break or repair something now.

        Parameters
        ----------
        fault : str
            ``regulator_stuck`` (holds its pressure), ``regulator_open``, ``regulator_closed``,
            ``leak`` (the chamber's tube is off) and ``wire_cut``, each with a channel as its
            value; ``supply_lost`` with the pressure that remains, Pa gauge; ``repair`` ends
            all of them.
        value : float, optional
            As said above; 0 if not given.

        Raises
        ------
        ValueError
            There is no such fault or channel, or the pressure is negative or not finite.
        """
        number = 0.0 if value is None else value
        if fault == "repair":
            self._repair()
        elif fault == "supply_lost":
            if not 0.0 <= number < math.inf:
                raise ValueError(f"plant: supply_lost leaves {number:g} Pa; 0 or more is needed")
            self._supply_pressure = number
            self._connect_supply()
        elif fault not in self.known_faults:
            raise ValueError(f"plant: no fault {fault!r}; known are {', '.join(self.known_faults)}")
        elif number not in (0, 1):
            raise ValueError(f"plant: {fault} takes channel 0 or 1, not {number:g}")
        else:
            self._break_channel(fault, int(number))

    def _break_channel(self, fault: str, channel: int) -> None:
        if fault == "leak":
            self.channels[channel]["leak"] = self.settings.leak
        elif fault == "wire_cut":
            self.parameters[channel]["wire_stiffness"] = 0.0
            self.parameters[channel]["wire_damping"] = 0.0
        else:
            self.channels[channel]["mode"] = _MODES[fault]

    def _repair(self) -> None:
        self.channels["mode"] = REGULATING
        self.channels["leak"] = 0.0
        self.parameters["wire_stiffness"] = self.settings.wire.stiffness
        self.parameters["wire_damping"] = self.settings.wire.damping
        self._supply_pressure = self.settings.regulator.supply_pressure
        self._connect_supply()

    def _connect_supply(self) -> None:
        gauge = self._supply_pressure if self._supply_open else 0.0
        self.pair["supply_target"] = ATMOSPHERE + gauge

    def _next_noise(self) -> None:
        self._sample += 1
        if self._sample >= _NOISE_BLOCK:
            rms = self.settings.regulator.monitor_noise * self._full_scale
            self._noise = (rms * self._monitors.standard_normal((_NOISE_BLOCK, 2))).tolist()
            self._sample = 0
