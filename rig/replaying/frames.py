"""A run's frames through the drivers at hand: from what was on the bus to what the log says."""

import os
from collections.abc import Sequence
from functools import partial

from rig.assembly import Backend
from rig.assembly.buses import is_can, make_bus
from rig.assembly.frame_reading import frames_of_run, read_frames
from rig.assembly.frame_recording import FRAMES
from rig.assembly.production import make_devices, make_mechanism
from rig.assembly.rig import Rig
from rig.assembly.watchful_clock import WatchfulClock
from rig.config import Profile
from rig.hal import ConfigurationError, FastCanBus, SafetyError
from rig.hal.files import read_regular
from rig.hal.frames import LoggedFrame
from rig.replaying.recorded import RecordedRun

_RESOLUTION = 1e-6
"""Of the times in a file of frames, s."""
_MOST_FRAMES = 1 << 27
"""Of a run: hours on a full bus."""


class ReplayClock:
    """A clock that stands still until somebody sleeps or the next cycle of the log begins."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """Return the rig's time, s."""
        return self._now

    def sleep_until(self, t: float) -> None:
        """Go to a time, s; one that has passed changes nothing."""
        self._now = max(self._now, t)


class ReplayedBus(FastCanBus):
    """A CAN interface on which a recorded conversation is held once more.

    Frames come when they came, and the drivers have to say what they said then: what was received
    after a frame that they sent may be its answer.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    clock : ReplayClock
        The rig's.
    frames : sequence of LoggedFrame
        Of this bus, with their times on that clock.

    Attributes
    ----------
    is_over : bool
        Nothing more is compared: the rig is being closed.
    """

    def __init__(self, name: str, clock: ReplayClock, frames: Sequence[LoggedFrame]) -> None:
        self.is_over = False
        self._name = name
        self._clock = clock
        self._frames = frames
        self._next = 0

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return what had come by now, up to the next frame that the drivers sent."""
        frames, first = self._frames, self._next
        until = self._clock.now() + _RESOLUTION
        end = min(first + limit, len(frames))
        while self._next < end:
            frame = frames[self._next]
            if frame.is_sent or frame.time > until:
                break
            self._next += 1
        return [(frame.can_id, frame.data) for frame in frames[first : self._next]]

    def send_data(self, can_id: int, data: bytes) -> None:
        """Take a frame of the drivers, if it is the one that was sent here.

        Raises
        ------
        SafetyError
            It is another one.
        """
        if self.is_over:
            return
        told = self._frames[self._next] if self._next < len(self._frames) else None
        if told is None or (told.is_sent, told.can_id, told.data) != (True, can_id, data):
            then = "nothing more" if told is None else f"{told.can_id:03X}#{told.data.hex()}"
            way = "" if told is None or told.is_sent else " received"
            raise SafetyError(
                f"{self._name}: the drivers at hand send {can_id:03X}#{data.hex()} at "
                f"{self._clock.now():.6f} s, where the frames have {then}{way}"
            )
        self._next += 1

    def shutdown(self) -> None:
        """Release nothing: there is no interface."""


def _with_ways(run: RecordedRun, frames: list[LoggedFrame]) -> list[LoggedFrame]:
    """Return frames with who sent them, which stands in a file of its own."""
    from drivers.can.frame_log import SENT, WAYS

    path = run.folder.path / f"{FRAMES}{WAYS}"
    ways = read_regular(path, _MOST_FRAMES) if os.path.lexists(path) else b""
    if len(ways) != len(frames):
        raise ConfigurationError(
            f"{run.folder.path}: {path.name} says of {len(ways)} frames who sent them, and there "
            f"are {len(frames)}; it is written by --frames in this version"
        )
    return [frame._replace(is_sent=way == SENT[0]) for frame, way in zip(frames, ways, strict=True)]


class FramesRig:
    """The rig of a recorded run, connected to its frames.

    Parameters
    ----------
    run : RecordedRun
        Recorded in virtual time with ``--frames``.

    Raises
    ------
    ConfigurationError
        It has no frames, or they do not hold all that was read.
    RigError
        The drivers at hand do not come as far as the first cycle.
    """

    def __init__(self, run: RecordedRun) -> None:
        profile = run.plan.profile
        _check_has_all(profile)
        origin = _origin_of_frames(run)
        told = _with_ways(run, list(read_frames(frames_of_run(run.folder.path), profile)))
        self.clock = ReplayClock()
        self._interfaces = {
            name: ReplayedBus(
                name,
                self.clock,
                [f._replace(time=f.time - origin) for f in told if f.channel == name],
            )
            for name in profile.buses
        }
        waits, period = WatchfulClock(self.clock), profile.loop.period
        self.buses = {
            name: make_bus(
                name, entry, waits, period, opened=partial(self._interfaces.__getitem__, name)
            )
            for name, entry in profile.buses.items()
        }
        self.devices = make_devices(profile, self.buses, waits)
        self.mechanism = make_mechanism(profile, self.devices)
        self._rig = Rig(
            profile, Backend.VIRTUAL, clock=self.clock, buses=self.buses, devices=self.devices,
            mechanism=self.mechanism, waits=waits,
        )  # fmt: skip
        run.plan.motion.attach(self.devices)
        self._rig.__enter__()
        self._rig.arm(torque=run.plan.motion.has_torque)

    def receive(self, now: float) -> None:
        """Go on to the next cycle, and take the frames that had come by then."""
        self.clock.sleep_until(now)
        for bus in self.buses.values():
            bus.receive(now)

    def check(self, now: float) -> None:
        """Check devices and buses as the loop does."""
        for device in self.devices.values():
            device.check(now)
        for bus in self.buses.values():
            bus.check(now)

    def transmit(self, now: float) -> None:
        """Send this cycle's frames, which are compared with those of the run."""
        for bus in self.buses.values():
            bus.transmit(now)

    def close(self) -> None:
        """Let go of everything; what is sent now is compared with nothing."""
        for interface in self._interfaces.values():
            interface.is_over = True
        self._rig.close()


def _origin_of_frames(run: RecordedRun) -> float:
    """Return the time of the rig's clock at which a run's frames count 0, s.

    Raises
    ------
    ConfigurationError
        Nothing can be replayed from its frames.
    """
    frames, backend = run.folder.manifest.get("frames"), run.folder.manifest.get("backend")
    if backend == Backend.SIM:
        raise ConfigurationError(
            f"{run.folder.path} ran on sim, which has no buses and so no frames; runs on "
            f"{', '.join(b for b in Backend if b is not Backend.SIM)} have, with --frames, and "
            "those on virtual can be replayed"
        )
    if backend != Backend.VIRTUAL:
        raise ConfigurationError(
            f"{run.folder.path} ran on {backend}: only frames of a run on virtual can be replayed: "
            "on the wall's clock nobody has written down when the drivers looked at their buses"
        )
    if not isinstance(frames, dict) or frames.get("origin") is None:
        raise ConfigurationError(
            f"{run.folder.path} has no frames: they are recorded by rig run --frames=log"
        )
    return float(frames["origin"])


def _check_has_all(profile: Profile) -> None:
    for name, entry in profile.devices.items():
        if entry.bus is None or not is_can(profile.buses[entry.bus]):
            raise ConfigurationError(
                f"{name} hangs on no CAN bus: what it read is not in the frames"
            )
