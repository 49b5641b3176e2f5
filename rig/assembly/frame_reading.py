"""Where frames come from: files of the field's tools, and interfaces that are listened to."""

import contextlib
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from rig.assembly.buses import is_can
from rig.assembly.frame_recording import FORMATS, FRAMES
from rig.assembly.on_interfaces import Interfaces
from rig.config import Profile
from rig.hal import ConfigurationError, ConnectionFailed, FastCanBus
from rig.hal.frames import LoggedFrame

STDIN: Final = "-"
"""Stands for frames on standard input, in candump's format."""

_STDIN: Final = "standard input"
_LOOK_EVERY: Final = 2e-3  # at interfaces without frames, s


def frames_of_run(folder: Path) -> Path:
    """Return the file of frames in a run folder.

    Raises
    ------
    ConfigurationError
        The run was not recorded with ``--frames``.
    """
    for kind in FORMATS:
        path = folder / f"{FRAMES}.{kind}"
        if path.is_file():
            return path
    raise ConfigurationError(
        f"{folder} has no frames; `rig run` records them with --frames (as {FRAMES}.{FORMATS[0]})"
    )


def read_frames(path: str | Path, profile: Profile) -> Iterator[LoggedFrame]:
    """Yield the frames of a file.

    Parameters
    ----------
    path : str or Path
        A log of candump (``-L`` or ``-l``), or an ASC or BLF file. `STDIN` for a pipe.
    profile : Profile
        Whose buses become the channels: one is meant by its name, by its interface's channel,
        or, where the file counts channels, by its place; a single CAN bus is every channel.

    Raises
    ------
    ConfigurationError
        The file is missing, or none of these.
    """
    buses = _Buses(profile)
    try:
        if str(path) != STDIN and Path(path).suffix.lower() in (".asc", ".blf"):
            frames = _read_vector(Path(path))
        else:
            frames = _read_candump(path)
        for frame in frames:
            yield frame._replace(channel=buses.name_of(frame.channel))
    except OSError as error:
        raise ConfigurationError(f"cannot read {path}: {error.strerror or error}") from error
    except ValueError as error:
        raise ConfigurationError(str(error)) from error


class Listener:
    """Open CAN buses on which nothing is ever sent."""

    def __init__(self, buses: Mapping[str, FastCanBus]) -> None:

        self._buses = buses

    def look(self) -> list[LoggedFrame]:
        """Return the frames that have come; none after a moment in which there were none.

        Raises
        ------
        ConnectionFailed
            An interface went down.
        """
        frames = []
        for name, bus in self._buses.items():
            try:
                found = bus.drain(256)
            except Exception as error:  # each interface has errors of its own
                raise ConnectionFailed(name, f"the interface failed: {error}") from error
            now = time.time()
            frames += [LoggedFrame(now, name, can_id, data) for can_id, data in found]
        if not frames:
            time.sleep(_LOOK_EVERY)
        return frames

    def count_dropped(self) -> int:
        """Return how many frames came faster than they were looked at, and are lost."""
        return sum(bus.count_dropped() for bus in self._buses.values())


@contextlib.contextmanager
def listen(profile: Profile, interfaces: Interfaces) -> Iterator[Listener]:
    """Open the CAN buses of a profile to listen on them.

    Raises
    ------
    ConnectionFailed
        An interface is missing or down.
    """
    import dataclasses

    from drivers.can import close_bus, open_bus

    with contextlib.ExitStack() as stack:
        buses = {}
        for name, entry in profile.buses.items():
            if not is_can(entry):
                continue
            bus = open_bus(dataclasses.replace(entry.settings, **interfaces.get(name, {})))
            stack.callback(close_bus, bus)
            buses[name] = bus
        yield Listener(buses)


class _Buses:
    """Finds the profile's bus that a file means by a channel."""

    def __init__(self, profile: Profile) -> None:
        can = {name: entry for name, entry in profile.buses.items() if is_can(entry)}
        if not can:
            raise ConfigurationError(f"the profile {profile.name} has no CAN bus")
        self._names: Mapping[str, str] = {
            **{str(number): name for number, name in enumerate(can)},
            **{entry.settings.channel: name for name, entry in can.items()},
            **{name: name for name in can},
        }
        self._only = next(iter(can)) if len(can) == 1 else None

    def name_of(self, channel: str) -> str:
        """Return the bus's name, or the channel where there is none."""
        return self._only or self._names.get(channel, channel)


def _read_candump(path: str | Path) -> Iterator[LoggedFrame]:
    from drivers.can.candump import bounded, parse_lines

    if str(path) == STDIN:
        yield from parse_lines(bounded(sys.stdin, _STDIN), _STDIN)
        return
    with Path(path).open(encoding="utf-8", errors="replace") as lines:
        yield from parse_lines(bounded(lines, str(path)), str(path))


def _read_vector(path: Path) -> Iterator[LoggedFrame]:
    kind = path.suffix[1:].upper()
    with contextlib.ExitStack() as stack:
        try:
            frames = _frames_of_blf if kind == "BLF" else _frames_of_asc
            yield from frames(path, stack)
        except (OSError, GeneratorExit):
            raise
        except Exception as error:  # the readers raise whatever comes of a broken file
            raise ValueError(f"{path}: this is no {kind} file: {error}") from error


def _frames_of_blf(path: Path, stack: contextlib.ExitStack) -> Iterator[LoggedFrame]:
    import can

    from drivers.can.blf_file import check_blf

    content = stack.enter_context(path.open("rb"))
    check_blf(content)
    content.seek(0)
    yield from map(_logged, can.BLFReader(content))


def _frames_of_asc(path: Path, stack: contextlib.ExitStack) -> Iterator[LoggedFrame]:
    import can

    from drivers.can.candump import bounded

    content = stack.enter_context(path.open("r"))
    for _ in bounded(content, path.name):
        pass
    content.seek(0)
    yield from map(_logged, can.ASCReader(content))


def _logged(frame: Any) -> LoggedFrame:
    from drivers.can.fast_path import flagged_id

    channel = str(frame.channel or 0)
    return LoggedFrame(frame.timestamp, channel, flagged_id(frame), bytes(frame.data))
