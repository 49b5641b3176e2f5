"""An emulated CiA 401 module with the regulators, e-stop contact and supply valve on it.

References
----------
CiA 401 V3.0: objects, defaults and error modes. Device type 0x000F_0191: profile 401, with
digital inputs and outputs, analogue inputs and outputs (bits 16 … 19).
"""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple, Protocol

from drivers.sim.nodes.analogue import AnalogueScale
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.faults import whole_number
from drivers.sim.nodes.object_dictionary import (
    BOOLEAN,
    INTEGER16,
    INTEGER32,
    UNSIGNED8,
    UNSIGNED32,
    DataType,
    Variable,
)

DEVICE_TYPE = 0x000F_0191
_ERROR_VALUE_MODE = 1  # 0x6443: take the error value; 0 would hold the last one
_INPUT_PERIOD = 1e-3  # how often the module looks at its inputs for changes, s
_UPPER, _LOWER, _DELTA = 0x01, 0x02, 0x04  # bits of 0x6421


class RegulatorPort(Protocol):
    """What the module needs of the plant."""

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator its setpoint, Pa gauge."""
        ...

    def pressure(self, channel: int) -> float:
        """Return what a regulator's monitor shows, Pa gauge."""
        ...

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""
        ...

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber."""
        ...


class RegulatorWiring(NamedTuple):
    """How one regulator is wired to the module.

    Attributes
    ----------
    output, input : int
        Sub-indices of the analogue output (setpoint) and input (monitor).
    setpoint, monitor : AnalogueScale
        Their scales.
    lock_bit : int or None
        Bit of 0x6200:1 that opens the valve between regulator and chamber; None: there is none.
    """

    output: int
    input: int
    setpoint: AnalogueScale
    monitor: AnalogueScale
    lock_bit: int | None = None


class EmulatedCia401(EmulatedNode):
    """Analogue and digital I/O: regulators on the analogue side, safety on the digital side.

    When it leaves OPERATIONAL, for whatever reason, each output takes its error value if
    its error mode says so, and follows its object again in OPERATIONAL. Faults of its own,
    beside those of `FaultInjection`:

    ``wire_break`` (value: regulator, default 0)
        The monitor's signal is gone: 0 V or 0 mA.
    ``output_stuck`` (value: regulator, default 0)
        The output keeps its signal, whatever is commanded.
    ``emergency_stop`` (value: 1 pressed, 0 released, default 1)
        The e-stop contact.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    node_id : int
        1 … 127.
    port : RegulatorPort
        The plant.
    regulators : sequence of RegulatorWiring
        In the order of the plant's channels.
    outputs, inputs : int
        How many analogue channels the module has.
    output_object, input_object : int
        Indices of the analogue arrays, for modules with objects of their maker.
    output_type, input_type : DataType
        Their types.
    supply_bit : int or None
        Bit of 0x6200:1 that opens the supply valve; None: no valve is wired.
    stop_bit : int or None
        Bit of 0x6000:1 that reads the e-stop contact; None: none is wired.
    stop_active_low : bool
        The contact is normally closed: the bit is 0 when the stop is pressed.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        port: RegulatorPort,
        regulators: Sequence[RegulatorWiring],
        *,
        outputs: int = 4,
        inputs: int = 4,
        output_object: int = 0x6411,
        input_object: int = 0x6401,
        output_type: DataType = INTEGER16,
        input_type: DataType = INTEGER16,
        supply_bit: int | None = 0,
        stop_bit: int | None = 0,
        stop_active_low: bool = True,
        serial: int = 0,
    ) -> None:
        super().__init__(name, node_id, device_type=DEVICE_TYPE, product_code=401, serial=serial)
        self._port = port
        self._regulators = tuple(regulators)
        self._supply_mask = 0 if supply_bit is None else 1 << supply_bit
        self._stop_mask = 0 if stop_bit is None else 1 << stop_bit
        self._stop_active_low = stop_active_low
        self.stop_pressed = False
        self._broken: set[int] = set()
        self._stuck: set[int] = set()
        self._signals = [0.0] * len(self._regulators)
        self._supply: bool | None = None
        self._locked: dict[int, bool] = {}
        self._next_look = inf
        self._reported: list[int] = [0] * inputs
        self._add_digital()
        self._add_analogue(
            (output_object, outputs, output_type), (input_object, inputs, input_type)
        )
        self.add_pdos(
            receive=((0x6200_0108,), _mapping(output_object, outputs, output_type)),
            transmit=((0x6000_0108,), _mapping(input_object, inputs, input_type)),
        )
        self.add_fault("wire_break", self._break_wire, self._broken.clear)
        self.add_fault("output_stuck", self._stick_output, self._stuck.clear)
        self.add_fault("emergency_stop", self._press_stop, lambda: self._press_stop(0.0))
        self.power_on()

    # Objects --------------------------------------------------------------------------

    def _add_digital(self) -> None:
        array = self.dictionary.add_array
        self._digital_input = array(
            0x6000, [Variable(UNSIGNED8, 0, "ro", mapping="t", refresh=self._sample)]
        )[0]
        self._digital_output = array(
            0x6200, [Variable(UNSIGNED8, 0, mapping="r", changed=self._digital_written)]
        )[0]
        self._digital_error_mode = array(0x6206, [Variable(UNSIGNED8, 0xFF)])[0]
        self._digital_error_value = array(0x6207, [Variable(UNSIGNED8, 0)])[0]

    def _add_analogue(
        self, outputs: tuple[int, int, DataType], inputs: tuple[int, int, DataType]
    ) -> None:
        output_object, output_count, output_type = outputs
        input_object, input_count, input_type = inputs

        def array(index: int, count: int, data_type: DataType, default: int) -> list[Variable]:
            return self.dictionary.add_array(
                index, [Variable(data_type, default) for _ in range(count)]
            )

        self._inputs = self.dictionary.add_array(
            input_object,
            [
                Variable(input_type, 0, "ro", mapping="t", refresh=self._sample)
                for _ in range(input_count)
            ],
        )
        self._outputs = self.dictionary.add_array(
            output_object,
            [
                Variable(output_type, 0, mapping="r", changed=self._analogue_written)
                for _ in range(output_count)
            ],
        )
        self._trigger = array(0x6421, input_count, UNSIGNED8, _UPPER | _LOWER | _DELTA)
        self._interrupt = self.dictionary.add(0x6423, 0, Variable(BOOLEAN, 0))
        self._interrupt.changed = self.wake
        self._upper = array(0x6424, input_count, INTEGER32, 0)
        self._lower = array(0x6425, input_count, INTEGER32, 0)
        self._delta = array(0x6426, input_count, UNSIGNED32, 0)
        self._error_mode = self.dictionary.add_array(
            0x6443,
            [Variable(UNSIGNED8, _ERROR_VALUE_MODE, low=0, high=1) for _ in range(output_count)],
        )
        self._error_value = array(0x6444, output_count, INTEGER32, 0)

    # Outputs --------------------------------------------------------------------------

    def apply_outputs(self, now: float) -> None:
        """Drive the wires from the objects."""
        self._drive(self._digital_output.integer)
        for channel, wiring in enumerate(self._regulators):
            self._set_signal(channel, self._outputs[wiring.output - 1].value)

    def enter_operational(self, now: float) -> None:
        """Follow the objects again, which still hold what was commanded last."""
        self.apply_outputs(now)
        self._next_look = now

    def leave_operational(self, now: float) -> None:
        """Take the error values where the error modes ask for them."""
        mode = self._digital_error_mode.integer
        value = self._digital_error_value.integer
        self._drive(self._digital_output.integer & ~mode | value & mode)
        for channel, wiring in enumerate(self._regulators):
            if self._error_mode[wiring.output - 1].value == _ERROR_VALUE_MODE:
                self._set_signal(channel, self._error_value[wiring.output - 1].value)

    def restore_process(self) -> None:
        """Power-on: outputs at 0 counts, supply shut."""
        self._supply = None
        self._locked.clear()
        self.apply_outputs(self.now)

    def _analogue_written(self) -> None:
        # Outside OPERATIONAL an SDO may set outputs as well; it ends the error state.
        self.apply_outputs(self.now)

    def _digital_written(self) -> None:
        self._drive(self._digital_output.integer)

    def _drive(self, bits: int) -> None:
        supply = bool(bits & self._supply_mask) or not self._supply_mask
        if supply is not self._supply:
            self._supply = supply
            self._port.set_supply(supply)
        for channel, wiring in enumerate(self._regulators):
            if wiring.lock_bit is not None:
                locked = not bits >> wiring.lock_bit & 1
                if self._locked.get(channel) is not locked:
                    self._locked[channel] = locked
                    self._port.set_lock(channel, locked)

    def _set_signal(self, channel: int, raw: float | bytes) -> None:
        if channel in self._stuck or isinstance(raw, bytes):
            return
        scale = self._regulators[channel].setpoint
        self._signals[channel] = scale.electrical_from_raw(raw)
        self._port.set_pressure_setpoint(
            channel, scale.pressure_from_electrical(self._signals[channel])
        )

    # Inputs ---------------------------------------------------------------------------

    def sample_inputs(self, now: float) -> None:
        """Convert all monitor signals and read the contacts."""
        for channel, wiring in enumerate(self._regulators):
            scale = wiring.monitor
            signal = (
                0.0
                if channel in self._broken
                else scale.electrical_from_pressure(self._port.pressure(channel))
            )
            variable = self._inputs[wiring.input - 1]
            variable.value = scale.raw_from_electrical(signal, variable.low, variable.high)
        closed = self.stop_pressed is not self._stop_active_low
        self._digital_input.value = self._stop_mask if closed else 0

    def watch_inputs(self, now: float) -> None:
        """Mark the event-driven PDOs whose inputs have changed enough."""
        if now < self._next_look:
            return
        self._next_look = now + _INPUT_PERIOD
        watched = [pdo for pdo in self.pdos.transmit if pdo.can_id and pdo.event_driven]
        if not watched:
            self._next_look = inf
            return
        digital = self._digital_input.value
        self.sample_inputs(now)
        changed = {id(self._digital_input)} if self._digital_input.value != digital else set()
        if self._interrupt.value:
            changed |= {
                id(self._inputs[number])
                for number in range(len(self._inputs))
                if self._triggered(number)
            }
        for pdo in watched:
            if any(id(variable) in changed for variable in pdo.variables):
                pdo.note_change()

    def process_due(self) -> float:
        """Return when the module looks at its inputs again."""
        return self._next_look

    def _triggered(self, number: int) -> bool:
        value, before = self._inputs[number].integer, self._reported[number]
        trigger = self._trigger[number].integer
        upper, lower = self._upper[number].integer, self._lower[number].integer
        delta = self._delta[number].integer
        hit = bool(
            (trigger & _UPPER and upper and before < upper <= value)
            or (trigger & _LOWER and lower and before >= lower > value)
            or (trigger & _DELTA and delta and abs(value - before) > delta)
        )
        if hit:
            self._reported[number] = value
        return hit

    def _sample(self) -> None:
        self.sample_inputs(self.now)

    # Faults ---------------------------------------------------------------------------

    def _break_wire(self, value: float | None) -> None:
        self._broken.add(self._regulator("wire_break", value))

    def _stick_output(self, value: float | None) -> None:
        self._stuck.add(self._regulator("output_stuck", value))

    def _press_stop(self, value: float | None) -> None:
        self.stop_pressed = value is None or bool(value)

    def _regulator(self, fault: str, value: float | None) -> int:
        return whole_number(self.name, fault, value, 0, len(self._regulators) - 1)


def _mapping(index: int, count: int, data_type: DataType) -> tuple[int, ...]:
    """Return the default mapping of an analogue array: what fits into eight bytes."""
    fitting = min(count, 8 // data_type.size)
    return tuple(index << 16 | sub << 8 | 8 * data_type.size for sub in range(1, fitting + 1))
