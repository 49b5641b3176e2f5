"""The wires of a module's pressure monitors, which give a signal of their own when they break."""

from collections.abc import Sequence
from typing import Any, Final

from drivers.cia401.codec import MonitorCodec, decode_signal
from drivers.cia401.module_settings import ModuleSettings
from rig.hal import DeviceFault

_BROKEN_AFTER: Final = 2  # samples in a row; one may be a disturbance on the wire


class MonitorWires:
    """Wires of pressure monitors, and how often in a row each has looked broken.

    Parameters
    ----------
    device : str
        Its name in the profile.
    settings : ModuleSettings
        Its own.
    codecs : sequence of MonitorCodec
        One for each channel, in their order.
    """

    def __init__(
        self, device: str, settings: ModuleSettings, codecs: Sequence[MonitorCodec]
    ) -> None:
        self._device = device
        self._settings = settings
        self._codecs = tuple(codecs)
        self._intact = tuple(codec.intact_counts for codec in codecs)
        self._signals = [0.0] * len(codecs)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self._broken = [0] * len(self._codecs)

    def count(self, counts: Sequence[Any]) -> None:
        """Take a sample in which a signal is none that its monitor gives, or the one after it."""
        for k, (low, high) in enumerate(self._intact):
            if low <= counts[k] <= high:
                self._broken[k] = 0
            else:
                self._broken[k] += 1
                self._signals[k] = decode_signal(self._codecs[k], counts[k])

    def check(self) -> None:
        """Raise `DeviceFault` if a wire is broken, with its signal and the bound it passed."""
        for name, codec, broken, told in zip(
            self._settings.wired, self._codecs, self._broken, self._signals, strict=True
        ):
            if broken >= _BROKEN_AFTER:
                raise self._fault(name, codec, told)

    def explain(self, unsafe: str) -> str:
        """Return why nothing is known to be safe, with the wire that keeps it from being known."""
        if unsafe:
            try:
                self.check()
            except DeviceFault as fault:
                return f"{unsafe}: {fault}"
        return unsafe

    def _fault(self, channel: str, codec: MonitorCodec, told: float) -> DeviceFault:
        """Return what is wrong with a monitor whose signal (V or A) is none that it gives."""
        signal = self._settings.wired[channel].monitor
        unit = signal.signal_unit
        prefix, factor = ("m", 1e3) if unit == "A" else ("", 1.0)
        low = told < codec.broken_below
        bound = codec.broken_below if low else codec.broken_above
        return DeviceFault(
            self._device,
            f"the pressure monitor of {channel} has a {'broken' if low else 'shorted'} wire",
            node=self._settings.node,
            object=str(signal.entry),
            value=f"{factor * told:.2f} {prefix}{unit}",
            bound=f"{'above' if low else 'below'} {factor * bound:.2f} {prefix}{unit}",
        )
