"""A chain of Dynamixel X-series servos, one per joint.

References
----------
ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0" and the control table of XM430-W350: Torque Enable
(64), Hardware Error Status (70), Bus Watchdog (98), Goal Velocity (104), Goal Position (116),
Present Current … Present Position (126 … 135).
"""

import struct
from collections.abc import Iterable
from math import inf
from typing import Final

from drivers.dynamixel import registers as table
from drivers.dynamixel.bus import SerialBus, SyncWrite
from drivers.dynamixel.client import RegisterClient
from drivers.dynamixel.configure import configure_servo, watchdog_units
from drivers.dynamixel.health import Health, HealthWatch, decode_health
from drivers.dynamixel.protocol import encode_sync_write
from drivers.dynamixel.scaling import encode_position, encode_velocity, joint_scale
from drivers.dynamixel.settings import DynamixelSettings
from rig.hal import ConfigurationError, LimitExceeded, Reading, Vector

_ATTEMPTS: Final = 3
_ROUNDING: Final = 1e-9  # rad beyond a limit that are not worth a fault


class DynamixelServos:
    """Servos on one serial bus; satisfies `rig.hal.ServoBus`.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : DynamixelSettings
        See there.
    bus : SerialBus
        The chain that they hang on.
    serial : int, optional
        Not used: these servos have no serial number.

    Raises
    ------
    ValueError
        Two devices have a servo with the same id on the same bus.
    """

    Settings = DynamixelSettings

    def __init__(
        self, name: str, settings: DynamixelSettings, bus: SerialBus, *, serial: int | None = None
    ) -> None:
        self.name = name
        self.settings = settings
        self.joint_names = tuple(settings.joints)
        self._bus = bus
        joints = tuple(settings.joints.values())
        models = tuple(settings.model_of(joint) for joint in joints)
        self._is_velocity = settings.mode == "velocity"
        self._scales = tuple(
            joint_scale(joint, model.current_step, one_turn=settings.mode == "position")
            for joint, model in zip(joints, models, strict=True)
        )
        self._links = tuple(
            bus.read.join(joint.id, name, label) for label, joint in settings.joints.items()
        )
        self._clients = tuple(
            RegisterClient(name, label, joint.id, bus) for label, joint in settings.joints.items()
        )
        self._ids = tuple(joint.id for joint in joints)
        self._max_speeds = tuple(joint.max_speed for joint in joints)

        block = (*table.MOTION, *table.HEALTH) if settings.health else table.MOTION
        self._block = struct.Struct("<" + "".join(register.code for register in block))
        self._block_address = models[0].indirect_data if settings.health else block[0].address
        self._block_name = f"{block[0]} … {block[-1]}"
        self._watchdog = watchdog_units(settings.watchdog)

        goal = table.GOAL_VELOCITY if self._is_velocity else table.GOAL_POSITION
        self._goal = goal
        self._packer = struct.Struct("<" + f"B{goal.code}" * len(joints))
        self._torque_packer = struct.Struct("<" + f"B{table.TORQUE_ENABLE.code}" * len(joints))
        self._goals = SyncWrite(goal.address, goal.size, b"")
        self._release = SyncWrite(
            table.TORQUE_ENABLE.address,
            table.TORQUE_ENABLE.size,
            self._torque_packer.pack(*self._with_ids((0,) * len(joints))),
        )
        bus.add_write(self._goals)
        bus.add_write(self._release)
        bus.listen(self._take)

        nothing: Reading[Vector] = Reading((0.0,) * len(joints), -inf)
        self._positions = self._velocities = self._currents = nothing
        self._samples: list[tuple[int, ...]] = []
        self._watch = HealthWatch(name, settings, self.joint_names, self._ids, self._watchdog)
        self._setpoint: Vector = nothing.value
        self._armed = False

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Find, identify and configure every servo; leave them without torque.

        Raises
        ------
        ConnectionFailed
            A servo does not answer, is another model, has a hardware error, shares its id
            with another one, or did not take a setting.
        """
        self._rest()
        for client, joint in zip(self._clients, self.settings.joints.values(), strict=True):
            configure_servo(client, self.settings, joint)

    def arm(self) -> None:
        """Switch the torque on, with the present positions as setpoints.

        The bus watchdog is armed with the first cycle of the loop, as nothing is sent
        between here and there.

        Raises
        ------
        ConnectionFailed
            A servo refuses, or they send no readings.
        """
        for client in self._clients:
            client.write(table.BUS_WATCHDOG, 0)
        self._watch.restart()
        self._start_reading()
        self._hold_here()
        for client, position in zip(self._clients, self._positions.value, strict=True):
            self._energise(client, position)
        self._goals.active = True
        self._release.active = False
        packer = struct.Struct("<" + f"B{table.BUS_WATCHDOG.code}" * len(self._ids))
        self._bus.send_ahead(
            encode_sync_write(
                table.BUS_WATCHDOG.address,
                table.BUS_WATCHDOG.size,
                packer.pack(*self._with_ids((self._watchdog,) * len(self._ids))),
            )
        )
        self._watch.expect_watchdog()
        self._armed = True

    def make_safe(self) -> None:
        """Hold the last setpoint at rest, or release the torque, as the profile says."""
        self._armed = False
        if self._is_velocity:
            self._goals.payload = self._packer.pack(*self._with_ids((0,) * len(self._ids)))
        if self.settings.stop == "release":
            self._goals.active = False
            self._release.active = True

    def close(self) -> None:
        """Ask the servos no more. Idempotent."""
        self._rest()

    # The cycle ------------------------------------------------------------------------

    def positions(self) -> Reading[Vector]:
        """Return the joint positions, rad, shape (n,)."""
        return self._positions

    def velocities(self) -> Reading[Vector]:
        """Return the servos' own velocities, rad/s, shape (n,); coarse: 0.024 rad/s."""
        return self._velocities

    def currents(self) -> Reading[Vector]:
        """Return the motor currents, A, shape (n,); 0 for models that do not measure it."""
        return self._currents

    def health(self) -> Reading[tuple[Health, ...]]:
        """Return what every servo says of itself; empty without `health`."""
        if not self.settings.health:
            return Reading((), -inf)
        states = tuple(decode_health(*sample[-len(table.HEALTH) :]) for sample in self._samples)
        return Reading(states, self._positions.t)

    def command_positions(self, positions: Vector) -> None:
        """Take position setpoints for this cycle, rad, shape (n,); ignored unless armed.

        Raises
        ------
        LimitExceeded
            A setpoint is outside its joint's range or not a number. All stay as they were.
        ConfigurationError
            The servos are in velocity mode.
        """
        if self._is_velocity:
            raise ConfigurationError(f"{self.name}: in mode velocity it takes no positions")
        if not self._armed:
            return
        goals = []
        for scale, position in zip(self._scales, positions, strict=True):
            step, origin, _, _, lower, upper, first, last = scale
            if not lower - _ROUNDING <= position <= upper + _ROUNDING:  # nor is a NaN
                self._refuse(positions)
            counts = round(position / step + origin)
            goals.append(first if counts < first else min(counts, last))
        self._goals.payload = self._packer.pack(*self._with_ids(goals))
        self._setpoint = positions

    def command_velocities(self, velocities: Vector) -> None:
        """Take velocity setpoints for this cycle, rad/s, shape (n,); ignored unless armed.

        In the position modes they change nothing: the servo's own feedforward (registers 88
        and 90) takes the velocity from the positions.

        Raises
        ------
        LimitExceeded
            A setpoint is beyond its joint's `max_speed` or not a number. All stay as they were.
        """
        for name, velocity, bound in zip(
            self.joint_names, velocities, self._max_speeds, strict=True
        ):
            if not -bound <= velocity <= bound:
                raise LimitExceeded(
                    f"{self.name}: velocity setpoint of {name}", velocity, -bound, bound, "rad/s"
                )
        if self._armed and self._is_velocity:
            goals = [
                encode_velocity(scale, velocity)
                for scale, velocity in zip(self._scales, velocities, strict=True)
            ]
            self._goals.payload = self._packer.pack(*self._with_ids(goals))

    def set_torque_enabled(self, enabled: bool) -> None:
        """Energise or release all joints with the next cycle; energised, they hold."""
        if enabled:
            self._hold_here()
        switch = (int(enabled),) * len(self._ids)
        self._bus.send_ahead(
            encode_sync_write(
                table.TORQUE_ENABLE.address,
                table.TORQUE_ENABLE.size,
                self._torque_packer.pack(*self._with_ids(switch)),
            )
        )
        self._watch.follow(enabled)

    def check(self, now: float) -> None:
        """Raise if a servo is not well.

        Raises
        ------
        DeviceFault
            A hardware error, a tripped or lost watchdog, temperature or voltage out of
            range, a joint that does not follow, answers missing, damaged or doubled.
        """
        if not self._armed:
            return
        self._watch.check()
        read = self._bus.read
        for link in self._links:
            if link.missed or link.doubled:
                read.check(link)
        if not self._is_velocity:
            self._watch.check_following(self._setpoint, self._positions)

    # Inside ---------------------------------------------------------------------------

    def _take(self, t: float) -> None:
        """Decode the answers to the reading of time `t`; a whole one, or the last is held."""
        samples = []
        unpack = self._block.unpack
        for link in self._links:
            if not link.fresh:
                return
            samples.append(unpack(link.data))
        if not self._are_trusted(samples):
            return
        positions, velocities, currents = [], [], []
        for sample, (step, origin, velocity_step, current_step, *_) in zip(
            samples, self._scales, strict=True
        ):
            currents.append(current_step * sample[0])
            velocities.append(velocity_step * sample[1])
            positions.append(step * (sample[2] - origin))
        self._positions = Reading(tuple(positions), t)
        self._velocities = Reading(tuple(velocities), t)
        self._currents = Reading(tuple(currents), t)
        self._samples = samples

    def _are_trusted(self, samples: list[tuple[int, ...]]) -> bool:
        """Look at what the servos say of themselves; return whether they are what they were."""
        accept, trusted = self._watch.accept, True
        if not self.settings.health:
            for k, link in enumerate(self._links):
                if link.alert:
                    self._watch.accept_alert(k)
            return True
        for k, (_, _, _, error, watchdog, voltage, temperature) in enumerate(samples):
            trusted &= accept(k, error, watchdog, voltage, temperature)
        return trusted

    def _start_reading(self) -> None:
        """Have the servos asked every cycle, and take first readings."""
        bus = self._bus
        bus.read.start(self._links, self._block_address, self._block.size, self._block_name)
        before = self._positions.t
        for _ in range(_ATTEMPTS):
            bus.synchronise()
            bus.wait(bus.settings.reply_timeout)
            bus.receive(bus.clock.now())
            bus.check(bus.clock.now())
            if self._positions.t > before:
                return
        self._watch.check()
        missing = [link for link in self._links if not link.fresh]
        client = self._clients[self._links.index(missing[0])] if missing else self._clients[0]
        raise client.failed("it sends no readings", register=self._block_name)

    def _hold_here(self) -> None:
        """Make the present positions (or standstill) the setpoints."""
        if self._is_velocity:
            self._goals.payload = self._packer.pack(*self._with_ids((0,) * len(self._ids)))
            return
        positions = self._positions.value
        goals = [
            encode_position(scale, position)
            for scale, position in zip(self._scales, positions, strict=True)
        ]
        self._goals.payload = self._packer.pack(*self._with_ids(goals))
        self._setpoint = positions

    def _energise(self, client: RegisterClient, position: float) -> None:
        k = self._clients.index(client)
        scale = self._scales[k]
        if not self._is_velocity:
            lower, upper = scale.lower, scale.upper
            if not lower <= position <= upper:
                raise client.failed(
                    "the joint stands outside its range; move it by hand",
                    register=str(table.PRESENT_POSITION),
                    value=f"{position:.4g} rad",
                    bound=f"{lower:.4g} … {upper:.4g} rad",
                )
            client.write(self._goal, encode_position(scale, position))
        client.write(table.TORQUE_ENABLE, 1)

    def _rest(self) -> None:
        self._armed = False
        self._goals.active = self._release.active = False
        self._bus.read.stop(self._links)

    def _with_ids(self, values: Iterable[int]) -> list[int]:
        flat: list[int] = []
        for servo, value in zip(self._ids, values, strict=True):
            flat += (servo, value)
        return flat

    def _refuse(self, positions: Vector) -> None:
        for name, scale, position in zip(self.joint_names, self._scales, positions, strict=True):
            lower, upper = scale.lower, scale.upper
            if lower - _ROUNDING <= position <= upper + _ROUNDING:
                continue
            raise LimitExceeded(
                f"{self.name}: position setpoint of {name}", position, lower, upper, "rad"
            )
