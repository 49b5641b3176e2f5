"""The flow map of a proportional valve: from a wanted mass flow to the opening of its spool.

References
----------
ISO 6358-1:2013, Pneumatic fluid power: determination of flow-rate characteristics.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Ge, Gt, Interval, Lt, Unit

from controllers.compiled import PlainNumbers, inlined

ATMOSPHERE: Final = 101_325.0
"""Around the rig, Pa."""
AIR: Final = 287.05 * 293.15
"""Gas constant of air times its temperature, J/kg."""
POLYTROPIC: Final = 1.2
"""Between air that fills adiabatically and air that leaves isothermally."""
_DENSITY: Final = 1.185
"""At reference conditions (ANR), kg/m³."""
_LEAST_SHARE: Final = 0.1
"""Of the choked flow: nearer to equal pressures a port is taken to pass so much. Else noise in the
pressure would throw the spool about."""
_ROUNDED: Final = 2e-3
"""Share of a port's conductance below which the opening runs straight through the dead zone: a
step across it would make the spool chatter about a pressure that is held."""


@dataclass(frozen=True, slots=True)
class ValveModel:
    """A valve as the controllers believe it.

    Parameters
    ----------
    feeds_from, exhausts_from : float
        Openings at which it begins to feed and to exhaust the chamber; between them it is shut.
    conductance_in, conductance_out : float
        Sonic conductance of feed and exhaust, m³/(s Pa), if it went on at full stroke as it begins.
    """

    feeds_from: Annotated[float, Interval(ge=-0.2, le=0.2)] = 0.015
    exhausts_from: Annotated[float, Interval(ge=-0.2, le=0.2)] = -0.015
    conductance_in: Annotated[float, Unit("m^3/(s Pa)"), Gt(0)] = 3.2e-9
    conductance_out: Annotated[float, Unit("m^3/(s Pa)"), Gt(0)] = 3.0e-9

    def __post_init__(self) -> None:
        if not self.exhausts_from < self.feeds_from:
            raise ValueError(
                f"exhausts_from ({self.exhausts_from:g}) is not below feeds_from "
                f"({self.feeds_from:g}): it would feed and exhaust at once."
            )


@dataclass(frozen=True, slots=True)
class SupplyModel:
    """The supply that the valves of a rig share, as the controllers believe it.

    Parameters
    ----------
    pressure : float
        Of the supply, Pa gauge.
    critical_ratio : float
        Critical pressure ratio b of the ports.
    """

    pressure: Annotated[float, Unit("Pa"), Gt(0)] = 700e3
    critical_ratio: Annotated[float, Ge(0), Lt(1)] = 0.3


class ValveFlow(PlainNumbers):
    """The inverse of one valve's flow map.

    Parameters
    ----------
    valve : ValveModel
        The spool's.
    supply : SupplyModel
        The air's.
    """

    def __init__(self, valve: ValveModel, supply: SupplyModel) -> None:
        self.feeds = valve.feeds_from
        """Opening at which it begins to feed."""
        self.exhausts = valve.exhausts_from
        """Opening at which it begins to exhaust."""
        self._per_in, self._per_out = 1.0 / valve.conductance_in, 1.0 / valve.conductance_out
        self._supply = ATMOSPHERE + supply.pressure
        self._ratio = supply.critical_ratio

    def opening(self, flow: float, pressure: float) -> float:
        """Return the opening (-1 … 1) for a mass flow.

        Parameters
        ----------
        flow : float
            Into the chamber, kg/s; out of it if negative.
        pressure : float
            In the chamber, Pa absolute.
        """
        share = flow / _port_flow(flow, pressure, self._supply, self._ratio)
        share *= self._per_in if flow >= 0.0 else self._per_out
        if share >= _ROUNDED:
            opening = self.feeds + share * (1.0 - self.feeds)
        elif share <= -_ROUNDED:
            opening = self.exhausts + share * (1.0 + self.exhausts)
        else:
            high = self.feeds + _ROUNDED * (1.0 - self.feeds)
            low = self.exhausts - _ROUNDED * (1.0 + self.exhausts)
            opening = 0.5 * (high + low) + 0.5 * (high - low) * share / _ROUNDED
        return 1.0 if opening > 1.0 else -1.0 if opening < -1.0 else opening


@inlined
def _port_flow(flow: float, pressure: float, supply: float, ratio: float) -> float:
    """Return what a port of 1 m³/(s Pa) passes, kg/s: the feed or, for a flow below 0, the exhaust.

    Pressures are absolute, Pa.
    """
    if flow >= 0.0:
        return _DENSITY * supply * _share_of_choked(pressure / supply, ratio)
    return _DENSITY * pressure * _share_of_choked(ATMOSPHERE / pressure, ratio)


def port_flow(flow: float, pressure: float, supply: SupplyModel) -> float:
    """Return what a port of 1 m³/(s Pa) passes, kg/s, where a flow (kg/s) has that sign.

    Parameters
    ----------
    flow : float
        Into the chamber, or out of it if negative.
    pressure : float
        In the chamber, Pa absolute.
    supply : SupplyModel
        The air's.
    """
    return _port_flow(flow, pressure, ATMOSPHERE + supply.pressure, supply.critical_ratio)


def flow_of_pressure(rate: float, volume: float) -> float:
    """Return the mass flow (kg/s) that changes a pressure at some rate (Pa/s) in a volume (m³)."""
    return volume * rate / (POLYTROPIC * AIR)


@inlined
def _share_of_choked(ratio: float, critical: float) -> float:
    """Return the flow over the choked flow for downstream over upstream pressure; never 0."""
    if ratio <= critical:
        return 1.0
    subsonic = (ratio - critical) / (1.0 - critical)
    if subsonic >= 1.0:
        return _LEAST_SHARE
    share = math.sqrt(1.0 - subsonic * subsonic)
    return share if share > _LEAST_SHARE else _LEAST_SHARE


inlined(ValveFlow.opening)
