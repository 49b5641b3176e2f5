"""Who answers on a profile's CAN buses, and whether that is what the profile says."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import NamedTuple, Protocol, cast

from rig.assembly.buses import is_can, make_bus
from rig.assembly.on_interfaces import Interfaces
from rig.assembly.one_wire import AskingBus, find_one_wire, forget_waiting
from rig.assembly.registry import REGISTRY
from rig.assembly.rig import Rig
from rig.assembly.rows import load
from rig.config import Profile
from rig.hal import (
    Address,
    Clock,
    CyclicBus,
    DeviceFault,
    DriverSettings,
    FastCanBus,
    MonotonicClock,
)
from rig.hal.frames import Found


class Answer(NamedTuple):
    """One node number of a bus.

    Attributes
    ----------
    bus : str
        By the profile's name.
    node : int
        The number.
    name : str
        The device, and its joint, of the profile; empty for one that it does not know.
    found : Found or None
        What answered.
    differences : tuple of str
        In words; empty if all is as it should be.
    """

    bus: str
    node: int
    name: str
    found: Found | None
    differences: tuple[str, ...]


class _CanMaster(Protocol):
    """A bus on a CAN interface; every protocol with a discovery has such ones."""

    def open_interface(self) -> FastCanBus: ...


def survey_buses(
    profile: Profile, interfaces: Interfaces, names: Sequence[str] | None = None
) -> list[Answer]:
    """Ask the buses of a profile who is there; nothing is changed on them.

    Parameters
    ----------
    profile : Profile
        Checked.
    interfaces : mapping
        Settings that replace a bus's own, by its name; those that are missing are the profile's.
    names : sequence of str, optional
        The buses that are asked; default: those on CAN.

    Raises
    ------
    ConnectionFailed
        An interface is missing or down.
    DeviceFault
        It refuses frames.
    """
    from drivers.can import open_bus

    clock = MonotonicClock()

    def lend(name: str) -> AbstractContextManager[object]:
        entry, on = profile.buses[name], interfaces.get(name, {})
        if is_can(entry):
            return _interface(lambda: open_bus(dataclasses.replace(entry.settings, **on)))
        return _line(make_bus(name, entry, clock, profile.loop.period, on))

    def is_asked(name: str) -> bool:
        return is_can(profile.buses[name]) if names is None else name in names

    return _survey(profile, [name for name in profile.buses if is_asked(name)], lend, clock)


def survey_rig(rig: Rig) -> list[Answer]:
    """Ask all buses of a rig that is not open who is there; see `survey_buses`."""

    def lend(name: str) -> AbstractContextManager[object]:
        bus = rig.buses[name]
        if is_can(rig.profile.buses[name]):
            return _interface(cast("_CanMaster", bus).open_interface)
        return _line(bus)

    return _survey(rig.profile, list(rig.buses), lend, rig.clock)


@contextmanager
def _interface(opened: Callable[[], FastCanBus]) -> Iterator[FastCanBus]:
    """Lend an interface, and close it."""
    from drivers.can import close_bus

    bus = opened()
    try:
        yield bus
    finally:
        close_bus(bus)


@contextmanager
def _line(bus: CyclicBus) -> Iterator[CyclicBus]:
    """Open a serial line, which its own bus asks, and close it."""
    bus.open()
    try:
        yield bus
    finally:
        bus.close()


def _survey(
    profile: Profile,
    names: Sequence[str],
    lend: Callable[[str], AbstractContextManager[object]],
    clock: Clock,
) -> list[Answer]:
    answers: list[Answer] = []
    paths = {name: REGISTRY.protocol(profile.buses[name].protocol).discovery for name in names}
    with ExitStack() as lent:
        lines: dict[str, FastCanBus] = {
            name: cast("FastCanBus", lent.enter_context(lend(name)))
            for name, path in paths.items()
            if path is not None and is_can(profile.buses[name])
        }
        for name, path in paths.items():
            if path is None:
                continue
            expected = expected_on(profile, name)
            numbers = [item.number for item in expected]
            try:
                if name in lines:
                    found = _ask_alone(path, name, lines, clock, numbers)
                else:
                    with lend(name) as line:
                        found = load(path)(line, clock, numbers)
            except DeviceFault:
                raise
            except Exception as error:  # each interface has errors of its own
                raise _refusal(name, error) from error
            answers += compare(name, expected, {item.node: item for item in found})
    return answers


def _ask_alone(
    path: str, name: str, lines: Mapping[str, FastCanBus], clock: Clock, numbers: Sequence[int]
) -> list[Found]:
    """Ask a CAN bus who is there; raise if another one hears the questions."""
    others = {other: bus for other, bus in lines.items() if other != name}
    forget_waiting(others)
    asked = AskingBus(lines[name])
    found: list[Found] = load(path)(asked, clock, numbers)
    find_one_wire(name, asked, others)
    return found


def _refusal(bus: str, error: Exception) -> DeviceFault:
    """Return what an interface's refusal means, in the words that a run would use."""
    from drivers.can.errors import BusErrors

    errors = BusErrors(bus, 0)
    errors.refuse(error)
    fault = errors.fault
    return DeviceFault(bus, str(error) if fault is None else fault.what)


def expected_on(profile: Profile, bus: str) -> list[Address]:
    """Return the nodes that a profile says are on a bus."""
    nodes: list[Address] = []
    for name, entry in profile.devices.items():
        if entry.bus == bus:
            settings: DriverSettings = entry.settings
            nodes += settings.addresses(name, entry.serial)
    return nodes


def compare(bus: str, expected: list[Address], found: dict[int, Found]) -> list[Answer]:
    """Return what is expected and what else answers, by node number."""
    wanted = {item.number: item for item in expected}
    return [
        Answer(
            bus,
            node,
            wanted[node].name if node in wanted else "",
            found.get(node),
            _differences(wanted.get(node), found.get(node)),
        )
        for node in sorted({*wanted, *found})
    ]


def _differences(expected: Address | None, found: Found | None) -> tuple[str, ...]:
    if found is None:
        return ("does not answer",)
    differences = []
    if expected is None:
        differences.append("not in the profile")
    if found.answers > 1 or len(found.serials) > 1:
        differences.append(f"{max(found.answers, len(found.serials))} devices have this number")
    if found.answers == 0:
        differences.append("sends, but answers no question")
    return (*differences, *([] if expected is None else contradictions(expected, found)))


def contradictions(expected: Address, found: Found) -> list[str]:
    """Return in words what a node says of itself that a profile says otherwise."""
    return [
        f"{what} {wanted} expected"
        for what, wanted, seen in (
            ("device profile CiA", expected.profile, found.profile),
            ("vendor", expected.vendor, found.vendor),
            ("product", expected.product, found.product),
            ("serial", expected.serial, found.serials[0] if found.serials else None),
        )
        if wanted is not None and found.answers and seen != wanted
    ]
