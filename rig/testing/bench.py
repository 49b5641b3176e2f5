"""One device of a profile in a loop of its own, without a mechanism or a law."""

from collections.abc import Callable
from pathlib import Path
from typing import Generic, Protocol, TypeVar, cast

from rig.assembly import REGISTRY, Backend, build_rig
from rig.config import find_configs, load_profile
from rig.hal import Clock, Device

Tested = TypeVar("Tested", bound=Device, covariant=True)


class Bench(Protocol[Tested]):
    """A device with what it hangs on, in simulation."""

    @property
    def device(self) -> Tested:
        """The device."""

    @property
    def clock(self) -> Clock:
        """The rig's clock, in virtual time."""

    @property
    def period(self) -> float:
        """Of the cycle, s."""

    def open(self) -> None:
        """Open the bus and connect the device."""

    def start(self) -> None:
        """Open, arm, and run a few cycles."""

    def run(self, cycles: int, command: Callable[[], object] | None = None) -> None:
        """Run cycles of the loop; `command` gives setpoints where a mechanism would."""

    def safe_cycles(self, cycles: int) -> None:
        """Make safe in each of so many cycles."""

    def restart(self) -> None:
        """Close the device, connect it and arm it again, with all that has to be told along."""

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the device happen now."""

    def close(self) -> None:
        """Make safe and close everything."""


class _Faulty(Protocol):
    """A simulated device, or a whole emulated rig."""

    def inject(self, *what: object) -> None:
        """Make a fault happen now."""


class _SimulatedClock(Protocol):
    @property
    def world(self) -> _Faulty: ...


class ProfileBench(Generic[Tested]):
    """A device of a profile; the others on the rig are exchanged with, and made safe, along.

    Parameters
    ----------
    configs : Path
        The folder of the configurations.
    rig : str
        The profile.
    device : str
        Of the profile.
    backend : str
        ``sim`` or ``virtual``.
    """

    def __init__(self, configs: Path, rig: str, device: str, backend: str) -> None:
        profile = load_profile(rig, REGISTRY, (), find_configs(configs))
        self._rig = build_rig(profile, Backend(backend))
        self._on_bus = backend == "virtual"
        self.name = device
        self.device = cast("Tested", self._rig.devices[device])
        self.clock = self._rig.clock
        self.period = profile.loop.period

    def open(self) -> None:
        """Open the buses and connect every device."""
        self._rig.__enter__()

    def start(self) -> None:
        """Open, arm every device, and run a few cycles."""
        self.open()
        self._rig.arm()
        self.run(3)

    def run(self, cycles: int, command: Callable[[], object] | None = None) -> None:
        """Run cycles of the loop; see `Bench`."""
        rig = self._rig
        for _ in range(cycles):
            now = self.clock.now()
            for bus in rig.buses.values():
                bus.receive(now)
            for device in rig.devices.values():
                device.check(now)
            for bus in rig.buses.values():
                bus.check(now)
            if command is not None:
                command()
            self._send(now)

    def safe_cycles(self, cycles: int) -> None:
        """Make every device safe in each of so many cycles."""
        for _ in range(cycles):
            now = self.clock.now()
            for device in self._rig.devices.values():
                device.make_safe()
            for bus in self._rig.buses.values():
                bus.receive(now)
            self._send(now)

    def restart(self) -> None:
        """Close, connect and arm all devices: one alone leaves the others without a master."""
        for device in self._rig.devices.values():
            device.close()
        for device in self._rig.devices.values():
            device.connect()
        self._rig.arm()

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the device happen now."""
        if self._on_bus:
            cast("_SimulatedClock", self.clock).world.inject(self.name, fault, value)
        else:
            cast("_Faulty", self.device).inject(fault, value)

    def close(self) -> None:
        """Make safe and close everything."""
        self._rig.close()

    def _send(self, now: float) -> None:
        for bus in self._rig.buses.values():
            bus.transmit(now)
        self.clock.sleep_until(now + self.period)
