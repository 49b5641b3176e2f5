"""What all plants with pneumatic channels share: their ports, their time and their faults."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.sim.plants.channel import STATE, WORKING
from drivers.sim.plants.lending import DEVICES, Kernel, Lending, Memory, exchange_of, memory_of
from drivers.sim.plants.pneumatics import ATMOSPHERE
from drivers.sim.plants.push import Push
from drivers.sim.plants.settings import CylinderPlantSettings, SealFriction

_NOISE_BLOCK = 4096
"""Monitor samples drawn at a time: numpy's cost per call is spread over them."""

_OFFSET = 50e3
"""How far off a monitor gets, Pa, unless it is said."""
_BUBBLES = 1e-7
"""Flow that soap water shows at once, m³/s: 6 cm³ in a minute."""
_OF_CHANNEL = ("monitor_offset", "monitor_frozen", "leak")
"""Faults that are addressed by channel, ``agonist.leak``, and whose value says how much."""

EXTENSION, SPEED, PRESSURE, TENSION = (
    list(STATE.names or ()).index(name) for name in ("extension", "speed", "pressure", "tension")
)
"""Columns of a channel's values."""
MONITOR = list(STATE.names or ()).index("monitor")
"""Column of what a filtered monitor shows, Pa gauge."""
WIDTH = len(STATE.names or ())
"""How many there are."""


Array = NDArray[Any]
_CELL_NOISE = 2e-4  # of a load cell's amplifier over that of a monitor's, N/Pa


class Units(NamedTuple):
    """The units of all channels, as a seed draws them.

    Parameters
    ----------
    parameters, channels : ndarray, shape (n,)
        Of each, and its state at rest but for what is the same on every plant.
    queues : ndarray, shape (n, k)
        Setpoints that have not acted yet.
    """

    parameters: Array
    channels: Array
    queues: Array


class _Snapshot(NamedTuple):
    steps: int
    arrays: tuple[Array, ...]
    supply_open: bool
    modes: tuple[float, ...]
    more: tuple[object, ...]


