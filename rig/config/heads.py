"""The parts of a profile and of a device's entry that are the same for every rig."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge

from rig.config.models import LoopSettings
from rig.config.simulation_models import SimulationSettings


@dataclass(frozen=True, slots=True)
class ProfileHead:
    """The part of a profile that is the same for every rig.

    Parameters
    ----------
    mechanism : str
        The mechanism's name; its settings stand under the key of that name.
    loop : LoopSettings
        The cycle.
    name : str
        Default: the name of the file.
    description : str
        One sentence for people.
    additions : tuple of str
        What packages of others add to the mechanism, by the names of their entry points; code of
        theirs runs for no profile that does not name it.
    simulation : SimulationSettings
        The simulated world around the plant.
    """

    mechanism: str
    loop: LoopSettings
    name: str = ""
    description: str = ""
    additions: tuple[str, ...] = ()
    simulation: SimulationSettings = field(default_factory=SimulationSettings)


@dataclass(frozen=True, slots=True)
class DeviceHead:
    """The part of a device's entry that is the same for every driver.

    Parameters
    ----------
    bus : str, optional
        The bus that it hangs on.
    serial : int, optional
        The serial number that it must report.
    """

    bus: str | None = None
    serial: Annotated[int, Ge(0)] | None = None
