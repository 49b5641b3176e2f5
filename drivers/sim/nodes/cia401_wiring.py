"""From the settings of a CiA 401 module to its simulated forms."""

from drivers.cia401.channel_settings import AnalogueSignal
from drivers.cia401.settings import Cia401Settings
from drivers.sim.direct.regulators import SimulatedRegulators
from drivers.sim.nodes.analogue import AnalogueScale
from drivers.sim.nodes.cia401 import AnalogueArray, EmulatedCia401, ModuleBuild, RegulatorWiring
from drivers.sim.nodes.object_dictionary import BY_NAME
from drivers.sim.regulator_lines import correct_regulators, perturb_regulators
from drivers.sim.regulator_port import RegulatorPort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock, ConfigurationError


def emulate_cia401(of: Installed[Cia401Settings, RegulatorPort]) -> tuple[EmulatedCia401]:
    """Return an emulated CiA 401 module, wired as the driver's settings say."""
    settings = of.built
    signals = list(settings.channels.values())
    by_plant = [signals[of.channels.index(number)] for number in sorted(of.channels)]
    build = ModuleBuild(
        outputs=_array(of.name, [signal.setpoint for signal in signals]),
        inputs=_array(of.name, [signal.monitor for signal in signals]),
        supply_bit=settings.supply_bit,
        stop_bit=settings.stop_bit,
        stop_active_low=settings.stop_active_low,
        serial=of.serial or 0,
    )
    wired = [
        RegulatorWiring(
            signal.setpoint.sub,
            signal.monitor.sub,
            _scale(signal.setpoint),
            _scale(signal.monitor),
            signal.lock_bit,
        )
        for signal in by_plant
    ]
    return (EmulatedCia401(of.name, settings.node, of.plant, wired, build),)


def simulate_cia401(
    of: Installed[Cia401Settings, RegulatorPort], clock: Clock
) -> SimulatedRegulators:
    """Return simulated regulators with the range and resolution of the wired ones."""
    settings = of.settings
    if list(of.channels) != sorted(of.channels):
        raise ConfigurationError(
            f"{of.name}: without a bus, its channels stand in the plant's order"
        )
    resolution = max(
        abs(
            (signal.monitor.pressure[1] - signal.monitor.pressure[0])
            / (signal.monitor.raw[1] - signal.monitor.raw[0])
        )
        for signal in settings.channels.values()
    )
    return SimulatedRegulators(
        of.name,
        tuple(settings.channels),
        of.plant,
        clock,
        pressure_range=settings.pressure_range,
        resolution=resolution,
        deviation=settings.following.deviation,
        deviation_time=settings.following.time,
        safe=tuple(signal.safe for signal in settings.channels.values()),
        lockable=tuple(signal.lock_bit is not None for signal in settings.channels.values()),
    )


def _array(name: str, signals: list[AnalogueSignal]) -> AnalogueArray:
    kinds = {signal.index: signal.type for signal in signals}
    if len(kinds) > 1:
        raise ConfigurationError(
            f"{name}: an emulated module has its setpoints in one object and its monitors in one"
        )
    ((index, kind),) = kinds.items()
    return AnalogueArray(index, max(4, *(signal.sub for signal in signals)), BY_NAME[kind])


def _scale(signal: AnalogueSignal) -> AnalogueScale:
    return AnalogueScale(raw=signal.raw, electrical=signal.signal, pressure=signal.pressure)


WIRING = Wiring(emulate_cia401, simulate_cia401, correct_regulators, perturb_regulators)
