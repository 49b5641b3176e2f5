"""A chain of Dynamixel X-series servos, one per joint.

References
----------
ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0" and the control table of XM430-W350: Torque Enable
(64), Hardware Error Status (70), Bus Watchdog (98), Goal Velocity (104), Goal Position (116),
Present Current … Present Position (126 … 135).
"""

import struct
from collections.abc import Mapping, Sequence
from math import inf
from typing import Final

from drivers.dynamixel import registers as table
from drivers.dynamixel.bus import SerialBus, SyncWrite
from drivers.dynamixel.client import RegisterClient
from drivers.dynamixel.configure import configure_servo, energise_servo, watchdog_units
from drivers.dynamixel.goal_echo import GoalEcho
from drivers.dynamixel.health import Health, HealthWatch, decode_health
from drivers.dynamixel.motion import MotionWatch
from drivers.dynamixel.payload import SyncPayload
from drivers.dynamixel.scaling import encode_position, encode_velocity, joint_scale
from drivers.dynamixel.settings import DynamixelSettings
from drivers.servos.axis_guard import AxisGuard
from drivers.servos.axis_readings import joined
from drivers.servos.velocity_reference import VelocityReference
from rig.hal import Reading, ServoBus, Vector, not_standing

_ATTEMPTS: Final = 3
_NEVER: Final = -inf


