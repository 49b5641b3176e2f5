"""An emulated linear encoder after CiA 406, device class C2.

References
----------
CiA 406 V3.2; object set and defaults as in the manuals of linear encoders on the market.
Device type 0x0008_0196: profile 406 in the low word, encoder type 8
"absolute linear encoder" in the high word, as TR-Electronic's LA-46/LMRI-46 and SIKO's
MSA501 report it (1 and 2 are single-turn and multi-turn rotary, 10 is multi-sensor).
"""

from collections import deque
from functools import partial
from typing import Protocol

from drivers.sim.nodes import emergency as emcy
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.faults import whole_number
from drivers.sim.nodes.nmt import NmtState
from drivers.sim.nodes.object_dictionary import (
    INTEGER16,
    INTEGER32,
    UNSIGNED16,
    UNSIGNED32,
    Abort,
    SdoAbortError,
    Variable,
)
from drivers.sim.rod_faults import ROD_FAULTS, RodFaults

DEVICE_TYPE_ABSOLUTE_LINEAR = 0x0008_0196

_MOST_CHANNELS = 64
_SPEED_WINDOW = 0.01  # the device derives speed over this time from its own samples, s
_METRES_PER_STEP_UNIT = 1e-9  # 0x6005:1 and 0x6501 count nanometres
_SPEED_PER_UNIT = 1e-5  # 0x6005:2 counts 0.01 mm/s
_ALARM_POSITION_ERROR = 0x0001
_REVERSED = 0x0008  # bit 3 of 0x6000: measuring direction
_SCALING = 0x0004  # bit 2 of 0x6000


class PositionPort(Protocol):
    """Rods of a plant, as an encoder needs them."""

    def position(self, channel: int) -> float:
        """Return the true extension of a rod, m."""


