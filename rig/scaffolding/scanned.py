"""A rig to begin with from who answers on its buses: node numbers and identities, by another one.

A bus does not tell what a device is for. The devices of another profile are found again by their
kind, the CiA device profile: first the ones that have its numbers, then the others in the order of
theirs. What was exchanged is found by the acceptance test, before anything moves.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

from rig.assembly import check_profile, parse_interfaces
from rig.assembly.buses import is_can
from rig.assembly.on_interfaces import Interfaces
from rig.assembly.registry import REGISTRY
from rig.assembly.survey import expected_on, survey_buses
from rig.config import Profile, load_profile
from rig.config.plain_dump import plain_text
from rig.hal import Address, ConfigurationError, DeviceError
from rig.hal.drawn_profile import DrawnProfile
from rig.hal.frames import Found
from rig.scaffolding.eds_sheets import EdsSheet, sheet_of
from rig.scaffolding.files import commented_lines
from rig.scaffolding.seen_cameras import SeenCamera, seen_cameras

_NUMBERS: Final = ("node", "axis", "id")
"""Keys by which drivers call the number of what is on a bus."""
_DRIVERS: Final = {401: "cia401", 402: "cia402", 406: "cia406", 410: "cia410"}
"""Drivers of CiA device profiles."""
_IDENTITY: Final = ("vendor", "product")


class Matched(NamedTuple):
    """The devices of one bus, recognised among the answers.

    Parameters
    ----------
    devices : dict
        What was found, by the names of the profile's addresses.
    missing : tuple of Address
        Of the profile, and nothing like them answers.
    others : tuple of Found
        Answer, and nothing of the profile is like them.
    """

    devices: dict[str, Found]
    missing: tuple[Address, ...]
    others: tuple[Found, ...]


def match(expected: Sequence[Address], found: Sequence[Found]) -> Matched:
    """Return which of the expected devices is which of those that were found on a bus."""
    left = {item.node: item for item in sorted(found, key=lambda item: item.node)}
    devices: dict[str, Found] = {}
    for its in expected:
        if its.number in left and _is_like(its, left[its.number]):
            devices[its.name] = left.pop(its.number)
    for its in expected:
        like = (item for item in left.values() if _is_like(its, item))
        if its.name not in devices and (item := next(like, None)) is not None:
            devices[its.name] = left.pop(item.node)
    missing = tuple(its for its in expected if its.name not in devices)
    return Matched(devices, missing, tuple(left.values()))


def _is_like(its: Address, found: Found) -> bool:
    return found.answers > 0 and (its.profile is None or its.profile == found.profile)


def scanned_profile(
    name: str, like: str, on: str, search: Sequence[Path], eds: Sequence[Path] = ()
) -> DrawnProfile:
    """Return a profile of the devices that answer on CAN interfaces; nothing is changed on them.

    Parameters
    ----------
    name, like : str
        Its name, and that of the rig whose devices it has.
    on : str
        Interfaces, see `rig.assembly.on_interfaces.parse_interfaces`, and ports of serial lines,
        as ``/dev/ttyUSB0``; ``hardware``: those that the other rig names.
    search : sequence of Path
        Folders of configurations.
    eds : sequence of Path
        EDS files, each of whoever answers with its identity: what is mapped is theirs.

    Raises
    ------
    ConfigurationError
        There is no such rig, it has no such interfaces, or an EDS cannot be read.
    ConnectionFailed
        An interface is missing or down.
    DeviceError
        Nobody answers, or devices share a number.
    """
    profile = load_profile(like, REGISTRY, search=search)
    check_profile(profile)
    interfaces = _interfaces_of(on, profile)
    answers = survey_buses(profile, interfaces, list(interfaces))
    found = {bus: [a.found for a in answers if a.bus == bus and a.found] for bus in profile.buses}
    if not any(found.values()):
        raise DeviceError(on, "nobody answers there: look at power, cable, termination, bit rate")
    for bus, items in found.items():
        for item in items:
            if item.answers > 1 or len(item.serials) > 1:
                count = max(item.answers, len(item.serials))
                raise DeviceError(bus, f"{count} devices have the number 0x{item.node:02X}")
    sheets = [EdsSheet(path) for path in eds]
    who = {bus: match(expected_on(profile, bus), items) for bus, items in found.items()}
    notes = tuple(note for bus, matched in who.items() for note in _notes(bus, matched))
    everybody = [item for items in found.values() for item in items]
    notes += tuple(
        f"{sheet.path} is of nobody who answers"
        for sheet in sheets
        if sheet_of([sheet], everybody) is None
    )
    lines = [
        f"# Begun from who answered on {on}, with the devices of {like}. What is true of it is",
        "# tested by `rig commission`: the order of devices of one kind is that of their numbers.",
        *(f"# {note}" for note in notes),
        f"extends: {plain_text(like)}",
        f"name: {plain_text(name)}",
        "description: What it is, in one sentence",
        "",
        *_bus_lines(interfaces),
        "devices:",
        *_device_lines(profile, who, sheets),
        *_camera_lines(profile, seen_cameras()),
        *(
            line
            for bus, matched in who.items()
            for line in _stranger_lines(bus, matched.others, sheets)
        ),
    ]
    return DrawnProfile("\n".join(lines) + "\n\n" + commented_lines(name, like, search), notes)


def _interfaces_of(on: str, profile: Profile) -> Interfaces:
    """Return the settings of the buses that are to be asked."""
    if on == "hardware":
        return {name: {} for name in profile.buses}
    words = [word.strip() for word in on.split(",")]
    ports = [word for word in words if word.startswith("/")]
    lines = [name for name, entry in profile.buses.items() if not is_can(entry)]
    if len(ports) > len(lines):
        raise ConfigurationError(
            f"--scan {on}: {len(ports)} serial ports, and {profile.name} has {len(lines)} lines"
        )
    others = [word for word in words if word not in ports]
    on_can = parse_interfaces(",".join(others), profile) if others else {}
    return {**{line: {"port": port} for line, port in zip(lines, ports, strict=False)}, **on_can}


def _notes(bus: str, matched: Matched) -> list[str]:
    return [
        f"{bus}: {its.name} does not answer; its number stays 0x{its.number:02X}"
        for its in matched.missing
    ] + [
        f"{bus}: node 0x{item.node:02X} ({item.kind or 'it does not say what it is'}) is like "
        "nothing of the profile"
        for item in matched.others
    ]


def _bus_lines(interfaces: Interfaces) -> list[str]:
    told = {bus: settings for bus, settings in interfaces.items() if settings}
    lines = ["buses:"] if told else []
    for bus, settings in told.items():
        said = ", ".join(f"{key}: {value}" for key, value in settings.items())
        lines.append(f"  {bus}: {{{said}}}")
    return [*lines, ""] if lines else []


def _device_lines(
    profile: Profile, who: dict[str, Matched], sheets: Sequence[EdsSheet]
) -> list[str]:
    lines: list[str] = []
    for name, entry in profile.devices.items():
        matched = who[entry.bus].devices if entry.bus in who else {}
        joints = getattr(entry.settings, "joints", {})
        own: list[tuple[str | None, object]] = []
        own += [(None, entry.settings)] if name in matched else []
        own += [(joint, its) for joint, its in joints.items() if f"{name}.{joint}" in matched]
        if not own:
            continue
        lines.append(f"  {name}:")
        for joint, settings in own:
            item = matched[name if joint is None else f"{name}.{joint}"]
            pad = "    " if joint is None else "        "
            if joint is not None:
                if joint == own[0][0]:
                    lines.append("    joints:")
                lines.append(f"      {joint}:")
            lines += [f"{pad}{line}" for line in _said(settings, item, alone=joint is None)]
        items = [matched[name if joint is None else f"{name}.{joint}"] for joint, _ in own]
        sheet = sheet_of(sheets, items)
        lines += [f"    {line}" for line in sheet.lines(entry.settings)] if sheet else []
    return lines


def _said(settings: object, item: Found, *, alone: bool) -> list[str]:
    """Return the lines that a device says of itself; a vendor or serial number of 0 is none."""
    key = next(key for key in _NUMBERS if hasattr(settings, key))
    lines = [
        f"{key}: 0x{item.node:02X}" + (f"                  # {item.kind}" if item.kind else "")
    ]
    for what in _IDENTITY if item.vendor else ():
        value = getattr(item, what)
        if value is not None and hasattr(settings, what):
            lines.append(f"{what}: 0x{value:X}")
    if item.serials and item.serials[0] and (alone or hasattr(settings, "serial")):
        lines.append(f"serial: 0x{item.serials[0]:X}")
    return lines


def _stranger_lines(bus: str, strangers: Sequence[Found], sheets: Sequence[EdsSheet]) -> list[str]:
    """Return comments that make a device of whoever is like nothing of the profile."""
    lines: list[str] = []
    for item in strangers:
        driver = _DRIVERS.get(item.profile or 0, "")
        lines += [
            f"  # Node 0x{item.node:02X} of {bus} says: {item.kind or 'nothing of itself'}. If it "
            "belongs to the rig:",
            f"  # device-{item.node:02x}:",
            f"  #   driver: {driver}" if driver else
            "  #   driver: your-driver         # `rig new driver your-driver` begins one",
            f"  #   bus: {bus}",
            f"  #   node: 0x{item.node:02X}",
        ]  # fmt: skip
        known = [(key, getattr(item, key)) for key in _IDENTITY]
        lines += [f"  #   {key}: 0x{value:X}" for key, value in known if value]
        lines += [f"  #   serial: 0x{serial:X}" for serial in item.serials[:1] if serial]
        sheet = sheet_of(sheets, [item])
        if sheet is not None:
            lines.append(f"  #   eds: {sheet.path}")
        elif item.profile is not None:
            lines.append("  #   eds: maker.eds               # its maker's file, which says more")
    return lines


def _camera_lines(profile: Profile, cameras: Sequence[SeenCamera]) -> list[str]:
    """Return the sources of the profile's cameras, and comments for the others that are there."""
    wanted = [name for name, entry in profile.devices.items() if _is_camera(entry.settings)]
    lines: list[str] = []
    for name, its in zip(wanted, cameras, strict=False):
        lines += [f"  {name}:", f"    source: {{kind: uvc, path: {its.path}}}   # {its.name}"]
    for its in cameras[len(wanted) :]:
        lines.append(f"  # Another camera, {its.name}: {{kind: uvc, path: {its.path}}}")
    lines += [f"  # {name}: this computer shows no camera" for name in wanted[len(cameras) :]]
    return lines


def _is_camera(settings: object) -> bool:
    return getattr(getattr(settings, "source", None), "kind", "") == "uvc"
