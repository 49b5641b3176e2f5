"""An emulated CiA 401 module with the regulators, e-stop contact and supply valve on it.

References
----------
CiA 401 V3.0: objects, defaults and error modes. Device type 0x000F_0191: profile 401, with
digital inputs and outputs, analogue inputs and outputs (bits 16 … 19).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

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
from drivers.sim.regulator_port import RegulatorPort

DEVICE_TYPE = 0x000F_0191
_ERROR_VALUE_MODE = 1  # 0x6443: take the error value; 0 would hold the last one
_INPUT_PERIOD = 1e-3  # how often the module looks at its inputs for changes, s
_UPPER, _LOWER, _DELTA = 0x01, 0x02, 0x04  # bits of 0x6421


class RegulatorWiring(NamedTuple):
    """The wiring of one regulator to the module.

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


@dataclass(frozen=True, slots=True)
class AnalogueArray:
    """One analogue array of the module.

    Parameters
    ----------
    index : int
        Its object: a module may have one of its maker's.
    count : int
        How many channels the module has there.
    data_type : DataType
        Of each.
    """

    index: int
    count: int = 4
    data_type: DataType = INTEGER16


_OUTPUTS = AnalogueArray(0x6411)
_INPUTS = AnalogueArray(0x6401)


@dataclass(frozen=True, slots=True)
class ModuleBuild:
    """The make of a module, and the wiring of its digital side.

    Parameters
    ----------
    outputs, inputs : AnalogueArray
        Its analogue side.
    supply_bit : int or None
        Bit of 0x6200:1 that opens the supply valve; None: no valve is wired.
    stop_bit : int or None
        Bit of 0x6000:1 that reads the e-stop contact; None: none is wired.
    stop_active_low : bool
        The contact is normally closed: the bit is 0 when the stop is pressed.
    serial : int
        Its serial number.
    """

    outputs: AnalogueArray = _OUTPUTS
    inputs: AnalogueArray = _INPUTS
    supply_bit: int | None = 0
    stop_bit: int | None = 0
    stop_active_low: bool = True
    serial: int = 0


STANDARD_MODULE = ModuleBuild()
"""Four channels each way in the standard's objects, supply and stop on bits 0."""


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
    ``stop_wire_off`` (value: 1 off, 0 on again, default 1)
        The wire of the e-stop contact: it carries no signal while it is off.

    What is not said here is a parameter of `EmulatedNode`.

    Parameters
    ----------
    port : RegulatorPort
        The plant.
    regulators : sequence of RegulatorWiring
        In the order of the plant's channels.
    build : ModuleBuild
        What the module is.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        port: RegulatorPort,
        regulators: Sequence[RegulatorWiring],
        build: ModuleBuild = STANDARD_MODULE,
    ) -> None:
        super().__init__(
            name, node_id, device_type=DEVICE_TYPE, product_code=401, serial=build.serial
        )
        self._port = port
        self._regulators = tuple(regulators)
        self._supply_mask = _mask(build.supply_bit)
        self._stop_mask = _mask(build.stop_bit)
        self._stop_active_low = build.stop_active_low
        self.stop_pressed = False
        self.stop_wire_off = False
        self._broken: set[int] = set()
        self._stuck: set[int] = set()
        self._signals = [0.0] * len(self._regulators)
        self._driven: int | None = None
        self._supply: bool | None = None
        self._locked: dict[int, bool] = {}
        self._next_look = inf
        self._reported: list[int] = [0] * build.inputs.count
        self._add_digital()
        self._add_analogue(build.outputs, build.inputs)
        self.add_pdos(
            receive=((0x6200_0108,), _mapping(build.outputs)),
            transmit=((0x6000_0108,), _mapping(build.inputs)),
        )
        self.add_fault("wire_break", self._break_wire, self._broken.clear)
        self.add_fault("output_stuck", self._stick_output, self._stuck.clear)
        self.add_fault("emergency_stop", self._press_stop, lambda: self._press_stop(0.0))
        self.add_fault("stop_wire_off", self._take_wire_off, lambda: self._take_wire_off(0.0))
        self.power_on()

    # Objects --------------------------------------------------------------------------

    def _add_digital(self) -> None:
        array = self.dictionary.add_array
        self._digital_input = array(
            0x6000, [Variable(UNSIGNED8, 0, "ro", mapping="t", refresh=self._read_contacts)]
        )[0]
        self._digital_output = array(
            0x6200, [Variable(UNSIGNED8, 0, mapping="r", changed=self._digital_written)]
        )[0]
        self._digital_error_mode = array(0x6206, [Variable(UNSIGNED8, 0xFF)])[0]
        self._digital_error_value = array(0x6207, [Variable(UNSIGNED8, 0)])[0]

    def _add_analogue(self, outputs: AnalogueArray, inputs: AnalogueArray) -> None:
        def array(index: int, count: int, data_type: DataType, default: int) -> list[Variable]:
            return self.dictionary.add_array(
                index, [Variable(data_type, default) for _ in range(count)]
            )

        self._inputs = self.dictionary.add_array(
            inputs.index,
            [
                Variable(inputs.data_type, 0, "ro", mapping="t", refresh=self._sample)
                for _ in range(inputs.count)
            ],
        )
        self._outputs = self.dictionary.add_array(
            outputs.index,
            [
                Variable(outputs.data_type, 0, mapping="rt", changed=self._analogue_written)
                for _ in range(outputs.count)
            ],
        )
        self._trigger = array(0x6421, inputs.count, UNSIGNED8, _UPPER | _LOWER | _DELTA)
        self._interrupt = self.dictionary.add(0x6423, 0, Variable(BOOLEAN, 0))
        self._interrupt.changed = self.wake
        self._upper = array(0x6424, inputs.count, INTEGER32, 0)
        self._lower = array(0x6425, inputs.count, INTEGER32, 0)
        self._delta = array(0x6426, inputs.count, UNSIGNED32, 0)
        self._error_mode = self.dictionary.add_array(
            0x6443,
            [Variable(UNSIGNED8, _ERROR_VALUE_MODE, low=0, high=1) for _ in range(outputs.count)],
        )
        self._error_value = array(0x6444, outputs.count, INTEGER32, 0)

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
        self._driven = self._supply = None
        self._locked.clear()
        self.apply_outputs(self.now)

    def _analogue_written(self) -> None:
        # Outside OPERATIONAL an SDO may set outputs as well; it ends the error state.
        self.apply_outputs(self.now)

    def _digital_written(self) -> None:
        self._drive(self._digital_output.integer)

    def _drive(self, bits: int) -> None:
        if bits == self._driven:
            return
        self._driven = bits
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
        self._read_contacts()

    def _read_contacts(self) -> None:
        closed = self.stop_pressed is not self._stop_active_low and not self.stop_wire_off
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

    def _take_wire_off(self, value: float | None) -> None:
        self.stop_wire_off = value is None or bool(value)

    def _regulator(self, fault: str, value: float | None) -> int:
        return whole_number(self.name, fault, value, 0, len(self._regulators) - 1)


def _mapping(array: AnalogueArray) -> tuple[int, ...]:
    """Return the default mapping of an analogue array: what fits into eight bytes."""
    size = array.data_type.size
    fitting = min(array.count, 8 // size)
    return tuple(array.index << 16 | sub << 8 | 8 * size for sub in range(1, fitting + 1))


def _mask(bit: int | None) -> int:
    return 0 if bit is None else 1 << bit
