"""Proportional valves, chamber sensors and rods' encoders, which together are regulators."""

from collections.abc import Sequence
from math import inf
from typing import cast

from controllers.cylinder.pressure_loop import ChamberModel, PressureLoop
from rig.hal import (
    ConfigurationError,
    LinearEncoder,
    PressureRegulator,
    ProportionalValves,
    Reading,
    Vector,
)
from rig.mechanisms.pneumatic.settings import PneumaticSettings
from rig.mechanisms.pneumatic.valves.settings import ValvesSettings

Regulating = PressureRegulator | ProportionalValves

_PAUSE = 5.0
"""Cycles without a pressure being wanted, after which the loops begin anew."""


class ValveRegulators(PressureRegulator):
    """Regulators that are made of valves by an inner loop for each chamber.

    It stands between a mechanism and its device: the mechanism gives it wanted pressures once a
    cycle, and it gives the device openings in the same cycle.

    Parameters
    ----------
    valves : ProportionalValves
        The device.
    encoders : sequence of LinearEncoder
        Of the rods, one to each chamber, in the order of the valves' channels.
    settings : PneumaticSettings
        Of the mechanism.
    period : float
        The loop's, s.

    Raises
    ------
    ConfigurationError
        The settings name a valve that there is not.
    """

    def __init__(
        self,
        valves: ProportionalValves,
        encoders: Sequence[LinearEncoder],
        settings: PneumaticSettings,
        period: float,
    ) -> None:
        said = settings.valves or ValvesSettings()
        unknown = sorted(set(said.channels) - set(valves.channels))
        if unknown:
            raise ConfigurationError(
                f"valves.channels: {valves.name} has no {', '.join(unknown)}; its channels are "
                f"{', '.join(valves.channels)}"
            )
        self.name, self.channels = valves.name, valves.channels
        self.pressure_range = valves.sensor_range
        self._valves = valves
        self._positions = tuple(encoder.position for encoder in encoders)
        self.loops = pressure_loops(settings, valves.channels, period)
        self._pause = _PAUSE * period
        self._then = -inf

    def pressure(self) -> Reading[Vector]:
        """Return what the chambers' sensors show, Pa gauge, shape (n,)."""
        return self._valves.pressure()

    def set_pressure(self, pressure: Vector) -> None:
        """Give the valves the openings for these pressures, Pa gauge, shape (n,). Hot path."""
        measured, t = self._valves.pressure()
        extensions = [position()[0][0] for position in self._positions]
        if t - self._then > self._pause:
            for k, loop in enumerate(self.loops):
                loop.reset(measured[k], extensions[k])
        self._then = t
        self._valves.set_opening(
            tuple(
                [
                    loop.step(pressure[k], measured[k], extensions[k])
                    for k, loop in enumerate(self.loops)
                ]
            )
        )

    def safe_pressure(self) -> Vector:
        """Return that all chambers are vented; see `PressureRegulator.safe_pressure`."""
        return (0.0,) * len(self.channels)

    def inspect(self) -> Vector:
        """See `PressureRegulator.inspect`."""
        return self._valves.inspect()

    def shut_supply(self, shut: bool) -> bool:
        """See `PressureRegulator.shut_supply`."""
        return self._valves.shut_supply(shut)

    # The device's own life is led by the rig, which knows it and not this.

    def connect(self) -> None:
        """See `Device.connect`."""
        self._valves.connect()

    def arm(self) -> None:
        """See `Device.arm`."""
        self._valves.arm()

    def check(self, now: float) -> None:
        """See `Device.check`."""
        self._valves.check(now)

    def make_safe(self) -> None:
        """See `Device.make_safe`."""
        self._valves.make_safe()

    def close(self) -> None:
        """See `Device.close`."""
        self._valves.close()


def pressure_loops(
    settings: PneumaticSettings, channels: Sequence[str], period: float
) -> list[PressureLoop]:
    """Return the inner loops of all chambers."""
    said = settings.valves or ValvesSettings()
    response = settings.regulator_response
    chamber = ChamberModel(
        settings.area,
        settings.dead_volume + settings.area * settings.stroke,
        response.bandwidth,
        response.damping,
    )
    return [
        PressureLoop(said.loop, chamber, said.of(channel), said.supply, period)
        for channel in channels
    ]


def regulating_kind(settings: PneumaticSettings) -> type[Regulating]:
    """Return what the device that sets the chambers' pressures has to be."""
    return PressureRegulator if settings.valves is None else ProportionalValves


def as_regulators(
    device: Regulating,
    encoders: Sequence[LinearEncoder],
    settings: PneumaticSettings,
    period: float,
) -> PressureRegulator:
    """Return regulators: as they are, or made of valves."""
    if settings.valves is None:
        return cast(PressureRegulator, device)
    return ValveRegulators(cast(ProportionalValves, device), encoders, settings, period)
