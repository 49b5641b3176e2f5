"""A CiA 401 module with actuators and pressure sensors on its analogue channels.

References
----------
CiA 401 V3.0: 0x6411 and 0x6401 analogue outputs and inputs, 0x6443 … 0x6445 their error
modes and values, 0x6000 and 0x6200 digital inputs and outputs, 0x6206 and 0x6207 the
digital error modes and values. CiA 301: 0x1029 error behaviour.
"""

from collections.abc import Sequence
from functools import partial
from math import ceil, inf
from typing import Any, Final

from drivers.can.cyclic import CyclicFrame
from drivers.canopen.bus import CanopenBus
from drivers.canopen.identified import IdentifiedDevice
from drivers.canopen.inputs import CyclicInputs, layout_struct
from drivers.canopen.mapping import pack
from drivers.canopen.node import CanopenNode, pdo_id
from drivers.cia401.asked_monitors import AskedMonitors
from drivers.cia401.broken_wire import MonitorWires
from drivers.cia401.channel_settings import DIGITAL_INPUT
from drivers.cia401.codec import (
    monitor_codec,
    pressure_decoder,
    setpoint_codec,
    setpoint_encoder,
)
from drivers.cia401.echo import OutputEchoes
from drivers.cia401.module_settings import PROFILE, ModuleSettings
from rig.hal import EmergencyStopInput, LimitExceeded, Reading, Vector

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

_HOLD: Final = 0  # 0x6443
_TAKE_ERROR_VALUE: Final = 1
_TO_PRE_OPERATIONAL: Final = 0  # 0x1029:1
_ROUNDING: Final = 1e-9  # of the range: not worth a fault
_SILENT: Final = 0.02
"""Safe setpoints go out for so long without a sample in between, s: SYNC does not reach the module,
and they act with the next one only. A busy computer hears of its samples sooner than that; what
setpoints that stay do to a rig takes 60 ms or more."""