class DynamixelServos(ServoBus):
    """Joints on Dynamixel servos; satisfies `rig.hal.ServoBus`.

    In the position modes a velocity is integrated to positions here. In velocity mode a
    position is followed by a proportional controller here. The safe state is to hold the
    last setpoint under torque, as a robot that stands would fall without (or, with
    ``after_stop: release``, to let go); connecting takes the torque away: support what falls.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.

    Raises
    ------
    ValueError
        Two devices have a servo with the same id on the same bus; the bus has no period; a
        serial number is given.
    """

    Settings = DynamixelSettings
    questions_feed = True

    def __init__(
        self, name: str, settings: DynamixelSettings, bus: SerialBus, *, serial: int | None = None
    ) -> None:
        if bus.period is None:
            raise ValueError(f"{name}: the bus {bus.name} has no period, which servos must know.")
        if serial is not None:
            raise ValueError(f"{name}: Dynamixel servos have no serial number to compare.")
        self.name = name
        self.settings = settings
        self.axis_names = tuple(settings.joints)
        self._bus = bus
        self._period = bus.period
        self._is_velocity = settings.mode == "velocity"
        joints = settings.joints
        ids = tuple(joint.id for joint in joints.values())
        models = tuple(settings.model_of(joint) for joint in joints.values())
        self._scales = tuple(
            joint_scale(joint, model, one_turn=settings.mode == "position")
            for joint, model in zip(joints.values(), models, strict=True)
        )
        self._links = tuple(bus.read.join(joint.id, name, label) for label, joint in joints.items())
        self._clients = tuple(
            RegisterClient(name, label, joint.id, bus) for label, joint in joints.items()
        )

        block = settings.block
        self._unpack = struct.Struct("<" + "".join(register.code for register in block)).unpack
        self._block_address = models[0].indirect_data if settings.health else block[0].address
        self._block_name = f"{block[0]} … {block[-1]}"

        goal = settings.goal
        self._goal = SyncPayload(goal, ids)
        self._echo = GoalEcho(goal, bus, len(joints) if settings.echo else 0)
        self._torque = SyncPayload(table.TORQUE_ENABLE, ids)
        self._watchdog = SyncPayload(table.BUS_WATCHDOG, ids)
        self._watchdog_units = watchdog_units(settings.watchdog)
        self._goals = SyncWrite(goal.address, goal.size, b"")
        self._release = SyncWrite(
            table.TORQUE_ENABLE.address, table.TORQUE_ENABLE.size, self._torque.same(0)
        )
        bus.add_write(self._goals)
        bus.add_write(self._release)
        bus.listen(self._take)

        nothing: Reading[Vector] = Reading((0.0,) * len(joints), _NEVER)
        self._positions = self._velocities = self._torques = nothing
        self._samples: list[tuple[int, ...]] = []
        self._guard = AxisGuard(name, joints, bus.period)
        self._health = HealthWatch(name, settings, self._watchdog_units)
        self._motion = MotionWatch(settings, [scale.step for scale in self._scales], self._health)
        self._velocity_reference = VelocityReference(
            settings.position_gain, [joint.max_speed for joint in joints.values()], bus.period
        )
        self._armed = False
        self._enabled = False

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
            A servo refuses, stands outside its limits, or they send no readings.
        """
        for client in self._clients:
            client.write(table.BUS_WATCHDOG, 0)
        self._health.restart()
        self._start_reading()
        for client, scale, position in zip(
            self._clients, self._scales, self._positions.value, strict=True
        ):
            energise_servo(client, self.settings, scale, position)
        self._hold_here()
        self._goals.active = True
        self._release.active = False
        self._bus.send_ahead(self._watchdog.packet(self._watchdog_units))
        self._health.expect_watchdog()
        self._armed = self._enabled = True

    def listen(self) -> None:
        """Take readings in every cycle from now on, without torque: joints are moved by hand.

        Raises
        ------
        ConnectionFailed
            They send no readings.
        """
        for client in self._clients:
            client.write(table.BUS_WATCHDOG, 0)
        self._health.restart()
        self._start_reading()
        self._armed = True

    def set_torque_enabled(self, enabled: bool) -> None:
        """Have the next cycle energise all joints where they stand, or release them.

        Ignored unless armed.
        """
        if not self._armed:
            return
        self._hold_here()
        self._enabled = enabled
        self._bus.send_ahead(self._torque.packet(int(enabled)))

    def make_safe(self) -> None:
        """Hold the last setpoint at rest, or release the torque, until armed again.

        A servo whose encoder lies is let go of; one whose position has jumped holds its joint
        where it is, as soon as another reading has confirmed it.
        """
        if self._motion.jumped and not self._armed and not self._is_velocity:
            stand = self._positions.value
            goals = self._motion.move_zeros(self._guard.positions, stand, self._period)
            self._goals.payload = self._goal.pack(map(encode_position, self._scales, goals))
        self._armed = self._enabled = False
        for k in sorted(self._motion.blind):  # its loop would run away
            let_go = SyncPayload(table.TORQUE_ENABLE, (self._links[k].id,))
            self._bus.send_ahead(let_go.packet(0))
        if self._is_velocity:
            self._goals.payload = self._goal.same(0)
        if self.settings.after_stop == "release" and self._goals.active:
            self._goals.active = False
            self._release.active = True

    def unsafe(self, now: float) -> str:
        """Return which joints under torque do not stand still; see `Device.unsafe`."""
        age, joints = now - self._velocities.t, self.settings.joints.items()
        held = float(self._goals.active)
        found = [
            not_standing(f"{self.name} joint {name}", age, held * velocity, joint.max_speed)
            for (name, joint), velocity in zip(joints, self._velocities.value, strict=True)
        ]
        return "; ".join(filter(None, found))

    def identity(self) -> Mapping[str, int]:
        """Return model and firmware of every servo, as `connect` got them."""
        said = {client.joint: client.identity._asdict() for client in self._clients}
        return joined(said)

    def written(self) -> Mapping[str, float]:
        """Return the registers that were read back; see `rig.hal.Device.written`."""
        return joined({client.joint: client.written for client in self._clients})

    def follow_still(self) -> tuple[str, ...]:
        """Ask whose watchdog has not tripped; see `rig.hal.ServoBus.follow_still`."""
        read = {client.joint: client.read(table.BUS_WATCHDOG) for client in self._clients}
        return tuple(joint for joint, left in read.items() if left >= 0)

    def close(self) -> None:
        """Ask the servos no more; their watchdogs stop them. Idempotent."""
        self._rest()

    # The cycle ------------------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether the joints follow commands."""
        return self._enabled

    def positions(self) -> Reading[Vector]:
        """Return the joint positions, rad, shape (n,)."""
        return self._positions

    def velocities(self) -> Reading[Vector]:
        """Return the servos' own velocities, rad/s, shape (n,); in steps of 0.024 rad/s."""
        return self._velocities

    def torques(self) -> Reading[Vector]:
        """Return the torques at the joints, N m, shape (n,), from the motor currents.

        A rough value: gears rub. 0 for models that do not measure their current.
        """
        return self._torques

    def health(self) -> Reading[tuple[Health, ...]]:
        """Return what every servo says of itself; empty without `health`."""
        if not self.settings.health:
            return Reading((), _NEVER)
        states = tuple(decode_health(*sample[-len(table.HEALTH) :]) for sample in self._samples)
        return Reading(states, self._positions.t)

    def command_positions(self, positions: Vector) -> None:
        """Take position setpoints for this cycle, rad, shape (n,); ignored unless enabled.

        Raises
        ------
        LimitExceeded
            One is outside its limits, or too far from the one before for its greatest speed.
        """
        if not self._enabled:
            return
        before = self._guard.positions
        self._guard.check_positions(positions)
        if self._is_velocity:
            measured = self._positions.value
            self._send(self._velocity_reference.follow(positions, before, measured))
            return
        goals = []
        for position, (step, origin, _, _, first, last) in zip(
            positions, self._scales, strict=True
        ):
            counts = round(position / step + origin)
            goals.append(first if counts < first else min(counts, last))
        self._aim(goals)

    def command_velocities(self, velocities: Vector) -> None:
        """Take velocity setpoints for this cycle, rad/s, shape (n,); ignored unless enabled.

        Raises
        ------
        LimitExceeded
            One is faster than its joint may be, or would leave its limits in a position mode.
        """
        if not self._enabled:
            return
        self._guard.check_velocities(velocities)
        if self._is_velocity:
            measured = self._guard.positions = self._positions.value
            self._send(self._velocity_reference.turn(velocities, measured))
            return
        self.command_positions(self._guard.moved(velocities, self._period))

    def check(self, now: float) -> None:
        """Raise if a servo is not well.

        Raises
        ------
        DeviceFault
            A hardware error, a tripped or lost watchdog, temperature or voltage out of
            range, a joint that does not follow or does not get its setpoints, answers
            missing, damaged or doubled. The message says joint, id and register, in words.
        """
        if not self._armed:
            return
        self._health.check()
        read = self._bus.read
        for link in self._links:
            if link.missed or link.doubled:
                read.check(link)
        if self._enabled:
            self._echo.check(self._health)
            if not self._is_velocity:
                self._motion.refer(self._guard.positions)
            self._motion.check(self._positions, self._velocities.value)

    # Inside ---------------------------------------------------------------------------

    def _take(self, t: float) -> None:
        """Decode the answers to the reading of time `t`; a whole one, or the last is held."""
        samples = []
        unpack = self._unpack
        for link in self._links:
            if not link.fresh:
                return
            samples.append(unpack(link.data))
        if not self._are_trusted(samples):
            return
        positions, velocities, torques = [], [], []
        for sample, (step, origin, velocity_step, torque_step, _, _) in zip(
            samples, self._scales, strict=True
        ):
            torques.append(torque_step * sample[0])
            velocities.append(velocity_step * sample[1])
            positions.append(step * (sample[2] - origin))
        if self._enabled:
            self._motion.find_jump(self._positions, positions, t)
            self._echo.hear(samples)
        self._positions = Reading(tuple(positions), t)
        self._velocities = Reading(tuple(velocities), t)
        self._torques = Reading(tuple(torques), t)
        self._samples = samples

    def _are_trusted(self, samples: list[tuple[int, ...]]) -> bool:
        """Look at what the servos say of themselves; return whether they are what they were."""
        health, trusted = self._health, True
        if not self.settings.health:
            for k, link in enumerate(self._links):
                if link.alert:
                    health.accept_alert(k)
            return True
        for k, sample in enumerate(samples):
            trusted &= health.accept(k, *sample[-len(table.HEALTH) :])
        return trusted

    def _start_reading(self) -> None:
        """Have the servos asked every cycle, and take first readings."""
        bus = self._bus
        size = self.settings.block_size
        bus.read.start(self._links, self._block_address, size, self._block_name)
        before = self._positions.t
        for _ in range(_ATTEMPTS):
            bus.synchronise()
            bus.wait(bus.settings.reply_timeout)
            bus.receive(bus.clock.now())
            bus.check(bus.clock.now())
            if self._positions.t > before:
                return
        self._health.check()
        missing = [k for k, link in enumerate(self._links) if not link.fresh]
        hint = "; old firmware needs fast_sync: false" if bus.settings.fast_sync else ""
        raise self._clients[missing[0] if missing else 0].failed(
            f"it sends no readings{hint}", register=self._block_name
        )

    def _hold_here(self) -> None:
        """Make the present positions, or standstill, the setpoints: the first makes no bump."""
        positions = self._guard.positions = self._positions.value
        self._echo.reset()
        if self._is_velocity:
            self._goals.payload = self._goal.same(0)
        else:
            self._goals.payload = self._goal.pack(map(encode_position, self._scales, positions))
        self._velocity_reference.reset()
        self._motion.reset(positions, self._bus.clock.now())

    def _aim(self, goals: Sequence[int]) -> None:
        """Make counts of the goal's register the setpoints of this cycle."""
        self._goals.payload = self._goal.pack(goals)
        self._echo.send(goals)

    def _send(self, velocities: Sequence[float]) -> None:
        """Make velocities the setpoints of servos in velocity mode, rad/s."""
        self._aim(list(map(encode_velocity, self._scales, velocities)))
        self._motion.drift(velocities, self._positions.value, self._period)

    def _rest(self) -> None:
        self._armed = self._enabled = False
        self._goals.active = self._release.active = False
        self._bus.read.stop(self._links)
