"""One analogue channel as wired: converter counts ↔ volts or milliamperes ↔ pressure."""

from typing import NamedTuple


class AnalogueScale(NamedTuple):
    """Two points of a straight line, at the converter, on the wire and at the regulator.

    Attributes
    ----------
    raw : tuple of int
        Converter counts at the two points.
    electrical : tuple of float
        The signal there, V or A.
    pressure : tuple of float
        The pressure there, Pa gauge.
    """

    raw: tuple[float, float]
    electrical: tuple[float, float]
    pressure: tuple[float, float]

    def electrical_from_raw(self, raw: float) -> float:
        """Return the signal that a converter gives for its counts."""
        return _line(raw, self.raw, self.electrical)

    def pressure_from_electrical(self, signal: float) -> float:
        """Return the pressure a regulator takes a signal for; it ends at its range's ends."""
        low, high = self.electrical
        if low > high:
            low, high = high, low
        if not low <= signal <= high:
            signal = low if signal < low else high
        return _line(signal, self.electrical, self.pressure)

    def electrical_from_pressure(self, pressure: float) -> float:
        """Return the signal of a monitor output, which has some headroom beyond its range."""
        return _line(pressure, self.pressure, self.electrical)

    def raw_from_electrical(self, signal: float, low: float, high: float) -> int:
        """Return the converter's counts for a signal, saturated at `low` … `high`."""
        raw = round(_line(signal, self.electrical, self.raw))
        return raw if low <= raw <= high else int(min(max(raw, low), high))


def _line(x: float, xs: tuple[float, float], ys: tuple[float, float]) -> float:
    return ys[0] + (x - xs[0]) * (ys[1] - ys[0]) / (xs[1] - xs[0])
