"""What a rig is wired to on this computer: CAN interfaces, serial ports, cameras."""

import stat
from collections.abc import Iterator
from pathlib import Path

from rig.config import Profile
from rig.doctor.look import Fitness, Look
from rig.hal import ConnectionFailed, Endpoint
from rig.hal.device_files import may_open, permitting


def look_at_wiring(profile: Profile) -> Iterator[Look]:
    """Yield what there is to say of the interfaces that a profile names; nothing is sent."""
    for name, bus in profile.buses.items():
        yield _bus(name, bus.settings.endpoint())
    for name, device in profile.devices.items():
        path = device.settings.device_path()
        if path is not None:
            yield look_at_device_file(f"device {name}, {path}", path)


def _bus(name: str, at: Endpoint) -> Look:
    what = f"bus {name}, {at.interface} {at.channel}"
    if at.interface == "socketcan":
        from drivers.can.socketcan import open_socketcan

        try:
            open_socketcan(at.channel, at.bitrate).shutdown()
        except ConnectionFailed as error:
            found, _, mend = error.what.partition("; ")
            return Look(what, found, Fitness.NO, mend)
        return Look(what, f"up, {at.bitrate} bit/s", Fitness.OK)
    if at.channel.startswith("/dev/"):
        return look_at_device_file(what, at.channel)
    return Look(what, "only its driver can tell: rig check RIG --on hardware", Fitness.OK)


def look_at_device_file(what: str, name: str) -> Look:
    """Return whether a device's file is there and may be opened."""
    path = Path(name)
    if not path.exists():
        near = sorted(path.parent.glob(path.name.rstrip("0123456789") + "*"))
        others = ", ".join(map(str, near[:4]))
        mend = f"plug it in, or write into the profile: {others}" if near else "plug it in"
        return Look(what, "is not there", Fitness.NO, mend)
    if not stat.S_ISCHR(path.stat().st_mode):
        return Look(what, "is no device", Fitness.NO, "correct the profile")
    if may_open(path):
        return Look(what, "can be opened", Fitness.OK)
    return Look(what, "may not be opened", Fitness.NO, permitting(path))
