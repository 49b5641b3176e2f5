"""One emulated servo: its memory, its rules, and the joint that it turns."""

import math
from math import inf

from drivers.sim.dynamixel import control_table as table
from drivers.sim.dynamixel.framing import (
    BEYOND_LIMIT,
    HARDWARE_ALERT,
    NO_ACCESS,
    OUT_OF_RANGE,
    TOO_SHORT,
)
from drivers.sim.servo_encoder import SERVO_PERIOD, ServoEncoder
from drivers.sim.servo_port import ServoPort

_CENTRE = 2048
_TURN = 4096
_VELOCITY_UNIT = 0.229 / 60.0 * math.tau  # rad/s
_WATCHDOG_UNIT = 20e-3  # s
_CURRENT_UNIT = 2.69e-3  # A
_TORQUE_CONSTANT = 1.78  # N m/A
_FIRMWARE = 48
_MOST_WOUND = 0.1  # rad
_VELOCITY_MODE, _MULTI_TURN_MODES = 1, (4, 5)


class Mounting:
    """The mounting of a servo on its joint.

    Parameters
    ----------
    gear : float
        Signed turns of the servo for one turn of the joint.
    offset : float
        The joint's angle at the servo's count 2048, rad.
    """

    def __init__(self, gear: float, offset: float) -> None:
        self.gear = gear
        self._offset = offset

    def counts(self, angle: float) -> int:
        """Return what the servo's encoder reads at a joint angle, rad."""
        return round(_CENTRE + (angle - self._offset) * self.gear / math.tau * _TURN)

    def angle(self, counts: int) -> float:
        """Return the joint angle of a goal, rad."""
        return self._offset + (counts - _CENTRE) / _TURN * math.tau / self.gear

    def velocity_counts(self, velocity: float) -> int:
        """Return what the servo's velocity reads at a joint velocity, rad/s."""
        return round(velocity * self.gear / _VELOCITY_UNIT)

    def velocity(self, counts: int) -> float:
        """Return the joint velocity of a goal, rad/s."""
        return counts * _VELOCITY_UNIT / self.gear


