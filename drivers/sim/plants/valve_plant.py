"""What all plants with proportional valves have in common."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from drivers.sim.plants.channel import STATE, STUCK, STUCK_CLOSED, STUCK_OPEN
from drivers.sim.plants.pneumatic_plant import WIDTH, PneumaticPlant, Units
from drivers.sim.plants.regulator import quantize
from drivers.sim.plants.settings import SealFriction
from drivers.sim.plants.spherical_joint_settings import ValveJointSettings
from drivers.sim.plants.spool import SPOOL_PARAMETERS, draw_spool
from drivers.sim.plants.valve_settings import ValvePairSettings, stroke_steps

_SLOWER, _OFF, _LEAK = 2.0, 0.05, 4e-10
"""How much slower a spool gets, how far off its middle, and what leaks past it (m³/(s Pa)), unless
it is said."""
_SETPOINT = list(STATE.names or ()).index("setpoint")
_EXHAUSTED = -1.0


class ValvePlant(PneumaticPlant):
    """Channels with proportional valves and a sensor at each chamber; see `PneumaticPlant`.

    Faults of the valves: ``valve_stuck`` (the spool stands still), ``valve_open`` (it goes to the
    feed) and ``valve_closed`` (to the middle), each with a channel as its value; by channel
    ``valve_stuck`` (at this opening), ``valve_slow`` (factor on the spool's time, default 2),
    ``valve_offset`` (of its middle, an opening, default 0.05) and ``valve_leak`` (from the supply
    past the spool, m³/(s Pa), default a tenth of the port).
    """

    modes: ClassVar[Mapping[str, float]] = {
        "valve_stuck": STUCK,
        "valve_open": STUCK_OPEN,
        "valve_closed": STUCK_CLOSED,
    }
    wear = ("valve_stuck", "valve_slow", "valve_offset", "valve_leak")
    signed = ("valve_stuck",)

    _common: ValvePairSettings | ValveJointSettings

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
