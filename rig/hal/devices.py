"""What devices can do, as protocols.

Getters never block: they return the last reading, and the age says what it is worth.
I/O happens in the cycle, when a device's bus is drained and its setpoints are sent.
Everything is in SI units: m, rad, s, Pa (gauge). Vectors are tuples of floats, shape (n,).
Drivers inherit these protocols: what has a default need not be written.
"""

from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, Protocol

from rig.hal.columns import Column
from rig.hal.reading import Reading

Vector = tuple[float, ...]

HARMLESS = 20e3
"""Pressure that a chamber may hold when it is said to be safe, Pa gauge."""
VENTED = 12e3
"""Excess over its safe pressure up to which a chamber counts as vented, Pa: above a monitor's
offset and noise, and with these no more than `HARMLESS`, where a piston of 2 cm² pushes with 4 N,
less than its seals hold back. Whose calibration is another unit's is off by twice a monitor's
offset."""
_STILL = 0.05
"""Share of its greatest speed up to which a braked joint counts as standing still."""
_FRESH = 0.1
"""Age above which a reading no longer shows that a device is safe, s: many periods of any bus."""


class Device(Protocol):
    """Something on the rig with a name and a life cycle."""

    name: str

    log_columns: tuple[Column, ...] = ()
    """What it adds to each row of a run's log, see `device_column`; known once it is made."""

    def log_values(self) -> tuple[float, ...]:
        """Return this cycle's values for `log_columns`; called after `check`. Hot path."""
        return ()

    def show_in(self, folder: Path) -> None:
        """Let whoever looks on see what it sees, by a file of the run's folder.

        Called before `connect`; see `rig.hal.pictures`. Default: it takes no pictures.
        """
        return

    @abstractmethod
    def connect(self) -> None:
        """Find, identify, configure and read back; leave it safe and not energised.

        Raises
        ------
        ConnectionFailed
            It did not answer, is of the wrong type, or did not take a setting.
        """

    @abstractmethod
    def arm(self) -> None:
        """Make it follow setpoints from now on (NMT operational, torque on, supply open)."""

    @abstractmethod
    def check(self, now: float) -> None:
        """Raise if the device is not well.

        Raises
        ------
        DeviceFault
            It reported a fault, fell silent, rebooted or behaves implausibly.
        """

    @abstractmethod
    def make_safe(self) -> None:
        """Take the safe state as this cycle's setpoint (vent, zero torque). Never raises."""

    def unsafe(self, now: float) -> str:
        """Return why the device is not known to be safe; empty: its own readings say that it is.

        Asked once `make_safe` has been sent for some cycles, and again until the answer is empty
        or the time for it is over. Default: a device without energy is safe.
        """
        return ""

    def listen(self) -> None:
        """Arm without energising: measure, and leave the torque off. Where it is the same, arm."""
        self.arm()

    def identity(self) -> Mapping[str, int]:
        """Ask what it is before it is armed: serial number, firmware. Default: it cannot tell."""
        return {}

    def written(self) -> Mapping[str, float]:
        """Return what `connect` wrote and read back, raw, by the object's or register's name."""
        return {}

    def doubt(self, now: float) -> str | None:
        """Return what looks wrong now, to name it if the rig gets out of bounds; else None."""
        return None

    @abstractmethod
    def close(self) -> None:
        """Release it. Idempotent, and safe to call in any state."""


def not_standing(name: str, age: float, velocity: float, max_speed: float) -> str:
    """Return why a joint is not known to stand still; empty: its reading says that it does.

    Parameters
    ----------
    name : str
        Of the device and joint.
    age : float
        Of the reading, s.
    velocity, max_speed : float
        Measured, and permitted, rad/s; a joint without power has none to be judged: 0.
    """
    if age <= _FRESH and abs(velocity) > _STILL * max_speed:
        return f"{name}: it still moves, at {velocity:+.3g} rad/s"
    return _not_fresh(name, age)


def _not_fresh(name: str, age: float) -> str:
    """Return that a reading is too old to show that something is safe; empty: it is not."""
    if age <= _FRESH:
        return ""
    return f"{name}: not known to be safe, its last reading is {age:.3g} s old"


