"""`rig monitor`: recorded or live frames, in the names of a profile and in SI."""

from __future__ import annotations

import contextlib
import json
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rig.cli.names import (
    complete_device,
    complete_rig,
    complete_run,
    configs_option,
    runs_option,
    set_option,
)
from rig.cli.number_option import NumberWithin
from rig.cli.tables import abandon_stdout
from rig.run_names import find_run

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.hal import DriverSettings
    from rig.hal.frames import Decoder

_LIVE = ""  # what `--frames` without a source means


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@click.option(
    "--frames", "source", is_flag=False, flag_value=_LIVE, metavar="[FILE|RUN]",
    shell_complete=complete_run,
    help="A candump, ASC or BLF file, - for a pipe, or a run recorded with --frames; without "
    "one, the frames that pass on the interface of --on.",
)  # fmt: skip
@click.option(
    "--on", metavar="INTERFACE",
    help="Listen there: hardware (what the profile names), vcan0, slcan:/dev/ttyACM0, as in "
    "`rig simulate`. Nothing is sent.",
)  # fmt: skip
@click.option(
    "--device", "devices", multiple=True, shell_complete=complete_device,
    help="Only frames of this device; may be given again.",
)  # fmt: skip
@click.option(
    "--for", "duration", type=NumberWithin(min=0.0, min_open=True), metavar="SECONDS",
    help="End after this time, of the frames.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object per line.")
@set_option
@runs_option
@configs_option
def monitor(
    rig: str,
    source: str | None,
    on: str | None,
    devices: tuple[str, ...],
    duration: float | None,
    as_json: bool,
    overrides: tuple[str, ...],
    runs: Path,
    configs: Path | None,
) -> int:
    """Show the frames of RIG's CAN buses: device, service, and what is in them, in SI.

    RIG is a name from `rig list` or the path of a profile; of a run, its profile.yaml is exact.

    \b
    rig monitor cylinder --frames latest | less
    rig monitor joint --frames --on vcan0
    candump -L can0 | rig monitor joint --frames -
    """  # noqa: D301 - click wants the character
    from rig.assembly import REGISTRY, check_profile
    from rig.assembly.decoding import make_decoders
    from rig.config import load_profile
    from rig.config.names import find_configs

    if source is None or (source == _LIVE) == (on is None):
        raise click.UsageError(
            "Say whose frames: --frames FILE or RUN for recorded ones, --frames --on INTERFACE "
            "for live ones."
        )
    profile = load_profile(rig, REGISTRY, overrides, find_configs(configs))
    check_profile(profile)
    _check_devices(devices, profile)
    viewer = _Viewer(make_decoders(profile), _longest_name(profile), devices, duration, as_json)
    try:
        if on is not None:
            with contextlib.suppress(KeyboardInterrupt):
                _show_live(profile, on, viewer)
        else:
            _show_recorded(profile, source, runs, viewer)
    except BrokenPipeError:
        abandon_stdout()
    click.echo(viewer.summary(), err=True)
    return 0


def _show_live(profile: Profile, on: str, viewer: _Viewer) -> None:
    from rig.assembly import parse_interfaces
    from rig.assembly.frame_reading import listen

    interfaces = {} if on == "hardware" else parse_interfaces(on, profile)
    with listen(profile, interfaces) as listener:
        click.echo(f"listening on {on}; Ctrl-C ends it", err=True)
        try:
            while not viewer.is_over:
                frames = listener.look()
                for line in viewer.lines(frames):
                    sys.stdout.write(line)
                if frames:
                    sys.stdout.flush()
                elif viewer.is_past(time.time()):
                    return
        finally:
            viewer.dropped = listener.count_dropped()


def _show_recorded(profile: Profile, source: str, runs: Path, viewer: _Viewer) -> None:
    from rig.assembly.frame_reading import STDIN, read_frames

    path: str | Path = source if source == STDIN else _find_frames(source, runs)
    with contextlib.closing(read_frames(path, profile)) as frames:  # type: ignore[type-var]
        for line in viewer.lines(frames):
            sys.stdout.write(line)
            if source == STDIN:  # perhaps of a program that still runs
                sys.stdout.flush()
            if viewer.is_over:
                break
    sys.stdout.flush()


def _find_frames(source: str, runs: Path) -> Path:
    from rig.assembly.frame_reading import frames_of_run
    from rig.hal import ConfigurationError
    from rig.hal.files import is_file, is_folder

    path = Path(source)
    if is_file(path):
        return path
    if path.suffix and not is_folder(path) and not is_folder(runs / source):
        raise ConfigurationError(f"there is no file {source}")
    try:
        folder = find_run(source, runs)
    except ConfigurationError as error:
        raise ConfigurationError(f"there is no file {source}, and {error}") from error
    return frames_of_run(folder)


