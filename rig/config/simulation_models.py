"""What a profile says of the simulated world: what breaks, and how it differs from the profile."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Interval, MinLen, Unit

from rig.config.quantities import parse_any_quantity


@dataclass(frozen=True, slots=True)
class FaultSpec:
    """Something that goes wrong in simulation.

    Parameters
    ----------
    at : float
        When, s after the simulated world began. The log's clock begins when all devices are
        connected, some 0.1 s later; what happened by then is among its events.
    device : str
        The device or bus that it befalls.
    fault : str
        What; the emulated device knows the names.
    value : float or str, optional
        How much, where the fault takes a value: a number in SI, or with its unit. Of a fault that
        befalls a channel without saying its name (`wire_cut`, `wire_break`) it is the channel's
        number, counted from 0; `rig faults list RIG` has the names.

    Raises
    ------
    ValueError
        The value is no quantity.
    """

    at: Annotated[float, Unit("s"), Ge(0)]
    device: str
    fault: Annotated[str, MinLen(1)]
    value: float | str | None = None

    def __post_init__(self) -> None:
        _ = self.size

    @property
    def size(self) -> float | None:
        """How much, SI."""
        if isinstance(self.value, str):
            return parse_any_quantity(self.value)[0]
        return self.value


@dataclass(frozen=True, slots=True)
class Perturbation:
    """Bounds on how the simulated rig may differ from its profile, so that it can be calibrated.

    Each number bounds a uniform draw, once per channel, joint or dimension, from the seed of
    the simulation; 0 draws nothing. What was drawn is known to the simulation alone.

    Parameters
    ----------
    setpoint_gain, setpoint_offset : float
        Of the pressure that a regulator gives over the one that it was asked for, 1 and Pa.
    monitor_gain, monitor_offset : float
        Of a pressure monitor, 1 and Pa.
    encoder_scale, encoder_offset : float
        Of a rod's encoder, 1 and m.
    friction : float
        Of all friction, as a share of it.
    stribeck : float
        Of the seals' Stribeck velocity, as a share of it.
    wire_offset : float
        Of the rod extension at which the wires are taut, m.
    leak : float
        Sonic conductance of a chamber's leak, m³/(s Pa): a third of it to the whole.
    geometry : float
        Of every length and angle of a mechanism's geometry, as a share of it.
    camera_position, camera_angle : float
        Of the camera's pose, m and rad, along and about each axis.
    camera_focal, camera_centre, camera_distortion : float
        Of the lens: focal length as a share of it, principal point in pixels, and k1.
    camera_latency : float
        Of the camera's latency, s.
    joint_zero : float
        Of a servo joint's zero, rad.
    joint_scale : float
        Of a servo joint's encoder, 1.
    joint_reversed : float
        How likely a servo joint turns the other way than the profile says.
    link_length : float
        Of every length of a mechanism's geometry, m.
    marker : float
        Of the marker on the hand along each axis, m: a standard deviation and no bound, as what
        a fixture is made to is stated.
    """

    setpoint_gain: Annotated[float, Unit("1"), Interval(ge=0, le=0.2)] = 0.0
    setpoint_offset: Annotated[float, Unit("Pa"), Interval(ge=0, le=50e3)] = 0.0
    monitor_gain: Annotated[float, Unit("1"), Interval(ge=0, le=0.2)] = 0.0
    monitor_offset: Annotated[float, Unit("Pa"), Interval(ge=0, le=50e3)] = 0.0
    encoder_scale: Annotated[float, Unit("1"), Interval(ge=0, le=0.2)] = 0.0
    encoder_offset: Annotated[float, Unit("m"), Interval(ge=0, le=0.02)] = 0.0
    friction: Annotated[float, Unit("1"), Interval(ge=0, le=0.9)] = 0.0
    stribeck: Annotated[float, Unit("1"), Interval(ge=0, le=0.9)] = 0.0
    wire_offset: Annotated[float, Unit("m"), Interval(ge=0, le=0.01)] = 0.0
    leak: Annotated[float, Unit("m^3/(s Pa)"), Interval(ge=0, le=1e-8)] = 0.0
    geometry: Annotated[float, Unit("1"), Interval(ge=0, le=0.1)] = 0.0
    camera_position: Annotated[float, Unit("m"), Interval(ge=0, le=0.1)] = 0.0
    camera_angle: Annotated[float, Unit("rad"), Interval(ge=0, le=0.5)] = 0.0
    camera_focal: Annotated[float, Unit("1"), Interval(ge=0, le=0.2)] = 0.0
    camera_centre: Annotated[float, Interval(ge=0, le=200)] = 0.0
    camera_distortion: Annotated[float, Unit("1"), Interval(ge=0, le=1)] = 0.0
    camera_latency: Annotated[float, Unit("s"), Interval(ge=0, le=0.03)] = 0.0
    joint_zero: Annotated[float, Unit("rad"), Interval(ge=0, le=0.5)] = 0.0
    joint_scale: Annotated[float, Unit("1"), Interval(ge=0, le=0.2)] = 0.0
    joint_reversed: Annotated[float, Unit("1"), Interval(ge=0, le=1)] = 0.0
    link_length: Annotated[float, Unit("m"), Interval(ge=0, le=0.02)] = 0.0
    marker: Annotated[float, Unit("m"), Interval(ge=0, le=0.01)] = 0.0


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """The simulated world around the plant: chance, buses, faults.

    Parameters
    ----------
    seed : int
        Of everything random.
    bus_latency : float
        From a sent frame to the node that receives it, s.
    frame_loss : float
        Share of frames that get lost, 0 … 1.
    faults : tuple of FaultSpec
        What goes wrong, and when.
    perturbation : Perturbation
        By how much the simulated rig may differ from its profile.
    """

    seed: Annotated[int, Interval(ge=0, lt=2**32)] = 0
    bus_latency: Annotated[float, Unit("s"), Interval(ge=0, le=0.1)] = 3e-4
    frame_loss: Annotated[float, Unit("1"), Interval(ge=0, le=1)] = 0.0
    faults: tuple[FaultSpec, ...] = ()
    perturbation: Perturbation = field(default_factory=Perturbation)
