"""From the settings of a CiA 401 module to its simulated forms."""

from collections.abc import Sequence
from typing import TypeVar

from drivers.cia401.channel_settings import AnalogueSignal
from drivers.cia401.module_settings import ModuleSettings
from drivers.cia401.settings import Cia401Settings
from drivers.sim.direct.regulators import SimulatedRegulators
from drivers.sim.nodes.analogue import AnalogueScale
from drivers.sim.nodes.cia401 import AnalogueArray, EmulatedCia401, ModuleBuild, RegulatorWiring
from drivers.sim.nodes.object_dictionary import BY_NAME
from drivers.sim.regulator_lines import correct_regulators, perturb_regulators
from drivers.sim.regulator_port import RegulatorPort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock, ConfigurationError

Module = TypeVar("Module", bound=ModuleSettings)
Port = TypeVar("Port")


def emulate_cia401(of: Installed[Cia401Settings, RegulatorPort]) -> tuple[EmulatedCia401]:
    """Return an emulated CiA 401 module, wired as the driver's settings say."""
    locks = [channel.lock_bit for channel in of.built.channels.values()]
    return (emulated_module(of, of.built, of.plant, locks),)


def emulated_module(
    of: Installed[Module, Port],
    settings: ModuleSettings,
    port: RegulatorPort,
    lock_bits: Sequence[int | None],
) -> EmulatedCia401:
    """Return an emulated CiA 401 module.

    Parameters
    ----------
    of : Installed
        Whose it is.
    settings : ModuleSettings
        As it is built.
    port : RegulatorPort
        What hangs on it.
    lock_bits : sequence of int or None
        Output bits of the lock valves, one for each of its channels.
    """
    signals = list(settings.wired.values())
    by_plant = [of.channels.index(number) for number in sorted(of.channels)]
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
            signals[k].setpoint.sub,
            signals[k].monitor.sub,
            _scale(signals[k].setpoint),
            _scale(signals[k].monitor),
            lock_bits[k],
        )
        for k in by_plant
    ]
    return EmulatedCia401(of.name, settings.node, port, wired, build)


def simulate_cia401(
    of: Installed[Cia401Settings, RegulatorPort], clock: Clock
) -> SimulatedRegulators:
    """Return simulated regulators with the range and resolution of the wired ones."""
    settings = of.settings
    of.require_plant_order()
    return SimulatedRegulators(
        of.name,
        tuple(settings.channels),
        of.plant,
        clock,
        pressure_range=settings.pressure_range,
        resolution=monitor_resolution(settings),
        deviation=settings.following.deviation,
        deviation_time=settings.following.time,
        safe=tuple(signal.safe for signal in settings.channels.values()),
        lockable=tuple(signal.lock_bit is not None for signal in settings.channels.values()),
    )


def monitor_resolution(settings: ModuleSettings) -> float:
    """Return the coarsest step of a module's monitors, Pa."""
    lines = [(channel.monitor.ends, channel.monitor.raw) for channel in settings.wired.values()]
    return max(abs((end - start) / (high - low)) for (start, end), (low, high) in lines)


def _array(name: str, signals: Sequence[AnalogueSignal]) -> AnalogueArray:
    kinds = {signal.index: signal.type for signal in signals}
    if len(kinds) > 1:
        raise ConfigurationError(
            f"{name}: an emulated module has its setpoints in one object and its monitors in one"
        )
    ((index, kind),) = kinds.items()
    return AnalogueArray(index, max(4, *(signal.sub for signal in signals)), BY_NAME[kind])


def _scale(signal: AnalogueSignal) -> AnalogueScale:
    return AnalogueScale(raw=signal.raw, electrical=signal.signal, pressure=signal.ends)


WIRING = Wiring(emulate_cia401, simulate_cia401, correct_regulators, perturb_regulators)
