"""Tell which regulator is stuck, and how, or that the supply is gone."""

from collections.abc import Sequence

from controllers.spherical_joint.geometry import Quadruple
from rig.hal import SafetyError
from rig.mechanisms.joint.alarms.settings import PressureAlarm
from rig.mechanisms.pneumatic.settings import RegulatorModel

_ALIKE = 0.5
"""A channel that is off by this share of the permitted deviation is off like the worst one."""
_MOVED = 0.25
"""A pressure that has changed by this share of the deviation since it was well is not held."""


class _Channel:
    """A healthy regulator's pressure for the setpoints that were sent, and when it was met."""

    __slots__ = ("expected", "held", "off", "rate", "well_at")

    def __init__(self, pressure: float, now: float) -> None:
        self.expected = self.held = pressure
        self.rate = 0.0
        self.off = 0.0
        self.well_at = now


class PressureWatch:
    """Compares the chambers' pressures with what healthy regulators would make of the setpoints.

    Parameters
    ----------
    settings : PressureAlarm
        How far and how long.
    response : RegulatorModel
        Of a healthy regulator: second order.
    channels : sequence of str
        For messages.
    device : str
        The regulators' name, for messages.
    """

    def __init__(
        self,
        settings: PressureAlarm,
        response: RegulatorModel,
        channels: Sequence[str],
        device: str,
    ) -> None:
        self._settings = settings
        self._stiffness = response.bandwidth**2
        self._drag = 2.0 * response.damping * response.bandwidth
        self._names = tuple(channels)
        self._device = device
        self._channels: tuple[_Channel, ...] = ()
        self._then = 0.0
        self._setpoints: Sequence[float] = ()
        self._pressures: Sequence[float] = ()

    def send(self, setpoints: Sequence[float]) -> None:
        """Take the setpoints of this cycle, Pa gauge."""
        self._setpoints = setpoints

    def check(self, pressures: Quadruple, now: float) -> None:
        """Take this cycle's readings (Pa gauge), and raise if one has been off for too long.

        Raises
        ------
        SafetyError
            It names the channel and the likeliest cause.
        """
        self._pressures = pressures
        step = now - self._then
        self._then = now
        setpoints = self._setpoints
        if not self._channels or not setpoints or step <= 0.0:
            self._channels = tuple([_Channel(pressure, now) for pressure in pressures])
            return
        deviation = self._settings.deviation
        pull, brake = step * self._stiffness, 1.0 / (1.0 + step * self._drag)
        worst: _Channel | None = None
        for k, channel in enumerate(self._channels):
            expected, pressure = channel.expected, pressures[k]
            channel.rate = rate = (channel.rate + pull * (setpoints[k] - expected)) * brake
            channel.expected = expected = expected + step * rate
            channel.off = off = pressure - expected
            if -deviation <= off <= deviation:
                channel.well_at = now
                channel.held = pressure
            elif worst is None or channel.well_at < worst.well_at:
                worst = channel
        if worst is not None and now - worst.well_at > self._settings.time:
            self._raise(now)

    def _raise(self, now: float) -> None:
        settings = self._settings
        for k, channel in enumerate(self._channels):
            if now - channel.well_at > settings.time:
                raise SafetyError(
                    f"{self._device}: {self._explain()} [{self._names[k]}: "
                    f"{self._pressures[k] * 1e-3:.0f} kPa, setpoint "
                    f"{self._setpoints[k] * 1e-3:.0f} kPa, {channel.off * 1e-3:+.0f} kPa off a "
                    f"healthy regulator for {now - channel.well_at:.3f} s, at most "
                    f"{settings.deviation * 1e-3:.0f} kPa for {settings.time:g} s]"
                )

    def suspicion(self) -> str | None:
        """Return what looks wrong now, before it has lasted; None if nothing does."""
        worst = max((abs(channel.off) for channel in self._channels), default=0.0)
        if worst <= _ALIKE * self._settings.deviation:
            return None
        k = max(range(len(self._channels)), key=lambda k: abs(self._channels[k].off))
        return (
            f"{self._device}: {self._explain()} [{self._names[k]}: "
            f"{self._channels[k].off * 1e-3:+.0f} kPa off a healthy regulator, at most "
            f"{self._settings.deviation * 1e-3:.0f} kPa]"
        )

    def _explain(self) -> str:
        channels, names = self._channels, self._names
        alike = _ALIKE * self._settings.deviation
        low = [k for k, channel in enumerate(channels) if channel.off < -alike]
        worst = max(range(len(channels)), key=lambda k: abs(channels[k].off))
        if len(low) > 1 and worst in low:
            return f"the supply pressure is lost: {', '.join(names[k] for k in low)} fall short"
        change = self._pressures[worst] - channels[worst].held
        moved = _MOVED * self._settings.deviation
        if channels[worst].off > 0.0:
            if change > moved:
                return f"the regulator of {names[worst]} is stuck open: its pressure rises"
            return f"the regulator of {names[worst]} is stuck closed: its pressure stays"
        if change < -moved:
            return (
                f"the regulator of {names[worst]} is stuck venting, or its tube is off: "
                "its pressure falls"
            )
        return (
            f"the regulator of {names[worst]} is stuck closed, or its chamber leaks: "
            "its pressure stays"
        )