class PneumaticPlant(ABC):
    """Channels at rest at home, vented and with the supply closed.

    Nothing moves before ``set_supply(True)`` and a setpoint.

    Parameters
    ----------
    settings : CylinderPlantSettings
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

    modes: ClassVar[Mapping[str, float]]
    """Faults of what feeds a chamber as a whole: the mode of each."""

    wear: ClassVar[tuple[str, ...]]
    """Faults of what feeds a chamber whose value says how much; see `_wear_feed`."""

    signed: ClassVar[tuple[str, ...]] = ()
    """Those of them whose value may be negative, beside what is an offset."""

    own_faults: ClassVar[tuple[str, ...]] = ("leak", "wire_cut", "supply_lost", "repair")
    """What `inject` understands of it without a channel's name before it, beside `modes`."""

    def __init__(
        self,
        settings: CylinderPlantSettings,
        seals: SealFriction,
        *,
        units: np.random.Generator,
        monitors: np.random.Generator,
        line: Array,
        push: Push,
    ) -> None:
        self._common = settings
        self._feed = feed = settings.feed
        self._full_scale = feed.full_scale
        self._dt = settings.substep
        self._steps = 0
        self._first: tuple[Array, ...] = ()

        names = (*self.wear, *_OF_CHANNEL)
        of_channels = [f"{c}.{fault}" for c in self.channel_names for fault in names]
        self._push = push
        self.known_faults: tuple[str, ...] = (
            *self.modes,
            *self.own_faults,
            *of_channels,
            *push.known_faults,
        )
        """What `inject` understands."""
        count = len(self.channel_names)
        # A stream of its own: what is real of a rig must not change what else is drawn for it.
        reality, noise = units.spawn(2)
        self.parameters, self.channels, self.queues = self._draw_units(units, reality, seals)
        for pressure in ("pressure", "outlet", "tube_first", "tube_second"):
            self.channels[pressure] = ATMOSPHERE
        self.channels["extension"] = settings.home
        # Single numbers are read and written twice as fast so as through the array.
        self._cells = self.channels.view(np.uint8).data.cast("d")

        self._line = line
        self._line["supply"] = self._line["supply_target"] = ATMOSPHERE
        self._supply_open = False
        self._supply_pressure = feed.supply_pressure
        self._modes = [WORKING] * count
        self._leaks = (0.0,) * count
        self._monitor_offsets = [0.0] * count
        self._monitor_frozen: list[float | None] = [None] * count
        self._monitor = (MONITOR, 0.0) if self._is_filtered() else (PRESSURE, ATMOSPHERE)
        self._shown = [(WIDTH * k + self._monitor[0], self._monitor[1]) for k in range(count)]
        gains, zeros = feed.monitor_error * reality.uniform(-1.0, 1.0, (2, count))
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
        if self._push.ends <= t:  # where it ends with a substep, that may be done already
            left = math.ceil((self._push.ends - self.time) / self._dt - 1e-6)
            self._run(min(steps, max(left, 0)))
            self._push.end()
        self._run(int(t / self._dt + 1e-6) - self._steps)
        self._next_noise()

    def _run(self, steps: int) -> None:
        if self._steps == 0:
            self._first = tuple(array.copy() for array in self._moving())
        self._integrate(steps)
        self._steps += steps

    def snapshot(self) -> _Snapshot:
        """Return all that moves, as it is now; faults are not in it."""
        return _Snapshot(
            self._steps,
            tuple(array.copy() for array in self._moving()),
            self._supply_open,
            tuple(self._modes),
            self._remember(),
        )

    def restore(self, snapshot: object) -> None:
        """Go back to a snapshot of this plant."""
        assert isinstance(snapshot, _Snapshot)
        self._steps = snapshot.steps
        for array, then in zip(self._moving(), snapshot.arrays, strict=True):
            array[...] = then
        self._supply_open = snapshot.supply_open
        self._modes = list(snapshot.modes)
        self._recall(snapshot.more)

    def lend_kernel(
        self, kernels: tuple[Kernel, Kernel], bodies: tuple[Array, ...], timing: Lending
    ) -> tuple[Kernel, Memory]:
        """Return the plant's kernel with its devices, and what it works on."""
        self.set_supply(True)
        devices = np.zeros(len(self.channel_names), DEVICES)
        devices["is_filtered"] = self._monitor[0] == MONITOR
        devices["monitor_gain"], devices["monitor_zero"] = self._monitor_gains, self._monitor_zeros
        devices["monitor_noise"] = self._feed.monitor_noise * self._full_scale
        devices["rod_noise"] = self._common.encoder_noise
        devices["least"], devices["span"], devices["codes"] = self._converter
        return exchange_of(*kernels), memory_of(bodies, devices, timing, self._dt)

    def _moving(self) -> tuple[Array, ...]:
        """Return the arrays that change as the plant moves."""
        return self.channels, self.queues, self._line

    def _remember(self) -> tuple[object, ...]:
        """Return what a snapshot keeps besides."""
        return ()

    def _recall(self, more: tuple[object, ...]) -> None:
        """Take back what `_remember` returned."""
        assert not more

    @abstractmethod
    def _draw_units(
        self, units: np.random.Generator, reality: np.random.Generator, seals: SealFriction
    ) -> Units:
        """Return the units of all channels, drawn from two streams."""

    @property
    @abstractmethod
    def _converter(self) -> tuple[float, float, float]:
        """The converter that drives what feeds a chamber: its least output, span and steps."""

    @abstractmethod
    def _is_filtered(self) -> bool:
        """Return whether a monitor sees something else than the chamber."""

    @abstractmethod
    def _integrate(self, steps: int) -> None:
        """Step everything that moves `steps` times."""

    def set_supply(self, open: bool) -> None:
        """Open the supply valve, or close it: it then vents the line and the regulators."""
        self._supply_open = open
        self._connect_supply()

    def pressure(self, channel: int) -> float:
        """Return what the pressure's monitor puts out, Pa gauge: with its noise."""
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

    def channel_value(self, channel: int) -> float:
        """Return what a load cell at a rod shows of its wire, N: as noisy as the monitor."""
        return self._cells[WIDTH * channel + TENSION] + _CELL_NOISE * self._noise_now[channel]

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
            What `modes` names, ``leak`` (the chamber's tube is off), ``wire_cut`` and what else
            the plant knows, each with a channel as its value; ``supply_lost`` with the pressure
            that remains, Pa gauge; ``repair`` ends all of them. With a channel's name before it,
            as in ``agonist.leak``, the value says how much: what `wear` names, ``leak`` (sonic
            conductance, m³/(s Pa)), ``monitor_offset`` (Pa, default 50 kPa) and
            ``monitor_frozen`` (none). ``along.carriage_push``, ``forward.ring_push`` and
            ``left.ring_push`` (value: N s) push what the wires move.
        value : float, optional
            As said above; 0 if not given.

        Raises
        ------
        ValueError
            There is no such fault or channel, or the pressure is negative or not finite.
        """
        number = 0.0 if value is None else value
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
        elif number not in range(len(self.channel_names)):
            known = ", ".join(f"{k} ({name})" for k, name in enumerate(self.channel_names))
            raise ValueError(f"plant: {fault} takes a channel's number, {known}; not {number:g}")
        else:
            self._break_channel(fault, int(number))

    def pull(self, channel: str, by: float) -> None:
        """Pull a rod out by hand, m, up to its end; its wire gets slack."""
        cell = WIDTH * self.channel_names.index(channel) + EXTENSION
        here, stroke = self._cells[cell], self._common.cylinder.stroke
        self._cells[cell] = min(max(here + by, min(here, 0.0)), max(here, stroke))

    def put_back(self) -> None:
        """Put rods and what they move where they were at first, vented."""
        broken = {field: self.channels[field].copy() for field in ("leak", "mode")}
        for array, first in zip(self._moving(), self._first, strict=True):
            array[...] = first
        for field, values in broken.items():
            self.channels[field] = values
        self._connect_supply()

    def bubbling(self) -> tuple[str, ...]:
        """Return the chambers whose leaks soap water shows now."""
        return tuple(
            name
            for name, channel in zip(self.channel_names, self.channels, strict=True)
            if channel["leak"] * max(channel["pressure"] - ATMOSPHERE, 0.0) > _BUBBLES
        )

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
            self._set_mode(channel, self.modes[fault])

    def _wear_channel(self, fault: str, channel: int, value: float | None) -> None:
        is_signed = fault.endswith("_offset") or fault in self.signed
        least = -math.inf if is_signed else 0.0
        if value is not None and not least <= value < math.inf:
            raise ValueError(f"plant: {fault} takes a finite number from {least:g}, not {value:g}")
        if fault == "monitor_offset":
            self._monitor_offsets[channel] = _OFFSET if value is None else value
        elif fault == "monitor_frozen":
            self._monitor_frozen[channel] = self.pressure(channel)
        elif fault == "leak":
            self.channels[channel]["leak"] = self._common.leak if value is None else value
        else:
            self._wear_feed(fault, channel, value)

    @abstractmethod
    def _wear_feed(self, fault: str, channel: int, value: float | None) -> None:
        """Wear what feeds a channel as one of `wear`; a value is finite."""

    def _set_mode(self, channel: int, mode: float) -> None:
        """Have what feeds a chamber work or fail."""
        self._modes[channel] = mode
        self.channels[channel]["mode"] = mode

    def _repair(self) -> None:
        for channel in range(len(self.channel_names)):
            self._set_mode(channel, WORKING)
        self.channels["leak"] = self._leaks
        self.parameters["wire_stiffness"] = self._common.wire.stiffness
        self.parameters["wire_damping"] = self._common.wire.damping
        self._monitor_offsets = [0.0] * len(self.channel_names)
        self._monitor_frozen = [None] * len(self.channel_names)
        self._supply_pressure = self._feed.supply_pressure
        self._connect_supply()

    def _connect_supply(self) -> None:
        gauge = self._supply_pressure if self._supply_open else 0.0
        self._line["supply_target"] = ATMOSPHERE + gauge

    def _next_noise(self) -> None:
        self._sample += 1
        if self._sample >= _NOISE_BLOCK:
            rms = self._feed.monitor_noise * self._full_scale
            shape = (_NOISE_BLOCK, len(self.channel_names))
            self._noise = (rms * self._monitors.standard_normal(shape)).tolist()
            rods = self._common.encoder_noise * self._encoders.standard_normal(shape)
            self._rod_noise = rods.tolist()
            self._sample = 0
        self._noise_now = self._noise[self._sample]
        self._rod_noise_now = self._rod_noise[self._sample]
