"""What all plants with pneumatic channels share: their ports, their time and their faults."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.sim.plants.channel import (
    PARAMETERS,
    REGULATING,
    STATE,
    STUCK,
    STUCK_CLOSED,
    STUCK_OPEN,
)
from drivers.sim.plants.lending import DEVICES, Kernel, Lending, Memory, exchange_of, memory_of
from drivers.sim.plants.parameters import draw_channel
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.push import Push
from drivers.sim.plants.regulator import quantize
from drivers.sim.plants.settings import PneumaticPlantSettings, SealFriction

_NOISE_BLOCK = 4096
"""Monitor samples drawn at a time: numpy's cost per call is spread over them."""

_MODES = {
    "regulator_stuck": STUCK,
    "regulator_open": STUCK_OPEN,
    "regulator_closed": STUCK_CLOSED,
}

_SLOWER, _OFFSET = 2.0, 50e3
"""How much slower a regulator gets, and how far off a monitor (Pa), unless it is said."""
_OF_CHANNEL = (
    *("regulator_slow", "regulator_stuck", "regulator_offset"),
    *("monitor_offset", "monitor_frozen", "leak"),
)
"""Faults that are addressed by channel, ``agonist.leak``, and whose value says how much."""

EXTENSION, SPEED, PRESSURE, TENSION = (
    list(STATE.names or ()).index(name) for name in ("extension", "speed", "pressure", "tension")
)
"""Columns of a channel's values."""
_SETPOINT, _PILOT, _MONITOR = (
    list(STATE.names or ()).index(name) for name in ("setpoint", "pilot", "monitor")
)
WIDTH = len(STATE.names or ())
"""How many there are."""


Array = NDArray[Any]


class _Snapshot(NamedTuple):
    steps: int
    arrays: tuple[Array, ...]
    supply_open: bool
    modes: tuple[float, ...]
    locked: tuple[bool, ...]
    shown: tuple[tuple[int, float], ...]


