"""What profiles and experiments may name, as the loader and the program ask for it."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from rig.assembly.contract_check import (
    check_class,
    check_kind,
    check_offers,
    check_settings,
    check_table,
)
from rig.assembly.offered import (
    additions,
    additions_to,
    code_of,
    codes,
    drivers,
    foreign_additions,
    installed_names,
    mechanisms,
    protocols,
)
from rig.assembly.rows import load
from rig.config.named_settings import Kind
from rig.config.settings import validator
from rig.hal import (
    ConfigurationError,
    ContractBroken,
    CyclicBus,
    Device,
    DriverSettings,
    Mechanism,
    Plant,
)
from rig.hal.bench import TuningBench
from rig.hal.controller import Law
from rig.hal.drawn_profile import Draw
from rig.hal.driver import BusSettings
from rig.hal.hazards import Hazard
from rig.hal.motion import FactKind
from rig.hal.parts import Additions, DriverParts, MechanismParts, ProtocolParts
from rig.hal.plant import PhysicsSettings
from rig.hal.scene import Scene

if TYPE_CHECKING:
    from rig.hal.measured_loop import MeasuredLoop

Thing = TypeVar("Thing")


class InstalledParts:
    """Everything that a profile or experiment may name; implements `rig.config.Registry`."""

    # Rows -----------------------------------------------------------------------------

    def mechanism(self, name: str) -> MechanismParts:
        """Return the row of a mechanism; KeyError if there is none."""
        return mechanisms().find(name)

    def driver(self, name: str) -> DriverParts:
        """Return the row of a driver; KeyError if there is none."""
        return drivers().find(name)

    def protocol(self, name: str) -> ProtocolParts:
        """Return the row of what is spoken on a bus; KeyError if there is none."""
        return protocols().find(name)

    def admit(self, additions: str) -> None:
        """Let additions of another package take part.

        Raises
        ------
        KeyError
            No package offers any of that name.
        ConfigurationError
            They cannot be imported, or two packages have them.
        """
        foreign_additions().find(additions)

    def unnamed(self) -> tuple[str, ...]:
        """Return the additions that packages offer and no file has named, with their packages."""
        return foreign_additions().unnamed()

    def broken(self) -> tuple[str, ...]:
        """Return why what a file named cannot be used, a sentence each."""
        found = (mechanisms(), drivers(), protocols(), foreign_additions())
        return (*(why for rows in found for why in rows.broken.values()), *_TWICE.values())

    # Names ----------------------------------------------------------------------------

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted; also those of packages that no file has named."""
        return installed_names(kind)

    def imported(self, kind: Kind) -> tuple[str, ...]:
        """Return the names of a kind that are ours, or of a package that a file has named."""
        return tuple(sorted(codes(kind)))

    def settings(self, kind: Kind, name: str) -> type[Any]:
        """Return the settings dataclass of a name; KeyError if there is none."""
        code = code_of(kind, name)
        path = code.settings or f"{code.path}.Settings"
        found: type[Any] = load(path, f"{kind} {name}: ")
        what = f"{kind} {name}: {path}"
        check_settings(what, found, _SETTINGS_OF.get(kind, object))
        try:
            validator(found)
        except Exception as error:  # of the types that somebody has annotated
            raise ContractBroken(f"{what}: {error}") from error
        return found

    def load(self, kind: Kind, name: str) -> Any:
        """Return the class behind a name; KeyError if there is none.

        Raises
        ------
        ConfigurationError
            It is not what the contract says.
        """
        path = code_of(kind, name).path
        found = load(path, f"{kind} {name}: ")
        protocols = _PROTOCOLS_OF.get(kind, ())
        if kind == "controller":
            protocols = (*protocols, load(self.mechanism(name.partition("/")[0]).view).law)
        for protocol in protocols:
            check_class(f"{kind} {name}: {path}", found, protocol)
        return found

    def hazards(self, plant: str) -> Callable[[Any], tuple[Hazard, ...]] | None:
        """Return what makes the hazards of a plant of a mechanism's settings, if anything does."""
        for row in additions():
            if plant in row.plants and (path := row.plants[plant].hazards) is not None:
                found: Callable[[Any], tuple[Hazard, ...]] = load(path)
                if not callable(found):
                    raise ConfigurationError(f"plant {plant}: {path} is no function of settings")
                return found
        return None

    def plants(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the plants of a mechanism."""
        rows = additions_to(mechanism)
        return tuple(name for row in rows for name in row.plants)

    def references(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the references that a mechanism follows."""
        rows = additions_to(mechanism)
        return tuple(name for row in rows for name in row.references)

    def is_restorable(self, plant: str) -> bool:
        """Return whether a plant can be taken back to where it was."""
        rows = [row.plants[plant] for row in additions() if plant in row.plants]
        return any(row.is_restorable for row in rows)

    def lends_kernel(self, plant: str) -> bool:
        """Return whether a plant lends its kernel to loops that are compiled as a whole."""
        rows = [row.plants[plant] for row in additions() if plant in row.plants]
        return any(row.lends_kernel for row in rows)

    def plant_channels(self, plant: str) -> tuple[str, ...]:
        """Return what a plant has channels for, as its row says; empty: it does not say."""
        rows = [row.plants[plant] for row in additions() if plant in row.plants]
        return rows[0].channels if rows else ()

    def bench(self, mechanism: str) -> type[TuningBench] | None:
        """Return what `rig tune` tries gains of a mechanism on; None: there is nothing."""
        path = self.mechanism(mechanism).bench
        if path is None:
            return None
        found: type[TuningBench] = load(path, f"mechanism {mechanism}: ")
        check_offers(f"mechanism {mechanism}: {path}", found, TuningBench)
        return found

    def measured_loop(self, mechanism: str) -> "Callable[..., MeasuredLoop] | None":
        """Return what tells a loop from a run, see `MechanismParts`; None: there is nothing."""
        path = self.mechanism(mechanism).measured_loop
        if path is None:
            return None
        found: Callable[..., MeasuredLoop] = load(path, f"mechanism {mechanism}: ")
        return found

    def commissioning(self, mechanism: str, protocol: type[Thing]) -> Sequence[Thing]:
        """Return the steps of a mechanism's acceptance test; empty if it has none.

        Parameters
        ----------
        mechanism : str
            Its name.
        protocol : type
            `rig.commissioning.step.AcceptanceStep`.
        """
        path = self.mechanism(mechanism).commissioning
        if path is None:
            return ()
        steps: Sequence[Thing] = load(path, f"mechanism {mechanism}: ")()
        for step in steps:
            check_offers(f"mechanism {mechanism}: {path}", step, protocol)
        return steps

    def scene(self, mechanism: str) -> type[Scene] | None:
        """Return what `rig watch` draws of a mechanism; None: it gives no picture of itself."""
        path = self.mechanism(mechanism).scene
        if path is None:
            return None
        found: type[Scene] = load(path, f"mechanism {mechanism}: ")
        check_class(f"mechanism {mechanism}: {path}", found, Scene)
        return found

    def drawing(self, kind: str) -> Draw:
        """Return what makes a profile of a description in a format.

        Raises
        ------
        ConfigurationError
            No mechanism has such.
        """
        for name in mechanisms().names():
            path = self.mechanism(name).drawings.get(kind)
            if path is not None:
                draw: Draw = load(path, f"mechanism {name}: ")
                return draw
        raise ConfigurationError(f"no rig is made from {kind}")

    # What mechanisms add to the frameworks ----------------------------------------------

    def measures(self, mechanism: str | None, kind: type[Thing]) -> Mapping[str, Thing]:
        """Return every measure by name.

        Parameters
        ----------
        mechanism : str, optional
            Whose own go before those of others.
        kind : type
            `rig.experiment.measure.Measure`.
        """
        return _merged("measure", lambda row: row.measures, mechanism, kind)

    def own_measures(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of one mechanism's measures."""
        rows = additions_to(mechanism)
        return tuple(name for row in rows for path in row.measures for name in load(path))

    def facts(self, mechanism: str) -> Sequence[tuple[str, FactKind]]:
        """Return the names of what one mechanism's motions know beforehand, each with its kind."""
        rows = additions_to(mechanism)
        tables = [(path, load(path)) for row in rows for path in row.facts]
        return [
            (name, check_kind(f"fact: {path}", kind, FactKind))
            for path, table in tables
            for name, kind in table.items()
        ]

    def reported(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of the measures that every run of a mechanism reports."""
        return tuple(name for row in additions_to(mechanism) for name in row.reported)

    def figures(self, mechanism: str | None, kind: type[Thing]) -> Mapping[str, Thing]:
        """Return every mechanism's figures by name, which are `rig.report.figure.FigureKind`."""
        return _merged("figure", lambda row: row.figures, mechanism, kind)

    def own_figures(self, mechanism: str) -> tuple[str, ...]:
        """Return the names of one mechanism's figures."""
        rows = additions_to(mechanism)
        return tuple(name for row in rows for path in row.figures for name in load(path))

    def comparisons(self, mechanism: str | None, kind: type[Thing]) -> tuple[Thing, ...]:
        """Return a mechanism's comparisons, or everybody's; the most particular first."""
        return tuple(
            check_kind(f"comparison: {path}", load(path), kind)
            for row in reversed(additions() if mechanism is None else additions_to(mechanism))
            for path in row.comparisons
        )

    def procedures(self, mechanism: str, protocol: type[Thing]) -> Mapping[str, Thing]:
        """Return a mechanism's procedures by path, in the order they build on each other."""
        return {
            path: _made_procedure(path, protocol)
            for row in additions_to(mechanism)
            for path in row.procedures
        }


_PROTOCOLS_OF: dict[Kind, tuple[type, ...]] = {
    "mechanism": (Mechanism,),
    "driver": (Device,),
    "bus": (CyclicBus,),
    "plant": (Plant,),
    "controller": (Law,),
}
_SETTINGS_OF: dict[Kind, type] = {
    "driver": DriverSettings,
    "bus": BusSettings,
    "plant": PhysicsSettings,
}
_TWICE: dict[str, str] = {}
"""Measures and figures that two packages have for one mechanism, and which they are."""


def _merged(
    kind: str,
    paths_of: Callable[[Additions], tuple[str, ...]],
    mechanism: str | None,
    type_of: type[Thing],
) -> Mapping[str, Thing]:
    """Return the union of the mappings that rows name, in the order of the rows.

    What others call by the same name as a mechanism's own does not concern it, or a package could
    break the rigs of all others. A name that two packages have for one mechanism is left out: only
    who uses it has to know why.
    """
    found: dict[str, Thing] = {}
    own: dict[str, str] = {}
    if mechanism is not None:
        additions_to(mechanism)
    for row in additions():
        for path in paths_of(row):
            for name, thing in check_table(f"{kind}s: {path}", load(path), type_of).items():
                if row.mechanism != mechanism:
                    found.setdefault(name, thing)
                elif own.setdefault(name, path) == path:
                    found[name] = thing
                else:
                    _TWICE[name] = f"two packages have a {kind} {name!r}: {own[name]} and {path}"
    return {name: thing for name, thing in found.items() if name not in _TWICE}


def _made_procedure(path: str, protocol: type[Thing]) -> Thing:
    make = load(path)
    if isinstance(make, type):  # else something that calls one
        check_class(f"procedure: {path}", make, protocol)
    made: Thing = make()
    check_offers(f"procedure: {path}", made, protocol)
    return made


REGISTRY = InstalledParts()
