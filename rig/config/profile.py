"""Load a profile, its calibrations and the options over it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from rig.config.calibration import (
    COMMON_KEYS,
    find_calibration,
    pruned,
    read_provenance,
    with_replaced,
)
from rig.config.code_sections import Sections
from rig.config.device_file import DeviceDescription
from rig.config.diagnostics import Problems, nearest, shown
from rig.config.document import apply_overrides, load_document, parse_overrides
from rig.config.dump import as_plain
from rig.config.heads import DeviceHead, ProfileHead
from rig.config.laid_over import TUNED, lay_calibrations
from rig.config.law_hint import hint_of_additions
from rig.config.located import BROKEN, Node, places_of
from rig.config.models import (
    BusEntry,
    Calibration,
    DeviceEntry,
    LoopSettings,
    PlantEntry,
    Profile,
)
from rig.config.named_settings import Registry, controller_key, controller_names
from rig.config.names import find_file, is_name, is_path, list_files
from rig.config.read_part import PartlyRead, ReadPart
from rig.config.records import record_folders
from rig.config.settings import build
from rig.config.simulation_models import SimulationSettings
from rig.config.unitless import say_unitless

PROFILE_KEYS: Final = (
    "extends", "name", "description", "mechanism", "loop", "buses", "devices", "controllers",
    "plant", "simulation", "calibration", "additions",
)  # fmt: skip
"""Top-level keys of a profile, besides the one that its mechanism's name makes."""


DEFAULT_PROTOCOL: Final = "canopen"
"""What is spoken on a bus whose entry does not say."""


def load_profile(
    source: str | Path,
    registry: Registry,
    overrides: Sequence[str] = (),
    search: Sequence[Path] = (),
) -> Profile:
    """Load a profile, its bases, its calibrations and the options over it.

    Later in this order wins: bases, the profile, calibrations, options.

    Parameters
    ----------
    source : str or Path
        A rig's name, or the path of a file.
    registry : Registry
        The names of drivers, controllers, mechanisms, plants and buses.
    overrides : sequence of str
        ``a.b=c`` options.
    search : sequence of Path
        The configuration folders, as `find_configs` returns them.

    Returns
    -------
    Profile
        Valid as a whole, in SI.

    Raises
    ------
    ProfileError
        With every error, located.
    ConfigurationError
        There is no such profile, or a file cannot be read.
    """
    path = find_file(source, "rigs", search)
    problems = Problems()
    document = load_document(path, "rigs", search, problems)
    options = parse_overrides(overrides, problems)
    root = apply_overrides(document.root, options, problems)
    rig = _name(root, path, problems)
    folders = record_folders([path], search)
    laid = lay_calibrations(document.root, root, rig, document.files, folders, problems)
    calibrated, calibrations, foreign, files, without = laid
    bare = root
    root = apply_overrides(calibrated, options, problems)
    reader = _Reader(root, registry, problems, calibrations, foreign, bare)
    part = reader.read(rig, (*document.files, *files))
    if problems and part is not None:
        raise PartlyRead(problems.error().diagnostics, part)
    problems.raise_if_any()
    assert part is not None
    measured = _calibrated_bases(rig, document.files[:0:-1], without, folders)
    return replace(part.profile, calibrated_bases=measured)


def rig_name(source: str, search: Sequence[Path]) -> str:
    """Return the name that a rig's calibrations are kept under; none of them is read.

    Parameters
    ----------
    source : str
        A rig's name, or the path of a file.
    search : sequence of Path
        The folders of configurations.

    Raises
    ------
    ConfigurationError
        There is no such file, or it says no name that a folder may have. A name that no file has
        is taken as it is: calibrations may outlive their profile.
    """
    if not is_path(source) and source not in list_files("rigs", search):
        return source
    path = find_file(source, "rigs", search)
    problems = Problems()
    name = _name(load_document(path, "rigs", search, problems).root, path, problems)
    problems.raise_if_any()
    return name


def _calibrated_bases(
    rig: str, bases: Sequence[Path], targets: Sequence[str], search: Sequence[Path]
) -> dict[str, str]:
    """Return the rig that is calibrated where the one that extends it is not; a nearer one wins."""
    names = [name for base in bases if (name := rig_name(str(base), search)) != rig]
    return {
        target: name
        for name in (names if targets else ())
        for target in targets
        if find_calibration(name, target, search) is not None
    }


