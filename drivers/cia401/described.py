"""What a CiA 401 module exchanges, as data: for decoding, and for its EDS."""

from collections.abc import Iterable, Mapping
from itertools import product

from drivers.canopen.described import Quantity
from drivers.canopen.mapping import Entry, MappedObjects
from drivers.cia401.channel_settings import (
    DIGITAL_INPUT,
    DIGITAL_OUTPUT,
    AnalogueSignal,
    Channel,
    RegulatorChannel,
)
from rig.hal.driver import Keys, Scalar


def describe_channels(
    channels: Mapping[str, Channel],
    supply_bit: int | None,
    stop: tuple[int, bool] | None,
) -> tuple[dict[Entry, Quantity], dict[Entry, Keys]]:
    """Return what the module's counts mean, and which settings ask for them.

    Parameters
    ----------
    channels : mapping of str to Channel
        By name.
    supply_bit : int or None
        Of the digital outputs.
    stop : (int, bool) or None
        Bit of the digital inputs, and whether it is 0 when the stop is pressed.
    """
    quantities: dict[Entry, Quantity] = {}
    origins: dict[Entry, Keys] = {}
    valves: list[tuple[str, int]] = []
    if supply_bit is not None:
        valves.append(("supply", supply_bit))
        origins[DIGITAL_OUTPUT] = ("supply_bit",)
    for channel, wired in channels.items():
        setpoint, monitor = wired.setpoint, wired.monitor
        quantities[setpoint.entry] = _quantity(f"{channel} setpoint", setpoint)
        quantities[monitor.entry] = _quantity(f"{channel} pressure", monitor)
        origins[setpoint.entry] = ("channels", channel, "setpoint")
        origins[monitor.entry] = ("channels", channel, "monitor")
        if isinstance(wired, RegulatorChannel) and wired.lock_bit is not None:
            valves.append((f"{channel} lock", wired.lock_bit))
            origins.setdefault(DIGITAL_OUTPUT, ("channels", channel, "lock_bit"))
    if valves:
        quantities[DIGITAL_OUTPUT] = _valves(valves)
    if stop is not None:
        quantities[DIGITAL_INPUT] = _stop(*stop)
        origins[DIGITAL_INPUT] = ("stop_bit",)
    return quantities, origins


def typed_objects(plain: Mapping[str, object]) -> dict[tuple[str, ...], tuple[int, int]]:
    """Return the objects whose types are settings, from the settings as they were written.

    Parameters
    ----------
    plain : mapping
        A device's entry in a profile; it may have errors.

    Returns
    -------
    dict
        Index and sub-index, by the keys of the setting that holds the object's type.
    """
    found: dict[tuple[str, ...], tuple[int, int]] = {}
    channels = plain.get("channels")
    for name, channel in channels.items() if isinstance(channels, Mapping) else ():
        for side, usual in (("setpoint", 0x6411), ("monitor", 0x6401)):
            signal = channel.get(side) if isinstance(channel, Mapping) else None
            if not isinstance(signal, Mapping):
                continue
            index, sub = signal.get("index", usual), signal.get("sub")
            if isinstance(index, int) and isinstance(sub, int):
                found["channels", name, side, "type"] = index, sub
                mode = plain.get("error_mode", 0x6443)
                if side == "setpoint" and isinstance(mode, int):
                    found["error_mode_type",] = mode, sub
    return found


def _quantity(name: str, signal: AnalogueSignal) -> Quantity:
    (raw_low, raw_high), (low, high) = signal.raw, signal.ends
    gain = (high - low) / (raw_high - raw_low)
    unit = "Pa" if signal.stands_for == "pressure" else ""
    return Quantity(name, unit, gain, low - gain * raw_low)


def _stop(bit: int, active_low: bool) -> Quantity:
    words = ("pressed", "released") if active_low else ("released", "pressed")
    return Quantity("stop", words=lambda byte: words[byte >> bit & 1])


def _valves(bits: Iterable[tuple[str, int]]) -> Quantity:
    """Return the digital output: one valve by its name, several as a list."""
    valves = tuple(bits)
    words = ("shut", "open")
    if len(valves) == 1:
        ((name, only),) = valves
        return Quantity(name, words=lambda byte: words[byte >> only & 1])
    return Quantity(
        "valves",
        words=lambda byte: ", ".join(f"{name} {words[byte >> bit & 1]}" for name, bit in valves),
    )


def mapped_settings(plain: Mapping[str, object], objects: MappedObjects) -> dict[Keys, Scalar]:
    """Return the objects of the channels from what a module takes and sends.

    A channel keeps the object that it has in a module like it, if there is such a one; of a mapping
    that is fixed the channels take the objects in their order.

    Parameters
    ----------
    plain : mapping
        The entry of a device like it in a profile.
    objects : MappedObjects
        What it can exchange.
    """
    found: dict[Keys, Scalar] = {}
    channels = plain.get("channels")
    names = list(channels) if isinstance(channels, Mapping) else []
    sides = {
        side: [entry for entry in entries if entry.object == usual]
        for side, usual, entries in (
            ("setpoint", 0x6411, objects.receive),
            ("monitor", 0x6401, objects.transmit),
        )
    }
    if any(len(left) < len(names) for left in sides.values()):
        return {}
    sent = {(entry.object, entry.sub) for entry in objects.transmit}
    for name, (side, left) in product(names, sides.items()):
        own = _sub_of(channels, name, side)
        entry = next((e for e in left if e.sub == own and not objects.is_fixed), left[0])
        left.remove(entry)
        found["channels", name, side, "sub"] = entry.sub
        found["channels", name, side, "type"] = entry.type
    outputs = [(0x6411, value) for keys, value in found.items() if keys[2:] == ("setpoint", "sub")]
    if objects.is_fixed or plain.get("echo"):
        found["echo",] = all(output in sent for output in outputs)
    return found


def _sub_of(channels: object, name: str, side: str) -> object:
    channel = channels.get(name) if isinstance(channels, Mapping) else None
    signal = channel.get(side) if isinstance(channel, Mapping) else None
    return signal.get("sub") if isinstance(signal, Mapping) else None