def device_column(device: str, quantity: str, unit: str, description: str) -> Column:
    """Return a column of a device's own, ``device.<name>_<quantity>``.

    Parameters
    ----------
    device : str
        Its name in the profile.
    quantity : str
        What it measures, in small letters.
    unit : str
        Of SI; empty for a number without one.
    description : str
        One line for whoever opens the log.
    """
    return Column(f"device.{device.replace('-', '_')}_{quantity}", unit, description)


def _not_vented(
    name: str, channels: tuple[str, ...], reading: Reading[Vector], safe: Vector, now: float
) -> str:
    """Return which chambers hold, or may hold, more than they should (Pa gauge); empty: none."""
    pressures, t = reading
    old = _not_fresh(name, now - t)
    full = ", ".join(
        f"{channel} {'held' if old else 'still holds'} {pressure / 1e3:.1f} kPa"
        for channel, pressure, most in zip(channels, pressures, safe, strict=True)
        if old or pressure - most > VENTED
    )
    return f"{old}: then {full}" if old else f"{name}: {full}" if full else ""


class PressureRegulator(Device, Protocol):
    """Electro-pneumatic regulators, n channels."""

    channels: tuple[str, ...]
    pressure_range: tuple[float, float]

    lockable: tuple[bool, ...] = ()
    """Which of the channels have a valve between regulator and chamber; empty: none has."""

    @abstractmethod
    def pressure(self) -> Reading[Vector]:
        """Return the monitored pressures, Pa gauge, shape (n,)."""

    @abstractmethod
    def set_pressure(self, pressure: Vector) -> None:
        """Take setpoints for this cycle, Pa gauge, shape (n,)."""

    @abstractmethod
    def safe_pressure(self) -> Vector:
        """Return the setpoints that `make_safe` would take now, Pa gauge, shape (n,)."""

    def unsafe(self, now: float) -> str:
        """Return which chambers still hold more than they should; see `Device.unsafe`."""
        return _not_vented(self.name, self.channels, self.pressure(), self.safe_pressure(), now)

    def inspect(self) -> Vector:
        """Ask for the monitored pressures without the cycle, Pa gauge, shape (n,).

        For somebody who only listens: no setpoint and no heartbeat is sent. Default: the last ones.

        Raises
        ------
        ConnectionFailed
            It does not answer.
        """
        return self.pressure().value

    def shut_supply(self, shut: bool) -> bool:
        """Shut or open the supply from the next setpoints on, which go on; return if it has one.

        For an acceptance test: whether the valve vents the rig by itself. Default: it has none.
        """
        return False

    def lock(self, shut: tuple[bool, ...]) -> None:
        """Shut or open the valves from the next setpoints on, shape (n,); ignored unless armed.

        What becomes of the chambers in the safe state is not changed by it.

        Raises
        ------
        ValueError
            A channel is to be shut that has no valve.
        """
        if any(shut):
            raise ValueError(f"{self.name}: no channel has a valve to its chamber")


class ProportionalValves(Device, Protocol):
    """Proportional spool valves, each with a pressure sensor at its chamber, n channels.

    The opening of a spool is -1 where it exhausts the chamber most, 1 where it feeds it most, and 0
    in the middle of its signal; around that it is shut, more or less. Safe is the exhaust.
    """

    channels: tuple[str, ...]
    sensor_range: tuple[float, float]
    """Pressures that the sensors show, Pa gauge."""

    @abstractmethod
    def pressure(self) -> Reading[Vector]:
        """Return the chambers' pressures, Pa gauge, shape (n,)."""

    @abstractmethod
    def set_opening(self, opening: Vector) -> None:
        """Take openings for this cycle, -1 … 1, shape (n,)."""

    def unsafe(self, now: float) -> str:
        """Return which chambers are not vented; see `Device.unsafe`."""
        vented = (0.0,) * len(self.channels)
        return _not_vented(self.name, self.channels, self.pressure(), vented, now)

    def inspect(self) -> Vector:
        """Ask for the pressures without the cycle; see `PressureRegulator.inspect`."""
        return self.pressure().value

    def shut_supply(self, shut: bool) -> bool:
        """Shut or open the supply; see `PressureRegulator.shut_supply`."""
        return False

    def opening_columns(self) -> tuple[Column, ...]:
        """Return columns for the openings that were sent, for a device's `log_columns`."""
        return tuple(
            device_column(self.name, f"opening_{channel}", "", "opening that was sent, -1 … 1")
            for channel in self.channels
        )