def _name(root: Node, path: Path, problems: Problems) -> str:
    node = root.get("name")
    if node is None or node.value is None:
        return path.stem
    if isinstance(node.value, str) and is_name(node.value):
        return node.value
    problems.add(
        node.mark, f"name is {shown(node.plain())}, expected a name that a folder may have"
    )
    return ""


class _Reader(Sections):
    """The merged document, read section by section into a `Profile`."""

    def __init__(
        self,
        root: Node,
        registry: Registry,
        problems: Problems,
        calibrations: dict[str, Calibration],
        foreign: dict[str, Calibration],
        bare: Node,
    ) -> None:
        keys = (*PROFILE_KEYS, *registry.names("mechanism"))
        super().__init__(root, keys, registry, problems)
        self._calibrations = calibrations
        self._foreign = foreign
        self._bare = bare

    def read(self, name: str, files: tuple[Path, ...]) -> ReadPart | None:
        """Read every section, so that every error is found; None if there is no mechanism."""
        self.admit_additions()
        mechanism_settings, calibration, uncalibrated = self._mechanism()
        bus_nodes, device_nodes = self.named("buses"), self.named("devices")
        buses = {bus: self.bus(node, DEFAULT_PROTOCOL) for bus, node in bus_nodes.items()}
        devices = {
            device: self._device(device, node, tuple(bus_nodes))
            for device, node in device_nodes.items()
        }
        controllers = {
            controller: self._controller(controller, node)
            for controller, node in self.named("controllers", names=False).items()
        }
        plant_node = self.take("plant")
        plant = None if plant_node is None else self.chosen("plant", plant_node, "model")
        simulation = self._simulation((*device_nodes, *bus_nodes, "plant"))
        read = self.rest(ProfileHead)
        head = self._unread_head() if read is None else read
        if head is None:
            return None
        profile = Profile(
            name=name,
            description=head.description,
            mechanism=head.mechanism,
            mechanism_settings=mechanism_settings,
            loop=head.loop,
            buses={name: BusEntry(*chosen) for name, chosen in buses.items() if chosen},
            devices={name: entry for name, entry in devices.items() if entry is not None},
            controllers=controllers,
            plant=None if plant is None else PlantEntry(*plant),
            simulation=SimulationSettings() if simulation is None else simulation,
            files=files,
            calibration=calibration,
            uncalibrated=uncalibrated,
            places=dict(places_of(self.root)),
            additions=head.additions,
            unitless=say_unitless(self.problems.unitless, dict(places_of(self._bare))),
            foreign=self._foreign,
            tunings={
                name.removeprefix(TUNED): calibration
                for name, calibration in self._calibrations.items()
                if name.startswith(TUNED)
            },
        )
        lacking = tuple(device for device, entry in devices.items() if entry is None)
        is_made = None not in (read, mechanism_settings, *buses.values())
        return ReadPart(profile, lacking, is_made)

    def _unread_head(self) -> ProfileHead | None:
        """Return what stands for a head with an error; None: not even the mechanism is said."""
        node = self.root.get("mechanism")
        if node is None or node.value not in self.registry.names("mechanism"):
            return None
        return ProfileHead(str(node.value), LoopSettings(rate=1.0))

    def _mechanism(self) -> tuple[object, Calibration | None, object]:
        """Return its settings, what was laid over them, and the settings without it."""
        node = self.root.get("mechanism")
        name = None if node is None else node.value
        settings = None
        if node is not None and isinstance(name, str):
            settings = self.settings_of("mechanism", name, node)
        if settings is None or not isinstance(name, str):
            # Its name is missing or wrong, which is said elsewhere; its settings are not unknown.
            for other in self.registry.names("mechanism"):
                self.take(other)
            return None, None, None
        entry = self.take(name, required=True)
        if entry is None or not self.is_mapping(entry, name):
            return None, None, None
        built = build(settings, entry, self.problems)
        calibration = self._calibration(name, self.take("calibration"))
        if built is None:
            return None, None, None
        return built, *self._nominal(name, settings, self._bare.get(name), calibration)

    def _controller(self, name: str, node: Node) -> object:
        mechanism = self.root.get("mechanism")
        of = mechanism.value if mechanism is not None else None
        scope = of if isinstance(of, str) else None
        known = controller_names(self.registry, scope)
        if name not in known:
            message = f"no controller is called {shown(name)}"
            hint = hint_of_additions(self.registry, nearest(name, known))
            self.problems.add(node.heading, message, hint)
            return None
        key = name if scope is None else controller_key(self.registry, scope, name)
        try:
            settings = self.registry.settings("controller", key)
        except KeyError:  # the mechanism is missing, which is said elsewhere
            return None
        return build(settings, node, self.problems)

    def _device(self, name: str, node: Node, buses: tuple[str, ...]) -> DeviceEntry | None:
        common, own = _parted(node)
        stated = {key: entry for key, entry in common.items() if key in ("bus", "serial")}
        head = build(DeviceHead, node.with_items(stated), self.problems)
        if head is not None and head.bus is not None and head.bus not in buses:
            hint = nearest(head.bus, buses) or "the profile has no buses"
            self.problems.add(common["bus"].mark, f"no bus is called {shown(head.bus)}", hint)
        calibration = self._calibration(name, common.get("calibration"))
        driver = self.text(node, "driver")
        if driver is None:
            return None
        settings = self.settings_of("driver", driver, common["driver"])
        if settings is None:
            return None
        _, bare = _parted(self._bare.descend(("devices", name))[0])
        file = DeviceDescription.of(settings, own, self.problems)
        if file is not None:
            own, bare = file.complete(own), file.complete(bare)
        built = build(settings, own, self.problems, also=COMMON_KEYS)
        if file is not None and built is not None:
            file.compare(name, built, own)
        if head is None or built is None:
            return None
        path = None if file is None else file.path
        calibration, nominal = self._nominal(name, settings, bare, calibration)
        return DeviceEntry(driver, head.bus, head.serial, built, calibration, path, nominal)

    def _nominal(
        self, name: str, settings: type[object], bare: Node | None, calibration: Calibration | None
    ) -> tuple[Calibration | None, object]:
        """Return a calibration with what it replaced, and the settings without it."""
        if calibration is None or bare is None:
            return calibration, None
        if name not in self._calibrations:  # a resolved profile says itself what was replaced
            return calibration, build(settings, with_replaced(bare, calibration), self.problems)
        nominal = build(settings, bare, self.problems)
        replaced = pruned(as_plain(nominal), calibration.replaced)
        return replace(calibration, replaced=replaced), nominal

    def _calibration(self, device: str, node: Node | None) -> Calibration | None:
        """Return what was laid over a device, now or when a resolved profile was written."""
        if node is None or node.value is None or isinstance(node.value, bool):
            return self._calibrations.get(device)
        if not isinstance(node.value, dict):
            if node.value is not BROKEN:
                self.problems.add(
                    node.mark, f"calibration is {shown(node.plain())}, expected true or false"
                )
            return None
        items = dict(node.value)
        provenance = items.pop("provenance", None)
        file = items.pop("file", None)
        replaced = items.pop("replaced", None)
        deviations = items.pop("deviations", None)
        for key, extra in items.items():
            hint = nearest(key, ("file", "provenance", "replaced"))
            self.problems.add(extra.heading, f"unknown key {key!r}", hint)
        if file is None or provenance is None or not isinstance(file.value, str):
            self.problems.add(node.heading, "a resolved calibration has file and provenance")
            return None
        read = read_provenance(provenance, self.problems)
        if read is None:
            return None
        before = {} if replaced is None else replaced.plain()
        known = {} if deviations is None else deviations.plain()
        return Calibration(
            file.value, read, before if isinstance(before, dict) else {},
            {name: float(std) for name, std in known.items() if isinstance(std, int | float)}
            if isinstance(known, dict) else {},
        )  # fmt: skip

    def _simulation(self, names: tuple[str, ...]) -> SimulationSettings | None:
        node = self.take("simulation")
        if node is None:
            return SimulationSettings()
        simulation = build(SimulationSettings, node, self.problems)
        faults = node.get("faults") if isinstance(node.value, dict) else None
        listed = faults.value if faults is not None and isinstance(faults.value, list) else ()
        for fault in listed:  # also those of a section that is wrong elsewhere
            place = fault.get("device") if isinstance(fault.value, dict) else None
            if place is not None and isinstance(place.value, str) and place.value not in names:
                self.problems.add(
                    place.mark,
                    f"no device or bus is called {shown(place.value)}",
                    f"{nearest(place.value, names)}; {_AS_LISTED}",
                )
        return simulation


_AS_LISTED = "`rig faults list RIG` says what to write here for each of its faults"


def _parted(entry: Node) -> tuple[dict[str, Node], Node]:
    """Part a device's entry into what every device says, and its driver's settings."""
    items = entry.value if isinstance(entry.value, dict) else {}
    common = {key: node for key, node in items.items() if key in COMMON_KEYS}
    own = {key: node for key, node in items.items() if key not in COMMON_KEYS}
    return common, entry.with_items(own)
