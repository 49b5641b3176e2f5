"""Linear encoders after CiA 406.

References
----------
CiA 406 V3.2: 0x6004 position, 0x6005 measuring steps (1 nm and 0.01 mm/s), 0x6020 and 0x6030
positions and speeds of several sensors, 0x6503 alarms, 0x6509 offset.
"""

from math import inf
from typing import Any, Final

from drivers.canopen.bus import CanopenBus
from drivers.canopen.identified import IdentifiedDevice
from drivers.canopen.inputs import CyclicInputs
from drivers.canopen.mapping import RANGES
from drivers.canopen.node import CanopenNode
from drivers.cia406.codec import (
    LinearCodec,
    decode_velocity,
    describe_alarms,
    linear_codec,
    position_decoder,
)
from drivers.cia406.settings import PROFILE, Cia406Settings
from rig.hal import ConnectionFailed, DeviceFault, LinearEncoder, Reading, Vector

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

_ROTARY: Final = (1, 2)  # upper word of the device type: single-turn and multi-turn
_POSITION_UNIT: Final = 1e-9  # of 0x6005:1, m
_SPEED_UNIT: Final = 1e-5  # of 0x6005:2, m/s


class Cia406Encoder(IdentifiedDevice, LinearEncoder):
    """One linear encoder; satisfies `rig.hal.LinearEncoder` with one channel.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.
    """

    Settings = Cia406Settings

    def __init__(
        self, name: str, settings: Cia406Settings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        self.name = name
        self.settings = settings
        self.channels = (name,)
        self.stroke = settings.stroke
        self._bus = bus
        self._serial = serial
        self._node = CanopenNode(name, settings.node, bus)
        self._layout = settings.transmit_entries
        self._inputs = CyclicInputs(
            name,
            settings.node,
            bus,
            (self._layout,),
            self._take,
            hold_after=settings.hold_after,
            fault_after=settings.fault_after,
        )
        self._use(
            linear_codec(
                settings, settings.step or _POSITION_UNIT, settings.speed_step or _SPEED_UNIT
            )
        )
        self._max_speed = settings.max_speed
        self._lowest = -settings.overtravel
        self._highest = settings.stroke + settings.overtravel
        self._frozen_timeout = inf if settings.frozen_timeout is None else settings.frozen_timeout
        self._has_speed = settings.speed is not None
        self._has_alarms = settings.alarms == "mapped"
        low, high = RANGES.get(settings.position.type, (-inf, inf))
        self._half_turn = 0.5 * (high - low)
        self._extension = 0.0
        self._sampled_at = -inf
        self._counts: float | None = None
        self._speed_counts: float | None = None
        self._moved_at = 0.0
        self._earlier = -inf
        self._trouble: DeviceFault | None = None
        self._armed = False

    # Codec ----------------------------------------------------------------------------

    def _use(self, codec: LinearCodec) -> None:
        self._codec = codec
        self._decode = position_decoder(codec)
        self._rounding = 2.0 * abs(codec.gain)

    def _take(self, values: tuple[Any, ...], t: float) -> None:
        """Decode a sample; one that cannot be true is not taken, and is a fault. Hot path."""
        counts = values[0]
        if self._has_alarms and values[-1]:
            self._latch_alarm(values[-1])
            return
        extension = self._decode(counts)
        before, then = self._counts, self._sampled_at
        if before is None:
            self._moved_at = t
        else:
            # A late sample and the next one come in one cycle and bear the same time.
            since = then if t > then else self._earlier
            reach = self._max_speed * (t - since) + self._rounding
            moved = extension - self._extension
            if not -reach <= moved <= reach:
                self._latch_jump(counts, before, moved, reach)
                return
            if counts != before:
                self._moved_at = t
        if t > then:
            self._earlier = then
        self._counts = counts
        self._extension = extension
        self._sampled_at = t
        if self._has_speed:
            self._speed_counts = values[1]

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Find, identify and configure the encoder; read its measuring steps.

        Raises
        ------
        ConnectionFailed
            It does not answer, is another device, reports an alarm, has a preset that the
            profile does not know, or did not take a setting.
        """
        self._armed = False
        settings, node = self.settings, self._node
        kind = node.connect(
            profile=PROFILE,
            vendor=settings.vendor,
            product=settings.product,
            serial=self._serial,
        )
        if kind in _ROTARY:
            raise self._refused("it is a rotary encoder", "0x1000:00", f"type {kind}", "linear")
        self._use(linear_codec(settings, self._read_step(), self._read_speed_step()))
        if settings.alarms != "off":
            alarms = int(node.read(0x6503, 0, "u16"))
            if alarms:
                raise self._refused(
                    f"it reports an alarm: {describe_alarms(alarms)}",
                    "0x6503:00",
                    f"0x{alarms:04X}",
                    "none",
                )
        if settings.preset_offset is not None:
            preset = int(node.read(0x6509, 0, "i32"))
            if preset != settings.preset_offset:
                raise self._refused(
                    "its zero was moved by a preset since the profile was written",
                    "0x6509:00",
                    f"{preset} counts",
                    f"{settings.preset_offset} counts",
                )
        node.map_pdos((), (self._layout,), remap=settings.remap)

    def arm(self) -> None:
        """Start the node and take a first reading.

        Raises
        ------
        ConnectionFailed
            It does not become OPERATIONAL, or sends no reading.
        """
        self._node.arm()
        self._trouble = None
        self._counts = None
        self._earlier = -inf
        self._inputs.take_first()
        self._armed = True

    def make_safe(self) -> None:
        """Do nothing: an encoder moves nothing."""

    def close(self) -> None:
        """Expect nothing of the encoder any more. Idempotent."""
        self._armed = False
        self._node.disarm()

    # The cycle ------------------------------------------------------------------------

    def position(self) -> Reading[Vector]:
        """Return the rod's extension, m, shape (1,)."""
        return _new(Reading, ((self._extension,), self._sampled_at))

    def velocity(self) -> Reading[Vector]:
        """Return the device's own velocity, m/s, shape (1,); never fresh if it has none."""
        if self._speed_counts is None:
            return Reading((0.0,), -inf)
        return Reading((decode_velocity(self._codec, self._speed_counts),), self._sampled_at)

    def check(self, now: float) -> None:
        """Raise if the encoder is not well.

        Raises
        ------
        DeviceFault
            Emergency, silence, reboot, missing or malformed readings, an alarm, a jump, a
            wrap-around, a position outside the stroke, or no change for too long.
        """
        # What it says of itself tells more than what follows from it.
        if self._trouble is not None:
            raise self._trouble
        self._node.check(now)
        if not self._armed:
            return
        self._inputs.check(now)
        if not self._lowest <= self._extension <= self._highest:
            raise self._fault(
                "the rod's position is outside its stroke",
                f"{self._extension:.6g} m",
                f"{self._lowest:g} … {self._highest:g} m",
            )
        unmoved = self._sampled_at - self._moved_at
        if unmoved > self._frozen_timeout:
            raise self._fault(
                "the position has not changed by a single count; the encoder is frozen",
                f"{unmoved:.3f} s",
                f"{self._frozen_timeout:g} s",
            )

    # Inside ---------------------------------------------------------------------------

    def _read_step(self) -> float:
        return self._compare_step(1, _POSITION_UNIT, self.settings.step, "m")

    def _read_speed_step(self) -> float:
        if not self._has_speed:
            return 0.0
        return self._compare_step(2, _SPEED_UNIT, self.settings.speed_step, "m/s")

    def _compare_step(self, sub: int, unit: float, configured: float | None, si: str) -> float:
        """Return a measuring step, m or m/s: the device's, or the profile's if it has none."""
        thing = f"0x6005:{sub:02X}"
        found = self._node.read_if_present(0x6005, sub, "u32")
        if found is None or found == 0:
            if configured is None:
                raise self._refused(
                    "it does not tell its measuring step, and the profile does not either",
                    thing,
                    "absent" if found is None else "0",
                    "a step",
                )
            return configured
        # Divided, not multiplied by the unit: 1000 nm is then the same float as 1e-6 m.
        step = found / round(1.0 / unit)
        if configured is not None and abs(configured - step) > 1e-6 * step:
            raise self._refused(
                "its measuring step is not the profile's",
                thing,
                f"{step:g} {si}",
                f"{configured:g} {si}",
            )
        return step

    def _latch_alarm(self, alarms: int) -> None:
        if self._trouble is None:
            self._trouble = DeviceFault(
                self.name,
                f"it reports an alarm: {describe_alarms(alarms)}",
                node=self.settings.node,
                object="0x6503:00",
                value=f"0x{alarms:04X}",
            )

    def _latch_jump(self, counts: float, before: float, jump: float, reach: float) -> None:
        if self._trouble is not None:
            return
        wrapped = abs(counts - before) > self._half_turn
        self._trouble = self._fault(
            "the position counter wrapped around"
            if wrapped
            else "the position jumped, or the rod was pushed",
            f"{jump:+.6g} m",
            f"{reach:.3g} m",
        )

    def _fault(self, what: str, value: str, bound: str) -> DeviceFault:
        return DeviceFault(
            self.name,
            what,
            node=self.settings.node,
            object=str(self._layout[0]),
            value=value,
            bound=bound,
        )

    def _refused(self, what: str, thing: str, value: str, bound: str) -> ConnectionFailed:
        return ConnectionFailed(
            self.name, what, node=self.settings.node, object=thing, value=value, bound=bound
        )