class AnalogueModule(IdentifiedDevice, EmergencyStopInput):
    """Actuators, pressure sensors, emergency-stop contact and supply valve on one CiA 401 node.

    Parameters are those of every driver, see `rig.hal.parts.DriverParts`, and what its channels
    are, which a subclass says.

    Parameters
    ----------
    span : tuple of float
        What every channel can be set to.
    unit : str
        Of that.
    safe : sequence of float
        What each channel is set to in the safe state.
    held : sequence of bool
        Which channels keep their last setpoint there.
    """

    def __init__(
        self,
        name: str,
        settings: ModuleSettings,
        bus: CanopenBus,
        serial: int | None,
        *,
        span: tuple[float, float],
        unit: str,
        safe: Sequence[float],
        held: Sequence[bool],
    ) -> None:
        self.name = name
        self.channels = tuple(settings.wired)
        settings.check_deadline(name, bus.period)
        self._module = settings
        self._bus = bus
        self._serial = serial
        self._node = CanopenNode(name, settings.node, bus)
        wiring = tuple(settings.wired.values())
        self._encoders = tuple(setpoint_encoder(setpoint_codec(of.setpoint)) for of in wiring)
        monitors = [monitor_codec(channel.monitor) for channel in wiring]
        self._wires = MonitorWires(name, settings, monitors)
        # What every sample needs of them, in counts.
        self._monitor_lines = tuple(
            (k, pressure_decoder(codec), *codec.intact_counts) for k, codec in enumerate(monitors)
        )
        low, high = self._span = span
        slack = _ROUNDING * (high - low)
        self._lowest, self._highest, self._unit = low - slack, high + slack, unit
        count = len(wiring)
        self._safe: Vector = tuple(safe)
        self._held = tuple(held)
        self._open = self._opened = settings.opening_bits
        self._supply, self._shut = 1 << (settings.supply_bit or 0), 0
        self._kept = settings.kept_bits
        self._digital = 0  # of the safe state: nothing is kept open that was not opened
        self._stop = 0 if settings.stop_bit is None else 1 << settings.stop_bit
        self.no_contact = "" if self._stop else "stop_bit"
        self._pressed_level = 0 if settings.stop_active_low else self._stop

        self._receive_layouts = pack(settings.receive_entries)
        self._transmit_layouts = pack(settings.transmit_entries)
        self._packers = tuple(layout_struct(layout) for layout in self._receive_layouts)
        self._pack_only = self._packers[0].pack if len(self._packers) == 1 else None
        counts = [encode(self._safe[k]) for k, encode in enumerate(self._encoders)]
        self._pdos = tuple(
            CyclicFrame(pdo_id(number, settings.node), data)
            for number, data in enumerate(self._contents(counts, 0), 1)
        )
        for pdo in self._pdos:
            bus.add(pdo)
        self._inputs = CyclicInputs(
            name,
            settings.node,
            bus,
            self._transmit_layouts,
            self._take,
            hold_after=settings.hold_after,
            fault_after=settings.fault_after,
        )
        echoed = settings.wired if settings.echo else {}
        self._echoes = OutputEchoes(name, settings.node, echoed, bus)
        self._unheard = False
        self._asked = AskedMonitors(
            self._node.asked, settings.transmit_entries[:count], self._monitor_lines,
            partial(bus.wake, settings.node),
        )  # fmt: skip
        # Cycles; who talks to a module without a cycle has nothing that SYNC could be late for.
        self._patience = ceil(_SILENT / bus.period) if bus.period else inf
        self._unanswered = 0
        self._setpoint = self._safe
        self._pressure: Vector = (0.0,) * count
        self._measured_at = -inf
        self._pressed, self._was_pressed = True, False
        self._pressed_at = -inf
        self._intact = True
        self._armed = False

    # Codec ----------------------------------------------------------------------------

    def _contents(self, counts: list[int | float], digital: int) -> tuple[bytes, ...]:
        """Return what the receive PDOs hold for setpoints in counts and the digital outputs."""
        values = [*counts, digital] if self._open else counts
        contents = []
        for layout, packer in zip(self._receive_layouts, self._packers, strict=True):
            part, values = values[: len(layout)], values[len(layout) :]
            contents.append(packer.pack(*part))
        return tuple(contents)

    def _take(self, values: tuple[Any, ...], t: float) -> None:
        """Decode a sample: monitors, then the digital byte. Hot path."""
        self._unanswered = 0
        pressures = []
        intact = True
        for k, decode, low, high in self._monitor_lines:
            raw = values[k]
            if not low <= raw <= high:
                intact = False
            pressures.append(decode(raw))
        if intact:  # else the last good sample is held, and grows old
            self._pressure = tuple(pressures)
            self._measured_at = t
        if not (intact and self._intact):
            self._wires.count(values)
            self._intact = intact
        if self._module.echo:
            self._echoes.hear(values[len(self.channels) :])
        if self._stop:
            self._see_stop(values[-1], t)

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Find, identify and configure the module; leave it safe, in PRE-OPERATIONAL.

        A chamber that is locked stays so until the first setpoint. Every object that matters
        for safety is written and read back.

        Raises
        ------
        ConnectionFailed
            It does not answer, is another device, or did not take a setting.
        """
        self._armed = self._was_pressed = False
        self._pressed, self._pressed_at = True, -inf  # until the circuit is seen closed
        self._forget_setpoints()
        settings, node = self._module, self._node
        node.connect(
            profile=PROFILE,
            vendor=settings.vendor,
            product=settings.product,
            serial=self._serial,
        )
        raws = [encode(self._safe[k]) for k, encode in enumerate(self._encoders)]
        for raw, channel, held in zip(raws, settings.wired.values(), self._held, strict=True):
            signal = channel.setpoint
            if settings.error_mode is not None:
                mode = _HOLD if held else _TAKE_ERROR_VALUE
                node.write(settings.error_mode, signal.sub, settings.error_mode_type, mode)
            if settings.error_value is not None:
                kind = "f32" if signal.type == "f32" else "i32"
                node.write(settings.error_value, signal.sub, kind, raw)
        if self._open:
            node.write(0x6206, 1, "u8", 0xFF & ~self._kept)
            node.write(0x6207, 1, "u8", 0)
        node.write(0x1029, 1, "u8", _TO_PRE_OPERATIONAL)
        node.map_pdos(self._receive_layouts, self._transmit_layouts, remap=settings.remap)
        node.set_deadlines(len(self._receive_layouts), settings.setpoint_deadline)
        for raw, channel in zip(raws, settings.wired.values(), strict=True):
            signal = channel.setpoint
            node.write(signal.index, signal.sub, signal.type, raw)
        if self._open:
            node.write(0x6200, 1, "u8", 0)
        self._set_safe()

    def arm(self) -> None:
        """Start the node and take first readings; the supply opens with the first setpoint.

        Raises
        ------
        ConnectionFailed
            It does not become OPERATIONAL, or sends no readings.
        DeviceFault
            The wire of a monitor is broken.
        """
        self._forget_setpoints()
        self._set_safe()
        self._node.arm()
        # The first starts the deadline, and other devices take their time to be armed.
        self._send_setpoints(self._module.setpoint_deadline is None)
        self._wires.reset()
        self._intact = True
        self._inputs.take_first()
        if not self._intact:
            self._inputs.take_first()
            self._wires.check()
        self._armed = True

    def make_safe(self) -> None:
        """Take the safe state until it is armed again.

        A module that does not get its setpoints, be it only the safe ones, is stopped: it does so
        by itself. So is one that SYNC does not reach any more, for setpoints act with SYNC.
        """
        self._armed = False
        self._set_safe()
        self._unanswered += 1
        if not self._unheard:
            said = self._node.emergency.active
            refused = said is not None and said.is_about_setpoints and not self._module.echo
            silent = self._unanswered > self._patience
            self._unheard = refused or silent or self._echoes.are_missing
        if self._unheard and not self._asked.asking:
            self._node.halt()

    def _ask_monitors(self) -> None:
        """Ask for the monitors of a module that was stopped, for it samples nothing any more."""
        if self._unheard:
            self._asked.ask()
            told = self._asked.reading()
            if told.t > self._measured_at:
                self._pressure, self._measured_at = told

    def close(self) -> None:
        """Expect nothing of the module any more; the bus stops it. Idempotent."""
        self.make_safe()
        self._node.disarm()

    # The cycle ------------------------------------------------------------------------

    def pressure(self) -> Reading[Vector]:
        """Return the monitored pressures, Pa gauge, shape (n,)."""
        return _new(Reading, (self._pressure, self._measured_at))

    def emergency_stop(self) -> Reading[bool]:
        """Return whether the stop is pressed; without a contact it reads pressed."""
        return _new(Reading, (self._pressed, self._pressed_at))

    def was_pressed(self) -> bool:
        """Return whether the stop was pressed at any look since `connect`."""
        return self._was_pressed

    def stop_place(self) -> str:
        """Return the module and its digital input."""
        return self._module.stop_place(self.name)

    def look(self) -> None:
        """Ask for the contact by SDO; see `EmergencyStopInput.look`."""
        if self._stop:
            self._node.asked.ask(DIGITAL_INPUT.object, DIGITAL_INPUT.sub, self._take_look)

    def _take_look(self, data: bytes, now: float) -> None:
        self._see_stop(data[0], now)

    def _see_stop(self, bits: int, t: float) -> None:
        self._pressed = pressed = bits & self._stop == self._pressed_level
        self._pressed_at = t
        if pressed:
            self._was_pressed = True

    def _give(self, setpoint: Vector) -> None:
        """Take setpoints for this cycle, shape (n,); ignored unless armed. Hot path.

        Raises
        ------
        LimitExceeded
            A setpoint is outside the range or not a number. The setpoints stay as they were.
        ValueError
            There is not one setpoint per channel.
        """
        if not self._armed:
            return
        if len(setpoint) != len(self.channels):
            raise ValueError(f"{self.name}: {len(setpoint)} setpoints")
        lowest, highest = self._lowest, self._highest
        counts: list[int | float] = []
        for k, encode in enumerate(self._encoders):
            value = setpoint[k]
            if not lowest <= value <= highest:
                raise LimitExceeded(
                    f"{self.name}: setpoint of {self.channels[k]}",
                    value,
                    *self._span,
                    self._unit,
                )
            counts.append(encode(value))
        self._setpoint = setpoint
        self._echoes.send(counts)
        if not self._pdos[0].active:
            self._send_setpoints(True)
        self._digital = self._kept
        if self._pack_only is not None:  # as most modules have it: one PDO for everything
            self._pdos[0].data = self._pack_only(*counts, *((self._opened,) if self._open else ()))
            return
        for pdo, data in zip(self._pdos, self._contents(counts, self._opened), strict=True):
            pdo.data = data

    def inspect(self) -> Vector:
        """Ask for the monitors by SDO; see `PressureRegulator.inspect`."""
        read, entries = self._node.read, self._module.transmit_entries
        return tuple(decode(read(*entries[k])) for k, decode, _, _ in self._monitor_lines)

    def shut_supply(self, shut: bool) -> bool:
        """Shut or open the supply valve; see `PressureRegulator.shut_supply`."""
        has_valve = self._module.supply_bit is not None
        self._shut = self._supply if shut and has_valve else 0
        self._open_valves(0)
        return has_valve

    def _open_valves(self, closed: int) -> None:
        """Have all digital outputs high from now on but some bits."""
        self._opened = self._open & ~closed & ~self._shut if self._armed else self._open

    def check(self, now: float) -> None:
        """Raise if the module is not well.

        Raises
        ------
        DeviceFault
            Emergency, silence, reboot, missing or malformed readings, or a broken monitor wire.
        """
        self._node.check(now)
        if not self._armed:
            return
        self._inputs.check(now)
        if not self._intact:
            self._wires.check()
        self._echoes.check()

    def _safe_setpoint(self) -> Vector:
        """Return the setpoints that `make_safe` would take now, shape (n,)."""
        return tuple(
            setpoint if held else safe
            for held, setpoint, safe in zip(self._held, self._setpoint, self._safe, strict=True)
        )

    def _send_setpoints(self, active: bool) -> None:
        for pdo in self._pdos:
            pdo.active = active

    def _forget_setpoints(self) -> None:
        """Hold nothing and keep nothing open: nothing has been commanded yet."""
        self._echoes.reset()
        self._unheard = False
        self._asked.forget()
        self._unanswered = 0
        self._setpoint = self._safe
        self._digital = self._shut = 0
        self._opened = self._open

    def _set_safe(self) -> None:
        self._setpoint = setpoint = self._safe_setpoint()
        counts = [encode(setpoint[k]) for k, encode in enumerate(self._encoders)]
        self._echoes.send(counts)
        for pdo, data in zip(self._pdos, self._contents(counts, self._digital), strict=True):
            pdo.data = pdo.safe = data