class LinearEncoder(Device, Protocol):
    """Linear encoders, n channels."""

    channels: tuple[str, ...]
    stroke: float

    @abstractmethod
    def position(self) -> Reading[Vector]:
        """Return the rod extensions, m, shape (n,), each within 0 … `stroke`."""

    @abstractmethod
    def velocity(self) -> Reading[Vector]:
        """Return the device's own velocities, m/s, shape (n,); often coarse."""


class Markers(NamedTuple):
    """Markers seen in one image; a marker that was not seen is absent, not zero.

    `twists` are the rotations about the markers' normals beyond the shortest from the base's z
    axis there, rad; it is empty if the markers do not show them, as discs do not.
    """

    ids: tuple[int, ...]
    positions: tuple[tuple[float, float, float], ...]
    twists: tuple[float, ...] = ()


class MarkerCamera(Device, Protocol):
    """A camera with its marker detector."""

    @property
    def sphere_radius(self) -> float | None:
        """Radius of the sphere on which the camera believes the marker, m; None: on none."""
        return None

    @property
    def latency(self) -> float | None:
        """What is taken off the arrival of an image to stamp it, s; None: it is not known."""
        return None

    @abstractmethod
    def markers(self) -> Reading[Markers]:
        """Return the newest markers; `t` is the middle of the exposure."""


class LoadCells(Device, Protocol):
    """Load cells, n channels: what a foot stands on."""

    channels: tuple[str, ...]

    @abstractmethod
    def forces(self) -> Reading[Vector]:
        """Return what each bears, N, shape (n,); pressed is positive."""


class InertialSensor(Device, Protocol):
    """An inclinometer with gyroscopes on a body; x forwards, y to the left, z up."""

    @abstractmethod
    def lean(self) -> Reading[Vector]:
        """Return roll and pitch against the vertical, rad, shape (2,)."""

    @abstractmethod
    def turning(self) -> Reading[Vector]:
        """Return the body's rates about its own x and y, rad/s, shape (2,)."""


class ServoBus(Device, Protocol):
    """A chain of servo drives, n joints."""

    axis_names: tuple[str, ...]

    @property
    def is_enabled(self) -> bool:
        """Whether every joint follows setpoints; until then nothing but its brake holds it."""
        return True

    @property
    def oldest_axis(self) -> str:
        """The joint whose reading is older than that of every other; empty: there is none."""
        return ""

    @abstractmethod
    def positions(self) -> Reading[Vector]:
        """Return the joint positions, rad, shape (n,)."""

    @abstractmethod
    def velocities(self) -> Reading[Vector]:
        """Return the drives' own joint velocities, rad/s, shape (n,); often coarse."""

    @abstractmethod
    def command_positions(self, positions: Vector) -> None:
        """Take position setpoints for this cycle, rad, shape (n,)."""

    @abstractmethod
    def command_velocities(self, velocities: Vector) -> None:
        """Take velocity setpoints for this cycle, rad/s, shape (n,)."""

    @abstractmethod
    def set_torque_enabled(self, enabled: bool) -> None:
        """Energise or release all joints."""

    questions_feed: bool = False
    """Whether a question restarts the watchdog: who waits for it says nothing meanwhile."""

    def follow_still(self) -> tuple[str, ...] | None:
        """Ask without the cycle which joints still follow setpoints, by name; None: nobody knows.

        For who only listens, after the master has died: no setpoint and no heartbeat is sent.

        Raises
        ------
        ConnectionFailed
            A drive does not answer.
        """
        return None