class EmulatedServo:
    """Firmware of one servo.

    Of trajectory profiles only the greatest speed is emulated; else a goal acts at once.

    Parameters
    ----------
    servo : int
        Its id.
    plant : ServoPort
        The physics.
    channel : int
        The plant's joint that it turns.
    mounting : Mounting
        How it sits there.
    model : int
        What it reports.
    indirect_data : int
        Where this model has its indirect data.
    """

    def __init__(
        self,
        servo: int,
        plant: ServoPort,
        channel: int,
        mounting: Mounting,
        *,
        model: int = 1020,
        indirect_data: int = 224,
    ) -> None:
        self.table = table.ControlTable(indirect_data)
        self.encoder = self._plant = ServoEncoder(plant, lambda: self._now)
        self._channel = channel
        self._mounting = mounting
        self._now = 0.0
        self._rate = 0.0  # of its reference, rad/s
        self.due = inf
        """When it has something to do by itself, s."""
        self._trips_at = inf
        self._reference = plant.joint_position(channel)  # of its velocity controller, rad
        self._registered: tuple[int, bytes] | None = None
        self.table[table.ID] = servo
        self.table[table.MODEL] = model
        self.table[table.FIRMWARE] = _FIRMWARE
        self.table[table.RETURN_DELAY] = 0
        self.table[table.VOLTAGE] = 120
        self.table[table.TEMPERATURE] = 35
        self._drive()

    @property
    def id(self) -> int:
        """Return its id."""
        return self.table[table.ID]

    @property
    def alert(self) -> int:
        """Return the bit that goes with every status while there is a hardware error."""
        return HARDWARE_ALERT if self.table[table.HARDWARE_ERROR] else 0

    def hear(self, now: float) -> None:
        """Take that something for it came: the watchdog starts anew."""
        self.tick(now)
        self._feed_watchdog()

    def tick(self, now: float) -> None:
        """Let time pass."""
        self._reference += (now - self._now) * self._rate
        self._now = now
        if now >= self._trips_at:
            self.table[table.WATCHDOG] = -1
            self.table[table.PROFILE_ACCELERATION] = self.table[table.PROFILE_VELOCITY] = 0
            self.table[table.GOAL_VELOCITY] = 0
            self.table[table.GOAL_POSITION] = self._counts()
            self._feed_watchdog()
            self._cap()
            self._drive()
        elif self.encoder.lying:
            self._drive()
        self._plan()

    def _plan(self) -> None:
        """Look when to tick next: an encoder that lies asks for the servo's own loop."""
        self.due = self._trips_at
        if self.encoder.lying:
            self.due = min(self.due, self._now + SERVO_PERIOD)

    # Instructions ---------------------------------------------------------------------

    def identity(self) -> bytes:
        """Return what Ping asks for."""
        return self.table.read(0, 2) + self.table.read(6, 1)

    def read(self, address: int, size: int, now: float) -> tuple[int, bytes]:
        """Return error number and data."""
        if size < 1 or address + size > table.SIZE:
            return NO_ACCESS, b""
        self._measure(now)
        return 0, self.table.read(address, size)

    def write(self, address: int, data: bytes) -> int:
        """Write one or several items; return the error number."""
        while data:
            if self.table.is_indirect(address):  # byte by byte
                real = self.table.resolve(address)
                item, size = self.table.item_at(real), 1
                if item is None or item.size != 1:
                    return NO_ACCESS
            else:
                item = self.table.item_at(address)
                if item is None:
                    return NO_ACCESS
                size = item.size
            if len(data) < size:
                return TOO_SHORT
            error = self._write_item(
                item, int.from_bytes(data[:size], "little", signed=item.signed)
            )
            if error:
                return error
            address, data = address + size, data[size:]
        return 0

    def register(self, address: int, data: bytes) -> int:
        """Keep a write for the next action; return the error number."""
        if self.table.item_at(address) is None:
            return NO_ACCESS
        self._registered = (address, data)
        self.table[table.REGISTERED] = 1
        return 0

    def act(self) -> int | None:
        """Do the write that was kept; return its error number, or None if there is none."""
        if self._registered is None:
            return None
        address, data = self._registered
        self._registered = None
        self.table[table.REGISTERED] = 0
        return self.write(address, data)

    def reboot(self) -> None:
        """Start afresh; EEPROM stays."""
        self.table.power_on()
        self._registered = None
        self._feed_watchdog()
        self._cap()
        self._drive()

    # What may go wrong ----------------------------------------------------------------

    def lie(self, how: str, value: float | None) -> None:
        """Have its encoder lie, see `ServoEncoder`."""
        self.encoder.lie(self._channel, how, value)
        self._plan()

    def fail(self, bit: int) -> None:
        """Have a hardware error; if the Shutdown register says so, it drops the torque."""
        self.table[table.HARDWARE_ERROR] |= 1 << bit
        if self.table[table.SHUTDOWN] >> bit & 1:
            self.table[table.TORQUE] = 0
            self._drive()

    def heat(self, celsius: int) -> None:
        """Have another temperature; above its limit that is a hardware error."""
        self.table[table.TEMPERATURE] = celsius
        if celsius > self.table[table.TEMPERATURE_LIMIT]:
            self.fail(2)

    # Inside ---------------------------------------------------------------------------

    def _write_item(self, item: table.Item, value: int) -> int:
        memory = self.table
        if not item.writable:
            return NO_ACCESS
        has_torque = memory[table.TORQUE] == 1
        locked = item.address < table.EEPROM_END or 168 <= item.address < 224
        if locked and has_torque:
            return NO_ACCESS
        if item in table.GOALS and memory[table.WATCHDOG] == -1:
            return OUT_OF_RANGE
        if not item.low <= value <= item.high:
            return OUT_OF_RANGE
        if item is table.GOAL_POSITION and not self._within_limits(value):
            return BEYOND_LIMIT
        if item is table.GOAL_VELOCITY and abs(value) > memory[table.VELOCITY_LIMIT]:
            return BEYOND_LIMIT
        if item is table.TORQUE and value and memory[table.HARDWARE_ERROR]:
            return 0  # it answers, but its torque stays off until it is rebooted
        memory[item] = value
        if item is table.TORQUE and not has_torque and value:
            memory[table.GOAL_VELOCITY] = 0
            memory[table.GOAL_POSITION] = self._counts()
        if item in (table.TORQUE, table.GOAL_POSITION, table.GOAL_VELOCITY, table.OPERATING_MODE):
            self._drive()
        elif item is table.WATCHDOG:
            self._feed_watchdog()
        elif item is table.PROFILE_VELOCITY:
            self._cap()
        return 0

    def _cap(self) -> None:
        """Have its trajectories be no faster than their profile says; 0 says nothing."""
        counts = self.table[table.PROFILE_VELOCITY]
        speed = abs(self._mounting.velocity(counts)) if counts else inf
        self._plant.limit_joint(self._channel, speed, inf)

    def _feed_watchdog(self) -> None:
        units = self.table[table.WATCHDOG]
        self._trips_at = self._now + units * _WATCHDOG_UNIT if units > 0 else inf
        self._plan()

    def _within_limits(self, counts: int) -> bool:
        memory = self.table
        if memory[table.OPERATING_MODE] in _MULTI_TURN_MODES:
            return True
        return memory[table.MIN_POSITION] <= counts <= memory[table.MAX_POSITION]

    def _drive(self) -> None:
        """Tell the plant what the motor shall do."""
        memory = self.table
        torque_on = memory[table.TORQUE] == 1
        if memory[table.OPERATING_MODE] == _VELOCITY_MODE:
            # The integral of its velocity controller, which does not wind up.
            angle = self._plant.joint_position(self._channel)
            wound = min(max(self._reference - angle, -_MOST_WOUND), _MOST_WOUND)
            self._reference = angle + (wound if torque_on else 0.0)
        else:
            counts = memory[table.GOAL_POSITION] - memory[table.HOMING_OFFSET]
            self._reference = self._mounting.angle(counts)
        self._rate = self._velocity()
        self._plant.command_joint(self._channel, self._reference, self._rate, torque_on)

    def _velocity(self) -> float:
        """Return how fast the reference moves, rad/s."""
        memory = self.table
        if memory[table.OPERATING_MODE] != _VELOCITY_MODE or memory[table.TORQUE] == 0:
            return 0.0
        return self._mounting.velocity(memory[table.GOAL_VELOCITY])

    def _counts(self) -> int:
        angle = self._plant.joint_position(self._channel)
        return self._mounting.counts(angle) + self.table[table.HOMING_OFFSET]

    def _measure(self, now: float) -> None:
        memory, mounting, plant, channel = self.table, self._mounting, self._plant, self._channel
        memory[table.TICK] = int(now * 1000.0) % 32_768
        memory[table.PRESENT_POSITION] = self._counts()
        velocity = mounting.velocity_counts(plant.joint_velocity(channel))
        memory[table.PRESENT_VELOCITY] = velocity
        current = plant.joint_torque(channel) / mounting.gear / _TORQUE_CONSTANT
        memory[table.PRESENT_CURRENT] = max(-2047, min(round(current / _CURRENT_UNIT), 2047))
        memory[table.MOVING] = int(abs(velocity) > memory[table.MOVING_THRESHOLD])
