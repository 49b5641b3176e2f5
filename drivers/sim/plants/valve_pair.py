"""One antagonistic pair on proportional valves, with a pressure sensor at each chamber."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from drivers.sim.plants.antagonistic_pair import PairTruth, pair_parameters
from drivers.sim.plants.channel import STATE, STUCK, STUCK_CLOSED, STUCK_OPEN
from drivers.sim.plants.lending import Kernel, Lending, Memory
from drivers.sim.plants.pair_kernel import PAIR_STATE, tell_pair
from drivers.sim.plants.parameters import scale_seals
from drivers.sim.plants.pneumatic_plant import WIDTH, PneumaticPlant, Units
from drivers.sim.plants.push import Push
from drivers.sim.plants.regulator import quantize
from drivers.sim.plants.settings import SealFriction
from drivers.sim.plants.spool import SPOOL_PARAMETERS, draw_spool
from drivers.sim.plants.valve_kernel import advance_valve_pair
from drivers.sim.plants.valve_settings import ValvePairSettings, stroke_steps

_SLOWER, _OFF, _LEAK = 2.0, 0.05, 4e-10
"""How much slower a spool gets, how far off its middle, and what leaks past it (m³/(s Pa)), unless
it is said."""
_SETPOINT = list(STATE.names or ()).index("setpoint")
_EXHAUSTED = -1.0


class ValvePairPlant(PairTruth, PneumaticPlant):
    """Physics of one antagonistic pair on proportional valves, integrated at 20 kHz.

    It starts at rest at home, exhausted and with the supply closed. Faults of the valves:
    ``valve_stuck`` (the spool stands still), ``valve_open`` (it goes to the feed) and
    ``valve_closed`` (to the middle), each with a channel as its value; by channel ``valve_stuck``
    (at this opening), ``valve_slow`` (factor on the spool's time, default 2), ``valve_offset``
    (of its middle, an opening, default 0.05) and ``valve_leak`` (from the supply past the spool,
    m³/(s Pa), default a tenth of the port).

    Parameters
    ----------
    settings : ValvePairSettings
        Nominal parameters.
    seed : int
        Of the units' deviations and of the sensors' noise: equal seeds give equal runs.
    """

    Settings = ValvePairSettings

    modes: ClassVar[Mapping[str, float]] = {
        "valve_stuck": STUCK,
        "valve_open": STUCK_OPEN,
        "valve_closed": STUCK_CLOSED,
    }
    wear = ("valve_stuck", "valve_slow", "valve_offset", "valve_leak")
    signed = ("valve_stuck",)

    _common: ValvePairSettings

    def __init__(self, settings: ValvePairSettings, seed: int) -> None:
        self.settings = settings
        units, monitors = np.random.default_rng(seed).spawn(2)
        seals = scale_seals(settings.seals, settings.friction_scale, settings.stribeck_scale)
        self.pair = np.zeros(1, PAIR_STATE)
        push = Push(self.pair["push"], {"along": (1.0,)}, "carriage_push")
        super().__init__(settings, seals, units=units, monitors=monitors, line=self.pair, push=push)
        self.pair_parameters = pair_parameters(settings, settings.carriage, seals, units)

    def set_opening(self, channel: int, opening: float) -> None:
        """Take the signal of a spool, -1 … 1; the converter saturates and quantises it.

        Raises
        ------
        ValueError
            It is not a finite number: no converter can put it out.
        """
        if not math.isfinite(opening):
            raise ValueError(f"plant: channel {channel} cannot take the opening {opening}")
        output = quantize(opening + 1.0, 2.0, self._codes) - 1.0
        self._cells[WIDTH * channel + _SETPOINT] = output

    def lend(
        self, period: float, rod_step: float, pressure_step: float, seed: int
    ) -> tuple[Kernel, Memory]:
        """Return its kernel; see `rig.hal.plant.LendingPlant`. The axis is the carriage."""
        bodies = (self.channels, self.parameters, self.queues, self.pair, self.pair_parameters)
        timing = Lending(period, rod_step, pressure_step, seed)
        return self.lend_kernel((advance_valve_pair, tell_pair), bodies, timing)

    def _draw_units(
        self, units: np.random.Generator, reality: np.random.Generator, seals: SealFriction
    ) -> Units:
        settings, valve = self._common, self._common.valve
        count = len(self.channel_names)
        late = valve.dead_time * (1.0 + valve.dead_time_spread * reality.uniform(-1.0, 1.0, count))
        dead_steps = np.rint(late / self._dt)
        parameters = np.zeros(count, SPOOL_PARAMETERS)
        for channel in range(count):
            parameters[channel] = draw_spool(
                units,
                valve=valve,
                cylinder=settings.cylinder,
                wire=settings.wire,
                seals=seals,
                friction_spread=settings.friction_spread,
                dead_steps=dead_steps[channel],
            )
        self._built = parameters.copy()
        self._codes = stroke_steps(valve)
        channels = np.zeros(count, STATE)
        queues = np.full((count, max(1, int(dead_steps.max()))), _EXHAUSTED)
        for spool in ("setpoint", "play", "opening"):
            channels[spool] = _EXHAUSTED
        return Units(parameters, channels, queues)

    @property
    def _converter(self) -> tuple[float, float, float]:
        return -1.0, 2.0, self._codes

    def _is_filtered(self) -> bool:
        return True

    def _wear_feed(self, fault: str, channel: int, value: float | None) -> None:
        own, built = self.parameters[channel], self._built[channel]
        if fault == "valve_slow":
            own["bandwidth"] = built["bandwidth"] / (value or _SLOWER)
        elif fault == "valve_offset":
            own["zero"] = built["zero"] + (_OFF if value is None else value)
        elif fault == "valve_leak":
            own["past"] = _LEAK if value is None else value
        else:
            if value is not None:
                self.channels[channel]["opening"] = min(max(value, -1.0), 1.0)
            self._set_mode(channel, STUCK)

    def _repair(self) -> None:
        super()._repair()
        for name in ("bandwidth", "zero", "past"):
            self.parameters[name] = self._built[name]

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
