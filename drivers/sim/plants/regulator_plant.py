"""What all plants with electro-pneumatic regulators have in common."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from drivers.sim.plants.channel import (
    PARAMETERS,
    STATE,
    STUCK,
    STUCK_CLOSED,
    STUCK_OPEN,
)
from drivers.sim.plants.parameters import draw_channel
from drivers.sim.plants.pneumatic_plant import WIDTH, PneumaticPlant, Units
from drivers.sim.plants.regulator import quantize
from drivers.sim.plants.settings import PneumaticPlantSettings, SealFriction
from drivers.sim.plants.spherical_joint_settings import SphericalJointPlantSettings

_SLOWER, _OFFSET = 2.0, 50e3
"""How much slower a regulator gets, and how far off its setpoint (Pa), unless it is said."""
_SETPOINT, _PILOT = (list(STATE.names or ()).index(name) for name in ("setpoint", "pilot"))


class RegulatorPlant(PneumaticPlant):
    """Channels with electro-pneumatic regulators; see `PneumaticPlant`.

    Faults of them: ``regulator_stuck`` (holds its pressure), ``regulator_open`` and
    ``regulator_closed``; by channel ``regulator_slow`` (factor on its time, default 2),
    ``regulator_stuck`` (at this pressure, Pa gauge) and ``regulator_offset`` (Pa, default 50 kPa).
    """

    modes: ClassVar[Mapping[str, float]] = {
        "regulator_stuck": STUCK,
        "regulator_open": STUCK_OPEN,
        "regulator_closed": STUCK_CLOSED,
    }
    wear = ("regulator_slow", "regulator_stuck", "regulator_offset")

    _common: PneumaticPlantSettings | SphericalJointPlantSettings

    def _draw_units(
        self, units: np.random.Generator, reality: np.random.Generator, seals: SealFriction
    ) -> Units:
        settings = self._common
        regulator = settings.regulator
        count = len(self.channel_names)
        dead_steps = np.rint(
            regulator.dead_time
            * (1.0 + regulator.dead_time_spread * reality.uniform(-1.0, 1.0, count))
            / self._dt
        )
        parameters = np.zeros(count, PARAMETERS)
        for channel in range(count):
            parameters[channel] = draw_channel(
                units,
                regulator=regulator,
                cylinder=settings.cylinder,
                wire=settings.wire,
                seals=seals,
                tube=settings.tube,
                friction_spread=settings.friction_spread,
                dead_steps=dead_steps[channel],
            )
        self._bandwidths = parameters["bandwidth"].copy()
        channels = np.zeros(count, STATE)
        channels["draw"] = reality.integers(1, 2**31 - 1, count)
        channels["until_sample"] = reality.uniform(0.0, regulator.sampling, count)
        channels["phase"] = reality.uniform(0.0, regulator.pilot_period, count)
        self._locked = [False] * count
        self._setpoint_offsets = [0.0] * count
        self._codes = float(2**regulator.dac_bits - 1)
        return Units(parameters, channels, np.zeros((count, max(1, int(dead_steps.max())))))

    @property
    def _converter(self) -> tuple[float, float, float]:
        return 0.0, self._full_scale, self._codes

    def _is_filtered(self) -> bool:
        return self._common.regulator.monitor_time > 0.0 or self._common.tube.length > 0.0

    def _remember(self) -> tuple[object, ...]:
        return tuple(self._locked), tuple(self._shown)

    def _recall(self, more: tuple[object, ...]) -> None:
        locked, shown = more
        assert isinstance(locked, tuple)
        assert isinstance(shown, tuple)
        self._locked, self._shown = list(locked), list(shown)

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Take a setpoint, Pa gauge; the converter saturates and quantises it.

        Raises
        ------
        ValueError
            The setpoint is not a finite number: no converter can put it out.
        """
        if not math.isfinite(pressure):
            raise ValueError(f"plant: channel {channel} cannot take the setpoint {pressure}")
        wanted = pressure + self._setpoint_offsets[channel]
        output = quantize(wanted, self._full_scale, self._codes)
        self._cells[WIDTH * channel + _SETPOINT] = output

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber.

        While it is shut, the monitor sees the bit of tube before the valve, which follows the
        regulator's pilot stage at once.
        """
        self._locked[channel] = locked
        first = WIDTH * channel
        cell, zero = (_PILOT, 0.0) if locked else self._monitor
        self._shown[channel] = (first + cell, zero)
        self._set_mode(channel, self._modes[channel])

    def _wear_feed(self, fault: str, channel: int, value: float | None) -> None:
        if fault == "regulator_offset":
            self._setpoint_offsets[channel] = _OFFSET if value is None else value
        elif fault == "regulator_slow":
            self.parameters[channel]["bandwidth"] = self._bandwidths[channel] / (value or _SLOWER)
        else:
            if value is not None:
                self.channels[channel]["pilot"] = value
            self._set_mode(channel, STUCK)

    def _set_mode(self, channel: int, mode: float) -> None:
        """See `PneumaticPlant._set_mode`; behind a shut lock valve it does not matter which."""
        super()._set_mode(channel, mode)
        if self._locked[channel]:
            self.channels[channel]["mode"] = STUCK_CLOSED

    def _repair(self) -> None:
        super()._repair()
        self.parameters["bandwidth"] = self._bandwidths
        self._setpoint_offsets = [0.0] * len(self.channel_names)