def _longest_name(profile: Profile) -> int:
    """Return how long a device's name may be, with the joint behind it if it has joints."""
    names = [*profile.devices]
    for name, entry in profile.devices.items():
        settings: DriverSettings = entry.settings
        names += [address.name for address in settings.addresses(name, None)]
    return max(map(len, names), default=0)


def _check_devices(devices: Iterable[str], profile: Profile) -> None:
    from rig.config.diagnostics import nearest
    from rig.hal import ConfigurationError

    for name in devices:
        if name not in profile.devices:
            hint = nearest(name, profile.devices)
            raise ConfigurationError(f"no device of {profile.name} is called {name!r}; {hint}")


class _Viewer:
    """Turns frames into lines, and counts them.

    Parameters
    ----------
    decoders : dict of str to Decoder
        By bus.
    longest : int
        Letters in the longest name of a device.
    devices : tuple of str
        Show these only; empty for all.
    duration : float or None
        Stop after this time of the frames, s.
    as_json : bool
        Objects, not columns.
    """

    def __init__(
        self,
        decoders: dict[str, Decoder],
        longest: int,
        devices: tuple[str, ...],
        duration: float | None,
        as_json: bool,
    ) -> None:
        self._decoders = decoders
        self._devices = devices
        self._duration = duration
        self._line = _json_line if as_json else _text_line
        self._widths = (max(map(len, decoders), default=0), longest)
        self._began: float | None = None
        self._opened = time.time()
        self.is_over = False
        self.count = self.unknown = self.dropped = 0

    def lines(self, frames: Iterable[Any]) -> Iterator[str]:
        """Yield the line of every frame that is to be shown."""
        from rig.assembly.decoding import decode

        for frame in frames:
            if self._began is None:
                self._began = frame.time
            t = frame.time - self._began
            if self._duration is not None and t > self._duration:
                self.is_over = True
                return
            decoded = decode(self._decoders, frame)
            self.count += 1
            self.unknown += not decoded.known
            if not self._devices or self._is_wanted(decoded.device):
                yield self._line(t, frame, decoded, self._widths)

    def summary(self) -> str:
        """Return how many frames there were."""
        parts = [f"{self.count} frames"]
        if self.unknown:
            parts.append(f"{self.unknown} that the profile does not know")
        if self.dropped:
            parts.append(
                f"and {self.dropped} were lost, because they came faster than they were shown: "
                "write to a file, or record with `rig run --frames` or candump -l"
            )
        return ", ".join(parts)

    def is_past(self, now: float) -> bool:
        """Return whether the time to show is over, although no frame says so."""
        if self._duration is None:
            return False
        return now - (self._opened if self._began is None else self._began) > self._duration

    def _is_wanted(self, device: str) -> bool:
        # A device with several nodes shows as "arm q1", "arm q2".
        return any(device == name or device.startswith(f"{name} ") for name in self._devices)


def _text_line(t: float, frame: Any, decoded: Any, widths: Sequence[int]) -> str:
    from rig.assembly.decoding import hexadecimal
    from rig.hal.formats import format_quantity

    parts = [decoded.text] if decoded.text else []
    for value in decoded.values:
        text = format_quantity(value.value, value.unit) if value.unit else str(value.value)
        parts.append(f"{value.name} = {text}" if value.name else text)
    name, data = hexadecimal(frame)
    content = ", ".join(parts) or data
    return (
        f"{t:12.6f}  {frame.channel:{widths[0]}}  {name:>3}  "
        f"{decoded.device or '-':{widths[1]}}  {decoded.service:9}  {content}".rstrip()
        + "\n"
    )


def _json_line(t: float, frame: Any, decoded: Any, widths: Sequence[int]) -> str:
    from rig.assembly.decoding import hexadecimal

    name, data = hexadecimal(frame)
    content = {
        "t": round(t, 6),
        "time": frame.time,
        "bus": frame.channel,
        "id": name,
        "data": data,
        "device": decoded.device or None,
        "service": decoded.service,
        "known": decoded.known,
        "values": [
            {
                "name": value.name,
                "object": value.object,
                "value": value.value,
                "unit": value.unit or None,
            }
            for value in decoded.values
        ],
        "text": decoded.text or None,
    }
    return json.dumps(content, ensure_ascii=False) + "\n"