class EmulatedCia406(EmulatedNode):
    """A linear encoder that measures one rod of the plant.

    Faults of its own, beside those of `FaultInjection`:

    ``frozen`` (value: s, default for ever)
        Position stays where it was, speed says 0.
    ``jump`` (value: m, default 5 mm)
        From now on every position is off by this much.
    ``other_rod`` (value: the plant's channel)
        It is mounted on another rod.
    ``alarm``
        Position error: bit 0 of 0x6503, EMCY 0x7300, as when the magnet is missing.
    those of `RodFaults`
        It measures wrongly and does not know.

    What is not said here is a parameter of `EmulatedNode`.

    Parameters
    ----------
    port : PositionPort
        The plant.
    channel : int
        The plant's channel that it measures.
    stroke : float
        Measuring range, m.
    step : float
        Measuring step, m; a whole number of nanometres.
    speed_step : float
        Step of the speed object, m/s; a whole number of 0.01 mm/s.
    offset : float
        Reading at zero extension, m.
    reversed_direction : bool
        Counts down as the rod extends, until 0x6000 says otherwise.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        port: PositionPort,
        channel: int,
        *,
        stroke: float = 0.1,
        step: float = 1e-6,
        speed_step: float = 1e-5,
        offset: float = 0.0,
        reversed_direction: bool = False,
        serial: int = 0,
    ) -> None:
        super().__init__(
            name,
            node_id,
            device_type=DEVICE_TYPE_ABSOLUTE_LINEAR,
            product_code=406,
            serial=serial,
        )
        self._port = port
        self._channel = self._own_channel = channel
        self._step = step
        self._speed_step = speed_step
        self._zero = offset
        self._samples: deque[tuple[float, float]] = deque()
        self._jump = 0.0
        self._add_objects(
            step=round(step / _METRES_PER_STEP_UNIT),
            speed_step=round(speed_step / _SPEED_PER_UNIT),
            range_steps=round(stroke / step),
            parameters=_SCALING | (_REVERSED if reversed_direction else 0),
        )
        self.add_pdos(receive=(), transmit=((0x6004_0020,), (0x6004_0020,)))
        # As shipped: TPDO1 by event timer (off), TPDO2 on every SYNC.
        self.dictionary.find(0x1800, 2).default = 254
        self.dictionary.find(0x1801, 2).default = 1
        self._held: float | None = None
        self.add_fault("frozen", self._freeze)
        self.add_fault("jump", self._start_jump, self._restore_position)
        self.add_fault("other_rod", self._mount_elsewhere, self._mount_back)
        self._errors = RodFaults(name)
        for fault in ROD_FAULTS:
            self.add_fault(fault, partial(self._measure_wrongly, fault), self._errors.clear)
        self.add_fault("alarm", lambda value: self._raise_alarm(), self._clear_alarm)
        self.power_on()

    def _add_objects(
        self, *, step: int, speed_step: int, range_steps: int, parameters: int
    ) -> None:
        add = self.dictionary.add

        def sample() -> None:
            self.sample_inputs(self.now)

        def constant(index: int, value: int) -> None:
            add(index, 0, Variable(UNSIGNED16, value, "ro"))

        self._parameters = add(0x6000, 0, Variable(UNSIGNED16, parameters))
        add(0x6002, 0, Variable(UNSIGNED32, range_steps, "ro"))
        self._preset = add(
            0x6003,
            0,
            Variable(INTEGER32, 0, check=self._check_preset, changed=self._apply_preset),
        )
        self._position = add(0x6004, 0, Variable(INTEGER32, 0, "ro", mapping="t", refresh=sample))
        self.dictionary.add_array(
            0x6005,
            [Variable(UNSIGNED32, step, "ro"), Variable(UNSIGNED32, speed_step, "ro")],
        )
        self._speed = self.dictionary.add_array(
            0x6030, [Variable(INTEGER16, 0, "ro", mapping="t", refresh=sample)]
        )[0]
        self._timer = add(
            0x6200,
            0,
            Variable(UNSIGNED16, 0, changed=self._timer_to_pdo, refresh=self._timer_from_pdo),
        )
        add(0x6500, 0, Variable(UNSIGNED16, parameters, "ro", refresh=self._copy_status))
        add(0x6501, 0, Variable(UNSIGNED32, step, "ro"))
        self._alarms = add(0x6503, 0, Variable(UNSIGNED16, 0, "ro", mapping="t"))
        constant(0x6504, _ALARM_POSITION_ERROR)
        self._warnings = add(0x6505, 0, Variable(UNSIGNED16, 0, "ro", mapping="t"))
        constant(0x6506, 0)
        add(0x6507, 0, Variable(UNSIGNED32, 0x0100_0302, "ro"))  # software 1.0, profile 3.2
        add(0x6508, 0, Variable(UNSIGNED32, 0xFFFF_FFFF, "ro"))  # operating time: not counted
        self._offset = add(0x6509, 0, Variable(INTEGER32, 0, "ro"))

    def sample_inputs(self, now: float) -> None:
        """Measure position and derive speed from the samples of the last window."""
        position = self._measured_steps()
        self._position.value = _saturate(position + self._offset.integer, INTEGER32.high)
        if "frozen" in self.lasting:
            self._speed.value = 0
            return
        samples = self._samples
        if samples and now <= samples[-1][0]:
            return
        samples.append((now, position))
        while len(samples) > 2 and samples[1][0] <= now - _SPEED_WINDOW:
            samples.popleft()
        started, first = samples[0]
        if now > started:
            speed = (position - first) * self._step / (now - started)
            self._speed.value = _saturate(round(speed / self._speed_step), INTEGER16.high)

    def restore_process(self) -> None:
        """Forget the samples; a preset, which is kept in EEPROM, survives."""
        self._samples.clear()

    def _measured_steps(self) -> int:
        held = self._held if "frozen" in self.lasting else None
        extension = (self._extension() if held is None else held) + self._zero
        if self._parameters.integer & _REVERSED:
            extension = -extension
        return round((extension + self._jump) / self._step)

    def _extension(self) -> float:
        return self._errors.measured(self._port.position(self._channel), self.now)

    def _check_preset(self, _: int) -> None:
        if self.state is not NmtState.PRE_OPERATIONAL:
            raise SdoAbortError(Abort.DEVICE_STATE)

    def _apply_preset(self) -> None:
        offset = self._preset.integer - self._measured_steps()
        # In EEPROM: the default too, so that it survives a reset.
        self._offset.value = self._offset.default = offset
        self._preset.default = self._preset.value
        self.sample_inputs(self.now)

    def _timer_to_pdo(self) -> None:
        timer = self.dictionary.find(0x1800, 5)
        timer.value = self._timer.value
        if timer.changed is not None:
            timer.changed()

    def _timer_from_pdo(self) -> None:
        self._timer.value = self.dictionary.find(0x1800, 5).value

    def _copy_status(self) -> None:
        self.dictionary.find(0x6500, 0).value = self._parameters.value

    def _freeze(self, duration: float | None) -> None:
        """Hold what is measured now, though nobody may have asked yet, and whatever resets come."""
        self._held = self._extension()
        self._last_for("frozen", duration)

    def _start_jump(self, value: float | None) -> None:
        self._jump += 5e-3 if value is None else value

    def _restore_position(self) -> None:
        self.lasting.discard("frozen")
        self._jump = 0.0

    def _measure_wrongly(self, fault: str, value: float | None) -> None:
        self._errors.inject(fault, value, self._port.position(self._channel), self.now)

    def _mount_elsewhere(self, value: float | None) -> None:
        self._channel = whole_number(self.name, "other_rod", value, 0, _MOST_CHANNELS - 1)

    def _mount_back(self) -> None:
        self._channel = self._own_channel

    def _raise_alarm(self) -> None:
        self._alarms.value = _ALARM_POSITION_ERROR
        # Error register bits 0 and 5, as TR-Electronic describes for a missing magnet.
        self.emergency.raise_error("position", emcy.SENSOR_FAULT, emcy.PROFILE)

    def _clear_alarm(self) -> None:
        self._alarms.value = 0
        self.emergency.clear_error("position")


def _saturate(value: int, high: float) -> int:
    return value if -high - 1 <= value <= high else int(min(max(value, -high - 1), high))