class PneumaticPlant(ABC):
    """Channels at rest at home, vented and with the supply closed.

    Nothing moves before ``set_supply(True)`` and a setpoint.

    Parameters
    ----------
    settings : PneumaticPlantSettings
        Nominal parameters.
    seals : SealFriction
        Friction of the nominal cylinder.
    units, monitors : numpy.random.Generator
        Of the units' deviations and of the monitors' noise.
    line : ndarray, shape (1,)
        Record with the fields ``supply`` and ``supply_target`` of the supply line, Pa absolute.
    push : Push
        On what the wires move.
    """

    channel_names: ClassVar[tuple[str, ...]]

    own_faults: ClassVar[tuple[str, ...]] = (*_MODES, "leak", "wire_cut", "supply_lost", "repair")
    """What `inject` understands without a channel's name before it."""

    def __init__(
        self,
        settings: PneumaticPlantSettings,
        seals: SealFriction,
        *,
        units: np.random.Generator,
        monitors: np.random.Generator,
        line: Array,
        push: Push,
    ) -> None:
        self._common = settings
        self._full_scale = settings.regulator.full_scale
        self._codes = float(2**settings.regulator.dac_bits - 1)
        self._dt = settings.substep
        self._steps = 0

        of_channels = [f"{c}.{fault}" for c in self.channel_names for fault in _OF_CHANNEL]
        self._push = push
        self.known_faults: tuple[str, ...] = (
            *self.own_faults,
            *of_channels,
            *push.known_faults,
        )
        """What `inject` understands."""
        count = len(self.channel_names)
        # A stream of its own: what is real of a rig must not change what else is drawn for it.
        reality, noise = units.spawn(2)
        regulator = settings.regulator
        dead_steps = np.rint(
            regulator.dead_time
            * (1.0 + regulator.dead_time_spread * reality.uniform(-1.0, 1.0, count))
            / self._dt
        )
        self.queues = np.zeros((count, max(1, int(dead_steps.max()))))
        """Setpoints that have not got to the pilot stages yet, Pa gauge, shape (n, k)."""
        self.parameters = np.zeros(count, PARAMETERS)
        for channel in range(count):
            self.parameters[channel] = draw_channel(
                units,
                regulator=regulator,
                cylinder=settings.cylinder,
                wire=settings.wire,
                seals=seals,
                tube=settings.tube,
                friction_spread=settings.friction_spread,
                dead_steps=dead_steps[channel],
            )
        self._bandwidths = self.parameters["bandwidth"].copy()
        self.channels = np.zeros(count, STATE)
        for pressure in ("pressure", "outlet", "tube_first", "tube_second"):
            self.channels[pressure] = ATMOSPHERE
        self.channels["extension"] = settings.home
        self.channels["draw"] = reality.integers(1, 2**31 - 1, count)
        self.channels["until_sample"] = reality.uniform(0.0, regulator.sampling, count)
        self.channels["phase"] = reality.uniform(0.0, regulator.pilot_period, count)
        # Single numbers are read and written twice as fast so as through the array.
        self._cells = self.channels.view(np.uint8).data.cast("d")

        self._line = line
        self._line["supply"] = self._line["supply_target"] = ATMOSPHERE
        self._supply_open = False
        self._supply_pressure = settings.regulator.supply_pressure
        self._modes = [REGULATING] * count
        self._locked = [False] * count
        self._leaks = (0.0,) * count
        self._monitor_offsets = [0.0] * count
        self._setpoint_offsets = [0.0] * count
        self._monitor_frozen: list[float | None] = [None] * count
        filtered = regulator.monitor_time > 0.0 or settings.tube.length > 0.0
        self._monitor = (_MONITOR, 0.0) if filtered else (PRESSURE, ATMOSPHERE)
        self._shown = [(WIDTH * k + self._monitor[0], self._monitor[1]) for k in range(count)]
        gains, zeros = regulator.monitor_error * reality.uniform(-1.0, 1.0, (2, count))
        self._monitor_gains: list[float] = (1.0 + gains).tolist()
        self._monitor_zeros: list[float] = (self._full_scale * zeros).tolist()

        self._monitors, self._encoders = monitors, noise
        self._noise: list[list[float]] = []
        self._rod_noise: list[list[float]] = []
        self._sample = _NOISE_BLOCK
        self._next_noise()

    @property
    def time(self) -> float:
        """How far the plant has been integrated, s."""
        return self._steps * self._dt

    def advance(self, t: float) -> None:
        """Integrate to the last substep that is not after `t` (s); the past is left alone."""
        steps = int(t / self._dt + 1e-6) - self._steps
        if steps <= 0:
            return
        if self.time < self._push.ends <= t:
            self._run(min(steps, math.ceil((self._push.ends - self.time) / self._dt - 1e-6)))
            self._push.end()
        self._run(int(t / self._dt + 1e-6) - self._steps)
        self._next_noise()

    def _run(self, steps: int) -> None:
        self._integrate(steps)
        self._steps += steps

    def snapshot(self) -> _Snapshot:
        """Return all that moves, as it is now; faults are not in it."""
        return _Snapshot(
            self._steps,
            tuple(array.copy() for array in self._moving()),
            self._supply_open,
            tuple(self._modes),
            tuple(self._locked),
            tuple(self._shown),
        )

    def restore(self, snapshot: object) -> None:
        """Go back to a snapshot of this plant."""
        assert isinstance(snapshot, _Snapshot)
        self._steps = snapshot.steps
        for array, then in zip(self._moving(), snapshot.arrays, strict=True):
            array[...] = then
        self._supply_open = snapshot.supply_open
        self._modes, self._locked = list(snapshot.modes), list(snapshot.locked)
        self._shown = list(snapshot.shown)

    def lend_kernel(
        self, kernels: tuple[Kernel, Kernel], bodies: tuple[Array, ...], timing: Lending
    ) -> tuple[Kernel, Memory]:
        """Return the plant's kernel with its devices, and what it works on."""
        self.set_supply(True)
        devices = np.zeros(len(self.channel_names), DEVICES)
        devices["is_filtered"] = self._monitor[0] == _MONITOR
        devices["monitor_gain"], devices["monitor_zero"] = self._monitor_gains, self._monitor_zeros
        devices["monitor_noise"] = self._common.regulator.monitor_noise * self._full_scale
        devices["rod_noise"] = self._common.encoder_noise
        devices["full_scale"], devices["codes"] = self._full_scale, self._codes
        return exchange_of(*kernels), memory_of(bodies, devices, timing, self._dt)

    def _moving(self) -> tuple[Array, ...]:
        """Return the arrays that change as the plant moves."""
        return self.channels, self.queues, self._line

    @abstractmethod
    def _integrate(self, steps: int) -> None:
        """Step everything that moves `steps` times."""

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

    def set_supply(self, open: bool) -> None:
        """Open the supply valve, or close it: it then vents the line and the regulators."""
        self._supply_open = open
        self._connect_supply()

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber."""
        self._locked[channel] = locked
        first = WIDTH * channel
        cell, zero = (_PILOT, 0.0) if locked else self._monitor
        self._shown[channel] = (first + cell, zero)
        self._set_mode(channel, self._modes[channel])

    def pressure(self, channel: int) -> float:
        """Return what the regulator's monitor puts out, Pa gauge: its outlet and its noise.

        That is the chamber, unless a shut lock valve is between: the bit of tube before the valve
        follows the regulator's pilot stage at once.
        """
        frozen = self._monitor_frozen[channel]
        if frozen is not None:
            return frozen
        cell, zero = self._shown[channel]
        noise = self._noise_now[channel] + self._monitor_zeros[channel]
        shown = self._monitor_gains[channel] * (self._cells[cell] - zero)
        return shown + noise + self._monitor_offsets[channel]

    def position(self, channel: int) -> float:
        """Return what the encoder of a rod sees of its extension, m: with its noise."""
        return self._cells[WIDTH * channel + EXTENSION] + self._rod_noise_now[channel]

    def speed(self, channel: int) -> float:
        """Return the true speed of a rod's extension, m/s."""
        return self._cells[WIDTH * channel + SPEED]

    def powered(self) -> dict[str, bool]:
        """Return nothing: no drive moves it, and its pressures are of its truth."""
        return {}

    def inject(self, fault: str, value: float | None = None) -> None:
        """Break or repair something now.

        Parameters
        ----------
        fault : str
            ``regulator_stuck`` (holds its pressure), ``regulator_open``, ``regulator_closed``,
            ``leak`` (the chamber's tube is off), ``wire_cut`` and what else the plant knows,
            each with a channel as its value; ``supply_lost`` with the pressure that remains,
            Pa gauge; ``repair`` ends all of them. With a channel's name before it, as in
            ``agonist.leak``, the value says how much: ``regulator_slow`` (factor on its time,
            default 2), ``regulator_stuck`` (at this pressure, Pa gauge), ``leak`` (sonic
            conductance, m³/(s Pa)), ``regulator_offset`` and ``monitor_offset`` (Pa, default
            50 kPa) and ``monitor_frozen`` (none). ``along.carriage_push``, ``forward.ring_push``
            and ``left.ring_push`` (value: N s) push what the wires move.
        value : float, optional
            As said above; 0 if not given.

        Raises
        ------
        ValueError
            There is no such fault or channel, or the pressure is negative or not finite.
        """
        number = 0.0 if value is None else value
        count = len(self.channel_names)
        name, dot, own = fault.rpartition(".")
        if fault not in self.known_faults:
            raise ValueError(f"plant: no fault {fault!r}; known are {', '.join(self.known_faults)}")
        if fault in self._push.known_faults:
            self._push.begin(fault, value, self.time)
        elif dot:
            self._wear_channel(own, self.channel_names.index(name), value)
        elif fault == "repair":
            self._repair()
        elif fault == "supply_lost":
            if not 0.0 <= number < math.inf:
                raise ValueError(f"plant: supply_lost leaves {number:g} Pa; 0 or more is needed")
            self._supply_pressure = number
            self._connect_supply()
        elif number not in range(count):
            some = ", ".join(str(channel) for channel in range(count - 1))
            raise ValueError(f"plant: {fault} takes channel {some} or {count - 1}, not {number:g}")
        else:
            self._break_channel(fault, int(number))

    def pull(self, channel: str, by: float) -> None:
        """Pull a rod out by hand, m; its wire gets slack."""
        self._cells[WIDTH * self.channel_names.index(channel) + EXTENSION] += by

    def set_leaks(self, conductances: Sequence[float]) -> None:
        """Have each chamber leak as it was built: sonic conductances, m³/(s Pa)."""
        self._leaks = tuple(conductances)
        self.channels["leak"] = self._leaks

    def _break_channel(self, fault: str, channel: int) -> None:
        if fault == "leak":
            self.channels[channel]["leak"] = self._common.leak
        elif fault == "wire_cut":
            self.parameters[channel]["wire_stiffness"] = 0.0
            self.parameters[channel]["wire_damping"] = 0.0
        else:
            self._set_mode(channel, _MODES[fault])

    def _wear_channel(self, fault: str, channel: int, value: float | None) -> None:
        least = -math.inf if fault.endswith("_offset") else 0.0
        if value is not None and not least <= value < math.inf:
            raise ValueError(f"plant: {fault} takes a finite number from {least:g}, not {value:g}")
        if fault == "monitor_offset":
            self._monitor_offsets[channel] = _OFFSET if value is None else value
        elif fault == "regulator_offset":
            self._setpoint_offsets[channel] = _OFFSET if value is None else value
        elif fault == "monitor_frozen":
            self._monitor_frozen[channel] = self.pressure(channel)
        elif fault == "leak":
            self.channels[channel]["leak"] = self._common.leak if value is None else value
        elif fault == "regulator_slow":
            self.parameters[channel]["bandwidth"] = self._bandwidths[channel] / (value or _SLOWER)
        else:
            if value is not None:
                self.channels[channel]["pilot"] = value
            self._set_mode(channel, STUCK)

    def _set_mode(self, channel: int, mode: float) -> None:
        """Have a regulator work or fail; behind a shut lock valve it does not matter which."""
        self._modes[channel] = mode
        self.channels[channel]["mode"] = STUCK_CLOSED if self._locked[channel] else mode

    def _repair(self) -> None:
        for channel in range(len(self.channel_names)):
            self._set_mode(channel, REGULATING)
        self.channels["leak"] = self._leaks
        self.parameters["wire_stiffness"] = self._common.wire.stiffness
        self.parameters["wire_damping"] = self._common.wire.damping
        self.parameters["bandwidth"] = self._bandwidths
        self._monitor_offsets = [0.0] * len(self.channel_names)
        self._setpoint_offsets = [0.0] * len(self.channel_names)
        self._monitor_frozen = [None] * len(self.channel_names)
        self._supply_pressure = self._common.regulator.supply_pressure
        self._connect_supply()

    def _connect_supply(self) -> None:
        gauge = self._supply_pressure if self._supply_open else 0.0
        self._line["supply_target"] = ATMOSPHERE + gauge

    def _next_noise(self) -> None:
        self._sample += 1
        if self._sample >= _NOISE_BLOCK:
            rms = self._common.regulator.monitor_noise * self._full_scale
            shape = (_NOISE_BLOCK, len(self.channel_names))
            self._noise = (rms * self._monitors.standard_normal(shape)).tolist()
            rods = self._common.encoder_noise * self._encoders.standard_normal(shape)
            self._rod_noise = rods.tolist()
            self._sample = 0
        self._noise_now = self._noise[self._sample]
        self._rod_noise_now = self._rod_noise[self._sample]
