"""What a profile says of proportional valves in the place of regulators."""

from dataclasses import dataclass, field
from typing import Annotated, Final

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.pressure_loop import PressureLoopSettings
from controllers.cylinder.valve_flow import AIR, SupplyModel, ValveModel, port_flow

_CHOKED: Final = 500e3
"""A pressure against which the atmosphere does not count any more, Pa absolute."""


@dataclass(frozen=True, slots=True)
class SpoolModel:
    """The quickness of the spools: what `rig tune` draws, and gains have to bear.

    Parameters
    ----------
    bandwidth : float
        Natural frequency, rad/s. By the data sheet.
    dead_time : float
        From a signal to the first motion, s.
    """

    bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(5000)] = 628.0
    dead_time: Annotated[float, Unit("s"), Ge(0), Le(0.02)] = 1e-3


@dataclass(frozen=True, slots=True)
class ValvesSettings:
    """Valves and the inner loop that makes regulators of them.

    Parameters
    ----------
    supply : SupplyModel
        What the valves have in common.
    loop : PressureLoopSettings
        Gains of the inner loop.
    spool : SpoolModel
        How quick the spools are.
    nominal : ValveModel
        A valve that nobody has calibrated.
    channels : dict of str to ValveModel
        Valves by their chamber, as `rig calibrate RIG valves` finds them.
    """

    supply: SupplyModel = field(default_factory=SupplyModel)
    loop: PressureLoopSettings = field(default_factory=PressureLoopSettings)
    spool: SpoolModel = field(default_factory=SpoolModel)
    nominal: ValveModel = field(default_factory=ValveModel)
    channels: dict[str, ValveModel] = field(default_factory=dict)

    def of(self, channel: str) -> ValveModel:
        """Return the valve of a chamber."""
        return self.channels.get(channel, self.nominal)

    def slowest_exhaust(self, volume: float) -> float:
        """Return which share of a chamber's air the tightest open exhaust lets out, 1/s.

        Parameters
        ----------
        volume : float
            Of the chamber, m³.
        """
        passed = port_flow(-1.0, _CHOKED, self.supply) / _CHOKED
        tightest = min(valve.conductance_out for valve in (self.nominal, *self.channels.values()))
        return passed * tightest * AIR / volume
