"""What becomes of an energised rig: emergency stop, the master's death, the cable pulled."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import NamedTuple, Protocol

from rig.assembly import Rig
from rig.commissioning.bench import StepBench
from rig.commissioning.forms import one_of
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import (
    AcceptanceStep,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.commissioning.steps.stop import press, release, stop_device
from rig.config import Profile
from rig.hal import DeviceError
from rig.hal.world import BreakableWorld


class Energy(Protocol):
    """The energy of an energised rig, and how it is seen that it has gone."""

    bench: StepBench

    questions_feed: bool = False
    """Whether a question restarts a watchdog: nothing is asked before its time is over."""

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.bench.rig

    @property
    @abstractmethod
    def holders(self) -> Sequence[str]:
        """Devices whose watchdogs take it away when the master is dead."""

    @abstractmethod
    def bring_up(self) -> None:
        """Have as much of it as any of these steps needs."""

    @abstractmethod
    def has_gone(self) -> bool:
        """Say by the cycle's readings whether it has gone."""

    @abstractmethod
    def asked_to_have_gone(self) -> str:
        """Ask without the cycle; return who has it still, empty if nobody has."""

    def asked_to_have_grown(self) -> bool:
        """Ask without the cycle whether there is more of it than before: nobody waits for more."""
        return False

    @abstractmethod
    def without_cable(self, site: Site, bus: str) -> Callable[[], str]:
        """Look whether it has gone without the cable; what is returned says what is wrong, or "".

        That is called when the rig is closed: somebody may have to be asked.
        """


class Reacting(NamedTuple):
    """A mechanism's part of these steps.

    Parameters
    ----------
    energised : callable
        ``energised(site)`` yields a rig's `Energy`.
    brought_up : str
        What the rig is brought to, a clause for the operator.
    gone, kept : str
        What is expected, and what is wrong, as clauses.
    """

    energised: Callable[[Site], AbstractContextManager[Energy]]
    brought_up: str
    gone: str
    kept: str


class StopReaction(AcceptanceStep):
    """The emergency stop is pressed while the rig is energised."""

    name = "stop-reaction"

    def __init__(self, of: Reacting) -> None:
        self._of = of
        self.does = f"{of.brought_up}; you press the emergency stop."
        self.expects = f"At once {of.gone}."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        most = site.profile.loop.safe_within
        with self._of.energised(site) as energy:
            rig, bench = energy.rig, energy.bench
            device, stop = stop_device(rig), rig.mechanism.stop_input()
            if device is None or stop is None:
                return StepResult(said="the profile names no contact of an emergency stop")
            energy.bring_up()
            site.operator.do(press(device), site.world_of(rig))
            seen = bench.run(site.patience(rig), lambda: stop.emergency_stop().value)
            require(seen, "emergency stop", "it was pressed and is not seen while energised")
            start = bench.now
            bench.make_safe()
            bench.run(2.0 * most, energy.has_gone)
            took = MeasuredValue("safe after the press was seen", bench.now - start, "s", high=most)
            site.operator.do(release(device), site.world_of(rig))
        require_within("emergency stop", took, f"{self._of.kept} when it is pressed")
        return StepResult((took,))


class MasterDies(AcceptanceStep):
    """The program that is the master dies while the rig is energised."""

    name = "master"

    def __init__(self, of: Reacting) -> None:
        self._of = of
        self.does = f"{of.brought_up}; the process that sends setpoints is killed, and one listens."
        self.expects = f"By the devices' own watchdogs {of.gone}, within their time."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        most = site.profile.loop.safe_within
        with self._of.energised(site) as energy:
            bench, after = energy.bench, acts_within(site.profile, energy.holders)
            energy.bring_up()
            bench.die(0.2)
            start = bench.now
            if energy.questions_feed:
                bench.listen(after + 0.5 * most, lambda: False)
            while (left := energy.asked_to_have_gone()) and bench.now - start <= after + most:
                if bench.now - start > after and energy.asked_to_have_grown():
                    break
                bench.listen(2e-3, lambda: False)
            took = bench.now - start
        bound = after + most
        measured = MeasuredValue("safe after the master's death", took, "s", high=bound)
        require(
            not left and measured.passed, "watchdog",
            f"{left or self._of.kept} when the master is dead: its watchdog is off; {measured}",
        )  # fmt: skip
        return StepResult((measured,))


class CablePulled(AcceptanceStep):
    """The cable of each bus that devices are energised by is pulled."""

    name = "cable"

    def __init__(self, of: Reacting) -> None:
        self._of = of
        self.does = f"{of.brought_up}; you pull the cable of the bus."
        self.expects = f"The program notices, and without it {of.gone}."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        measured: list[MeasuredValue] = []
        facts: dict[str, object] = {}
        for bus in self._buses(site):
            found, noticed = self._pull(site, bus)
            measured.append(found)
            facts[f"noticed on {bus}"] = noticed
        said = "" if measured else "nothing that holds energy hangs on a bus"
        return StepResult(tuple(measured), facts, said)

    def _buses(self, site: Site) -> list[str]:
        with self._of.energised(site) as energy:
            entries = [site.profile.devices[name] for name in energy.holders]
        return list(dict.fromkeys(entry.bus for entry in entries if entry.bus is not None))

    def _pull(self, site: Site, bus: str) -> tuple[MeasuredValue, str]:
        with self._of.energised(site) as energy:
            rig, bench = energy.rig, energy.bench
            energy.bring_up()
            site.operator.do(_pull_task(bus), site.world_of(rig))
            start, noticed = bench.now, ""
            try:
                bench.run(site.patience(rig))
            except DeviceError as error:
                noticed = str(error)
            require(bool(noticed), f"bus {bus}", "its cable was pulled and nobody noticed")
            took = bench.now - start
            say = energy.without_cable(site, bus)
        wrong = say()
        require(not wrong, "watchdog", wrong)
        return MeasuredValue(f"{bus}: noticed after the word was given", took, "s"), noticed


def acts_within(profile: Profile, names: Sequence[str]) -> float:
    """Return after how long without the master devices make themselves safe, s: the slowest."""
    times = [0.0]
    for name in names:
        entry = profile.devices[name]
        bus = None if entry.bus is None else profile.buses[entry.bus].settings
        times.append(entry.settings.acts_after(bus) or 0.0)
    return max(times)


def put_back(site: Site, rig: Rig, bus: str) -> Task:
    """Have the cable of a bus put back; return the task, whose answer says that it is."""
    task = _cable_task(
        "cable.put-back", f"Put the cable of the bus {bus} back; is it (yes)?", bus, 0.0
    )
    site.operator.do(task, site.world_of(rig))
    return task


def _pull_task(bus: str) -> Task:
    return _cable_task("cable.pull", f"Pull the cable of the bus {bus}.", bus, 1.0)


def _cable_task(key: str, text: str, bus: str, lost: float) -> Task:
    """Return a task with a cable: without it every frame is lost, both ways."""

    def act(world: BreakableWorld) -> str:
        world.inject(bus, "frame_loss", lost)
        return "yes"

    return Task(key, text, act, one_of("yes"))
