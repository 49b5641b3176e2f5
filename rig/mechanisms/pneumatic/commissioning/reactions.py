"""What becomes of pressurised chambers: emergency stop, the master's death, the cable pulled."""

from rig.commissioning.operator import Task
from rig.commissioning.site import Site, patience, world_of
from rig.commissioning.step import (
    AcceptanceStep,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.commissioning.steps.stop import press, release, stop_device
from rig.hal import DeviceError
from rig.hal.world import BreakableWorld
from rig.mechanisms.pneumatic.commissioning.chambers import (
    LOWEST,
    Chambers,
    energised,
    true_pressures,
)


class StopReaction(AcceptanceStep):
    """The emergency stop is pressed while the chambers hold some pressure."""

    name = "stop-reaction"
    does = "Every chamber gets 8 kPa; you press the emergency stop."
    expects = "The chambers are vented at once."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        most = site.profile.loop.safe_within
        with energised(site) as chambers:
            rig, bench = chambers.rig, chambers.bench
            device, stop = stop_device(rig), rig.mechanism.stop_input()
            if device is None or stop is None:
                return StepResult(said="the profile names no contact of an emergency stop")
            chambers.set_all(LOWEST)
            rises = chambers.rises()
            site.operator.do(press(device), world_of(rig))
            seen = bench.run(patience(rig), lambda: stop.emergency_stop().value)
            require(seen, "emergency stop", "it was pressed and is not seen while energised")
            start = bench.now
            bench.make_safe()
            bench.run(2.0 * most, chambers.have_fallen(0.5, rises))
            took = MeasuredValue(
                "vented after the press was seen", bench.now - start, "s", high=most
            )
            site.operator.do(release(device), world_of(rig))
        require_within("emergency stop", took, "the chambers are not vented when it is pressed")
        return StepResult((took,))


class MasterDies(AcceptanceStep):
    """The program that is the master dies while the chambers hold some pressure."""

    name = "master"
    does = "Every chamber gets 8 kPa; the process that sends setpoints is killed, and one listens."
    expects = "The devices vent by themselves within their heartbeat's time."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        with energised(site) as chambers:
            bench, regulators = chambers.bench, chambers.regulators
            chambers.set_all(LOWEST)
            rises = chambers.rises()
            bench.die(0.2)
            took = _fall_unheard(chambers, rises, site.profile.loop.safe_within)
        entry = site.profile.devices[regulators.name]
        bus = None if entry.bus is None else site.profile.buses[entry.bus].settings
        after = entry.settings.acts_after(bus)
        bound = site.profile.loop.safe_within + (0.0 if after is None else after)
        measured = MeasuredValue("safe after the master's death", took, "s", high=bound)
        require_within(
            "watchdog", measured, f"{regulators.name} keeps its pressure when its master is dead: "
            "its watchdog is off",
        )  # fmt: skip
        return StepResult((measured,))


def _fall_unheard(chambers: Chambers, tops: tuple[float, ...], within: float) -> float:
    """Return after how long the chambers are vented although nobody sends anything, s."""
    bench = chambers.bench
    start = bench.now
    while bench.now - start <= 2.0 * within:
        if chambers.below(chambers.regulators.inspect(), 0.5, tops):
            break
        bench.listen(2e-3, lambda: False)
    return bench.now - start


class CablePulled(AcceptanceStep):
    """The bus's cable is pulled while the chambers hold some pressure."""

    name = "cable"
    does = "Every chamber gets 8 kPa; you pull the cable of the bus, and read the gauges."
    expects = "The program notices, and the gauges go to zero without it."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        with energised(site) as chambers:
            rig, bench = chambers.rig, chambers.bench
            channels = chambers.regulators.channels
            bus = site.profile.devices[chambers.regulators.name].bus
            if bus is None:
                return StepResult(said="the regulators hang on no bus")
            chambers.set_all(LOWEST)
            site.operator.do(_pull(bus), world_of(rig))
            start, noticed = bench.now, ""
            try:
                bench.run(patience(rig))
            except DeviceError as error:
                noticed = str(error)
            require(bool(noticed), f"bus {bus}", "its cable was pulled and nobody noticed")
            found = MeasuredValue("noticed after the word was given", bench.now - start, "s")
            bench.listen(site.profile.loop.safe_within, lambda: False)
            at_zero = _at_zero(channels)
            site.operator.do(at_zero, world_of(rig))
        is_zero = site.operator.answer(at_zero).strip().lower() in ("y", "yes")
        require(is_zero, "watchdog", "the chambers keep their pressure without the cable")
        return StepResult((found,), {"noticed": noticed})


def _pull(bus: str) -> Task:
    def act(world: BreakableWorld) -> str:
        world.inject(bus, "bus_off")
        return "done"

    return Task("cable.pull", f"Pull the cable of the bus {bus}.", act)


def _at_zero(channels: tuple[str, ...]) -> Task:
    def look(world: BreakableWorld) -> str:
        world.advance(world.time)
        vented = max(true_pressures(world, channels).values()) < 0.5 * LOWEST
        return "yes" if vented else "no"

    return Task("cable.gauges", "Do the gauges of all chambers show zero (yes, no)?", look)
