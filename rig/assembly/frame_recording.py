"""Frames of a rig's CAN buses on file: recorded in a run, turned into other tools' formats."""

from pathlib import Path
from typing import Any, Final

from rig.assembly.buses import is_can
from rig.assembly.rig import Backend
from rig.config import Profile
from rig.hal import ConfigurationError

FORMATS: Final = ("log", "asc", "blf")
"""candump's, which is what is written during a run, and Vector's ASCII and binary."""

FRAMES: Final = "frames"
"""Name of the file in a run folder, without its ending."""


def make_frame_log(profile: Profile, backend: Backend) -> Any:
    """Make the recorder of a profile's CAN buses, a `drivers.can.frame_log.FrameLog`.

    Raises
    ------
    ConfigurationError
        There would be nothing to record.
    """
    from drivers.can.frame_log import FrameLog

    if backend is Backend.SIM:
        raise ConfigurationError(
            "--frames: on sim the devices stand on the plant and there is no bus; "
            "--on virtual has the same devices on an emulated one"
        )
    if not any(is_can(entry) for entry in profile.buses.values()):
        raise ConfigurationError(f"--frames: the profile {profile.name} has no CAN bus")
    return FrameLog()


def convert_frames(path: Path, kind: str, profile: Profile) -> Path:
    """Turn a finished candump log into another format, beside it and in its place.

    Parameters
    ----------
    path : Path
        The log.
    kind : str
        One of `FORMATS`.
    profile : Profile
        Its CAN buses are channels 1, 2, … in this order, since these formats have no names.

    Returns
    -------
    Path
        The new file.
    """
    if kind == FORMATS[0]:
        return path
    import can

    from drivers.can.candump import parse_lines
    from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, EXTENDED_MASK, REMOTE_FLAG
    from drivers.can.frame_log import WAYS

    buses = (bus for bus, entry in profile.buses.items() if is_can(entry))
    channels = {bus: number for number, bus in enumerate(buses)}
    target = path.with_suffix(f".{kind}")
    writer: Any = can.Logger(str(target))
    with path.open(encoding="ascii", errors="replace") as lines, writer:
        for frame in parse_lines(lines, str(path)):
            error = bool(frame.can_id & ERROR_FLAG)
            writer(
                can.Message(
                    timestamp=frame.time,
                    arbitration_id=frame.can_id & EXTENDED_MASK & ~(ERROR_FLAG if error else 0),
                    is_extended_id=error or bool(frame.can_id & EXTENDED_FLAG),
                    is_error_frame=error,
                    is_remote_frame=bool(frame.can_id & REMOTE_FLAG),
                    data=frame.data,
                    channel=channels.get(frame.channel, 0),
                )
            )
    path.unlink()
    path.with_suffix(WAYS).unlink(missing_ok=True)
    return target
