"""From a driver's settings to the simulated device on its other side.

The settings say how the device is wired: node number, scales, bits. They are data; what the
emulated device makes of them is its own, so that a mistake in a driver's codec shows.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from drivers.cia401.channels import AnalogueSignal
from drivers.cia401.settings import Cia401Settings
from drivers.cia406.settings import Cia406Settings
from drivers.sim.camera.wiring import (
    emulate_marker_camera,
    simulate_marker_camera,
    true_camera,
)
from drivers.sim.direct.corrected_axes import CorrectedAxes
from drivers.sim.direct.corrected_channels import CorrectedRegulators, CorrectedRods
from drivers.sim.direct.encoders import SimulatedEncoder
from drivers.sim.direct.regulators import SimulatedRegulators
from drivers.sim.dynamixel.wiring import emulate_dynamixel, simulate_dynamixel
from drivers.sim.nodes import object_dictionary as types
from drivers.sim.nodes.analogue import AnalogueScale
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.cia401 import EmulatedCia401, RegulatorWiring
from drivers.sim.nodes.cia406 import EmulatedCia406
from drivers.sim.servo_wiring import (
    emulate_cia402,
    emulate_odrive,
    simulate_cia402,
    simulate_odrive,
)
from rig.hal import Clock, ConfigurationError

_TYPES = {
    "i8": types.INTEGER8,
    "i16": types.INTEGER16,
    "i32": types.INTEGER32,
    "u8": types.UNSIGNED8,
    "u16": types.UNSIGNED16,
    "u32": types.UNSIGNED32,
    "f32": types.REAL32,
}


class Plant(Protocol):
    """What wiring needs of a plant: its ports, its channels by name, and its faults."""

    channel_names: tuple[str, ...]

    def advance(self, t: float) -> None:
        """Integrate up to time `t`, s."""
        ...

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""
        ...


class Wiring(NamedTuple):
    """How to make the two simulated forms of a driver's device.

    Attributes
    ----------
    emulate : callable
        ``emulate(name, settings, plant, channels, serial)``: a node on an emulated bus, or a
        tuple of them.
    simulate : callable
        ``simulate(name, settings, plant, channels, clock)``: a device with no bus.
    correct : callable, optional
        ``correct(nominal, settings, plant, channels)``: a port that shows of the plant what a
        driver with calibrated settings makes of a device that is wired as the nominal ones say.
    """

    emulate: Callable[[str, Any, Any, tuple[int, ...], int], Any]
    simulate: Callable[[str, Any, Any, tuple[int, ...], Clock], Any]
    correct: Callable[[Any, Any, Any, tuple[int, ...]], Any] | None = None


def plant_channels(
    device: str, wired: Mapping[str, str], plant: Plant, names: tuple[str, ...]
) -> tuple[int, ...]:
    """Return the plant's channels that a device is wired to.

    Parameters
    ----------
    device : str
        The device's name in the profile.
    wired : mapping of str to str
        The plant's channel of a device that measures a single one.
    plant : Plant
        The physics.
    names : tuple of str
        The device's own channels; empty if it has no names for them.

    Raises
    ------
    ConfigurationError
        The plant has no such channel.
    """
    wanted = names or ((wired[device],) if device in wired else ())
    missing = [name for name in wanted if name not in plant.channel_names]
    if missing or not wanted:
        raise ConfigurationError(
            f"{device}: the plant has no channel {', '.join(missing) or 'for it'}; "
            f"it has {', '.join(plant.channel_names)}"
        )
    return tuple(plant.channel_names.index(name) for name in wanted)


def emulate_cia401(
    name: str, settings: Cia401Settings, plant: Any, channels: tuple[int, ...], serial: int
) -> EmulatedNode:
    """Return an emulated CiA 401 module, wired as the driver's settings say."""
    signals = list(settings.channels.values())
    by_plant = [signals[channels.index(number)] for number in sorted(channels)]
    outputs = {signal.setpoint.index: signal.setpoint.type for signal in signals}
    inputs = {signal.monitor.index: signal.monitor.type for signal in signals}
    if len(outputs) > 1 or len(inputs) > 1:
        raise ConfigurationError(
            f"{name}: an emulated module has its setpoints in one object and its monitors in one"
        )
    (output_object, output_type), (input_object, input_type) = (
        *outputs.items(),
        *inputs.items(),
    )
    return EmulatedCia401(
        name,
        settings.node,
        plant,
        [
            RegulatorWiring(
                signal.setpoint.sub,
                signal.monitor.sub,
                _scale(signal.setpoint),
                _scale(signal.monitor),
                signal.lock_bit,
            )
            for signal in by_plant
        ],
        outputs=max(4, *(signal.setpoint.sub for signal in signals)),
        inputs=max(4, *(signal.monitor.sub for signal in signals)),
        output_object=output_object,
        input_object=input_object,
        output_type=_TYPES[output_type],
        input_type=_TYPES[input_type],
        supply_bit=settings.supply_bit,
        stop_bit=settings.stop_bit,
        stop_active_low=settings.stop_active_low,
        serial=serial,
    )


