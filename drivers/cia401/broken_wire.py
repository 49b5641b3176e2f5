"""The fault of a pressure monitor's wire, with its signal and the bound that it passed."""

from drivers.cia401.codec import MonitorCodec
from drivers.cia401.settings import Cia401Settings
from rig.hal import DeviceFault


def broken_wire(
    device: str, settings: Cia401Settings, channel: str, codec: MonitorCodec, told: float
) -> DeviceFault:
    """Return what is wrong with a monitor whose signal (V or A) is none that it gives."""
    signal = settings.channels[channel].monitor
    unit = signal.signal_unit
    prefix, factor = ("m", 1e3) if unit == "A" else ("", 1.0)
    low = told < codec.broken_below
    bound = codec.broken_below if low else codec.broken_above
    return DeviceFault(
        device,
        f"the pressure monitor of {channel} has a {'broken' if low else 'shorted'} wire",
        node=settings.node,
        object=str(signal.entry),
        value=f"{factor * told:.2f} {prefix}{unit}",
        bound=f"{'above' if low else 'below'} {factor * bound:.2f} {prefix}{unit}",
    )
