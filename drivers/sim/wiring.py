"""From a driver's settings to the simulated device on its other side.

The settings say how the device is wired: node number, scales, bits. They are data; what the
emulated device makes of them is its own, so that a mistake in a driver's codec shows. Each driver
has its own object of these types, which its row names; none of them imports another's.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from drivers.sim.perturbation import Draws
from rig.hal import Clock, ConfigurationError, Device

Settings = TypeVar("Settings")
Port = TypeVar("Port")
Node = TypeVar("Node", covariant=True)
Own = TypeVar("Own", covariant=True)
Seen = TypeVar("Seen", covariant=True)


@dataclass(frozen=True, slots=True)
class Installed(Generic[Own, Seen]):
    """A device as it is built into a simulated rig.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : object
        The driver's.
    plant : object
        The physics, by what the device needs of it.
    channels : tuple of int
        The plant's channels that it is wired to, in the order of its own.
    nominal : object, optional
        The driver's settings before any calibration, which is the driver's knowledge alone: the
        device is as these say. Default: `settings`.
    description : Path, optional
        The device's own EDS.
    serial : int, optional
        The serial number that the profile wants of it, which it then has.
    seed : int
        Of the simulation.
    bounds : mapping of str to float
        By how much the simulated rig may differ from its profile, SI.
    """

    name: str
    settings: Own
    plant: Seen
    channels: tuple[int, ...] = ()
    nominal: Own | None = None
    description: Path | None = None
    serial: int | None = None
    seed: int = 0
    bounds: Mapping[str, float] = field(default_factory=dict)

    @property
    def built(self) -> Own:
        """What the device is really like, as far as settings say."""
        return self.settings if self.nominal is None else self.nominal

    def require_plant_order(self) -> None:
        """Refuse channels in another order than the plant's, for a device without a bus.

        Raises
        ------
        ConfigurationError
            They stand in another one.
        """
        if list(self.channels) != sorted(self.channels):
            raise ConfigurationError(
                f"{self.name}: without a bus, its channels stand in the plant's order"
            )


class Wiring(NamedTuple, Generic[Settings, Port, Node]):
    """Makes the two simulated forms of a device on a bus.

    Attributes
    ----------
    emulate : callable
        ``emulate(installed)``: its nodes on an emulated bus.
    simulate : callable
        ``simulate(installed, clock)``: a device with no bus.
    correct : callable, optional
        ``correct(installed)``: a port that shows of the plant what a driver with calibrated
        settings makes of a device that is wired as the nominal ones say.
    perturb : callable, optional
        ``perturb(plant, draws)``: a port that shows of the plant what sensors and actuators make
        of it that err as drawn. None: the device does not err.
    needs_channels : bool
        Whether the plant must have a channel for it.
    """

    emulate: Callable[[Installed[Settings, Port]], Sequence[Node]]
    simulate: Callable[[Installed[Settings, Port], Clock], Device]
    correct: Callable[[Installed[Settings, Port]], Port] | None = None
    perturb: Callable[[Port, Draws], Port] | None = None
    needs_channels: bool = True


class LinkWiring(NamedTuple, Generic[Settings, Port]):
    """Makes the simulated forms of a device that hangs on no bus.

    Attributes
    ----------
    emulate : callable
        ``emulate(installed)``: what stands in for its hardware, and lives in virtual time
        (`drivers.sim.emulated_rig.Timed`); the driver takes it as its ``link``.
    simulate : callable
        ``simulate(installed, clock)``: the device itself.
    serve : callable, optional
        ``serve(installed, channel)``: what `rig simulate` serves to another process
        (`drivers.sim.wall_clock.ServedDevice`), beside the rig's first CAN interface.
    reach : callable, optional
        ``reach(name, channel)``: the driver's ``link`` to what another process serves.
    """

    emulate: Callable[[Installed[Settings, Port]], Any]
    simulate: Callable[[Installed[Settings, Port], Clock], Device]
    serve: Callable[[Installed[Settings, Port], str], Any] | None = None
    reach: Callable[[str, str], Any] | None = None


def plant_channels(
    device: str,
    wired: Mapping[str, str],
    known: tuple[str, ...],
    names: tuple[str, ...],
    *,
    needed: bool = True,
) -> tuple[int, ...]:
    """Return the plant's channels that a device is wired to.

    Parameters
    ----------
    device : str
        The device's name in the profile.
    wired : mapping of str to str
        The plant's channel of a device that measures a single one.
    known : tuple of str
        The plant's channels.
    names : tuple of str
        The device's own channels; empty if it has no names for them.
    needed : bool
        Whether it must have one; else it may name none.

    Raises
    ------
    ConfigurationError
        The plant has no such channel.
    """
    wanted = names or ((wired[device],) if device in wired else ())
    missing = [name for name in wanted if name not in known]
    if missing or (needed and not wanted):
        raise ConfigurationError(
            f"{device}: the plant has no channel {', '.join(missing) or 'for it'}; "
            f"it has {', '.join(known)}"
        )
    return tuple(known.index(name) for name in wanted)