def simulate_cia401(
    name: str, settings: Cia401Settings, plant: Any, channels: tuple[int, ...], clock: Clock
) -> SimulatedRegulators:
    """Return simulated regulators with the range and resolution of the wired ones."""
    if list(channels) != sorted(channels):
        raise ConfigurationError(f"{name}: without a bus, its channels stand in the plant's order")
    resolution = max(
        abs(
            (signal.monitor.pressure[1] - signal.monitor.pressure[0])
            / (signal.monitor.raw[1] - signal.monitor.raw[0])
        )
        for signal in settings.channels.values()
    )
    return SimulatedRegulators(
        name,
        tuple(settings.channels),
        plant,
        clock,
        pressure_range=settings.pressure_range,
        resolution=resolution,
        deviation=settings.following.deviation,
        deviation_time=settings.following.time,
        safe=tuple(signal.safe for signal in settings.channels.values()),
        lockable=tuple(signal.lock_bit is not None for signal in settings.channels.values()),
    )


def emulate_cia406(
    name: str, settings: Cia406Settings, plant: Any, channels: tuple[int, ...], serial: int
) -> EmulatedNode:
    """Return an emulated CiA 406 encoder, mounted as the driver's settings say."""
    # The driver reads ±scale·counts·step + offset as the extension: the device counts what
    # makes that true of a rod that the calibration described rightly.
    return EmulatedCia406(
        name,
        settings.node,
        plant,
        channels[0],
        stroke=settings.stroke,
        step=settings.step or 1e-6,
        speed_step=settings.speed_step or 1e-5,
        offset=-settings.offset / settings.scale,
        reversed_direction=settings.reversed,
        serial=serial,
    )


def simulate_cia406(
    name: str, settings: Cia406Settings, plant: Any, channels: tuple[int, ...], clock: Clock
) -> SimulatedEncoder:
    """Return a simulated encoder with the resolution of the real one."""
    return SimulatedEncoder(
        name,
        channels[0],
        plant,
        clock,
        stroke=settings.stroke,
        resolution=settings.step or 1e-6,
        speed_resolution=settings.speed_step or 1e-5,
        max_speed=settings.max_speed,
    )


class LinkWiring(NamedTuple):
    """How to make the two simulated forms of a device that hangs on no bus.

    Attributes
    ----------
    emulate : callable
        ``emulate(name, settings, plant, seed, serial=, **reality)``: what stands in for its
        hardware, and lives in virtual time.
    simulate : callable
        ``simulate(name, settings, plant, clock, seed, serial=, **reality)``: the device itself.
    reality : callable
        ``reality(nominal, plant, bounds, seed)``: keywords that say what is true of the device,
        from its settings before any calibration and from the bounds of what is drawn.
    """

    emulate: Callable[..., Any]
    simulate: Callable[..., Any]
    reality: Callable[[Any, Any, Any, int], dict[str, Any]]


MARKER_CAMERA = LinkWiring(emulate_marker_camera, simulate_marker_camera, true_camera)
CIA401 = Wiring(emulate_cia401, simulate_cia401, CorrectedRegulators.of)
CIA406 = Wiring(emulate_cia406, simulate_cia406, CorrectedRods.of)
CIA402 = Wiring(emulate_cia402, simulate_cia402, CorrectedAxes.of)
ODRIVE = Wiring(emulate_odrive, simulate_odrive, CorrectedAxes.of)
DYNAMIXEL = Wiring(emulate_dynamixel, simulate_dynamixel, CorrectedAxes.of)


def _scale(signal: AnalogueSignal) -> AnalogueScale:
    return AnalogueScale(raw=signal.raw, electrical=signal.signal, pressure=signal.pressure)
