"""What a rig has that may break, as a short run without faults shows it."""

import contextlib
import math
import signal
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

from rig.assembly import REGISTRY, Backend, Rig
from rig.calibration.catalogue import procedures
from rig.calibration.recording import RigLacks
from rig.config import Profile, find_configs, find_file, list_files, load_profile
from rig.config.document import name_under, plain_under
from rig.config.experiment import rig_of
from rig.config.names import is_path
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.experiment.watcher import Watcher
from rig.faults.stage import PausableClock
from rig.faults.subject import Subject, frames_in
from rig.hal import ConfigurationError
from rig.hal.hazards import ENERGY_LEFT, Hazard
from rig.runtime.states import RigState


class _Look(Watcher):
    """Looks at a rig when it is energised, and has the run end there."""

    connecting = 0.0
    rig: Rig

    def built(self, rig: Rig) -> None:
        """Take note of the rig."""
        self.rig = rig

    def moved(self, state: RigState, t: float | None) -> None:
        """Take note of how long it took to connect, and of who sends what now."""
        if state is RigState.RUNNING:
            clock = cast("PausableClock", self.rig.clock)
            self.connecting = clock.now()
            self.knows = dict(clock.world.known_faults)
            self.frames = frames_in(clock.world)
            self.plant_channels = clock.world.plant.channel_names
            for _ in range(2):
                signal.raise_signal(signal.SIGINT)


def experiments_of(rig: str, configs: Path | None, *, any_world: bool = False) -> tuple[str, ...]:
    """Return the experiments whose rig this is, or else those of rigs with its plant, by name.

    Parameters
    ----------
    rig : str
        A name, or the path of a file: then also the experiments beside that file that name it.
    configs : Path or None
        The folder of configurations.
    any_world : bool
        If there is none, take those of rigs with its mechanism: enough to look at what it has,
        not to break it in.

    Raises
    ------
    ConfigurationError
        There is none.
    """
    search = find_configs(configs)
    find_file(rig, "rigs", search)  # an unknown rig is not one without experiments
    if is_path(rig):  # as another one that extends it or a base of it would be run
        base = name_under("extends", rig, "rigs", search)
        of = rig if base is None else base
        return _running_on(of, configs, rig, any_world=any_world)
    return _running_on(rig, configs, rig, any_world=any_world)


def _beside(asked: Path) -> tuple[str, ...]:
    """Return the experiments in the folder of a profile that name its file as their rig."""
    found = []
    for path in sorted(asked.parent.glob("*.yaml")):
        own = None
        with contextlib.suppress(ConfigurationError):  # one that is no YAML is nobody's
            is_scenario = plain_under("fault", path, "experiments") is not None
            own = None if is_scenario else rig_of(path)
        if own is not None and is_path(own) and Path(own).resolve() == asked.resolve():
            found.append(str(path))
    return tuple(found)


def _running_on(rig: str, configs: Path | None, asked: str, *, any_world: bool) -> tuple[str, ...]:
    search = find_configs(configs)
    # Their files are read and no more: of what other rigs name nothing runs.
    rigs = {name: rig_of(name, search) for name in list_files("experiments", search)}
    found = tuple(name for name, own in rigs.items() if own == rig)
    if not found:  # then what another rig does that has the same mechanism in the same world
        load_profile(rig, REGISTRY, [], search)  # what is wrong with it is said first

        def world_of(name: str) -> list[object]:
            return [plain_under(key, name, "rigs", search) for key in ("mechanism", "plant")]

        named = {own for own in rigs.values() if own is not None}
        alike = {own for own in named if world_of(own) == world_of(rig)}
        found = tuple(name for name, own in rigs.items() if own in alike)
    if not found and is_path(asked):
        found = _beside(Path(asked))
    if not found and any_world:
        kind = plain_under("mechanism", rig, "rigs", search)
        named = {own for own in rigs.values() if own is not None}
        alike = {own for own in named if plain_under("mechanism", own, "rigs", search) == kind}
        found = tuple(name for name, own in rigs.items() if own in alike)
    if not found:
        raise ConfigurationError(
            f"no experiment runs on {asked}: nothing to break it in; say one with --experiment NAME"
        )
    return found


def survey(
    rig: str, experiments: tuple[str, ...], configs: Path | None, *, chosen: bool = False
) -> Subject:
    """Return what a rig has that may break.

    Raises
    ------
    ConfigurationError
        Its plant says of no hazard when a rig is in danger, or it does not run at all.
    """
    profile = load_profile(rig, REGISTRY, [], find_configs(configs))
    if profile.plant is None:
        raise ConfigurationError(f"{rig} has no plant, so nothing can be broken without harm")
    hazards = REGISTRY.hazards(profile.plant.model)
    if hazards is None:
        raise ConfigurationError(
            f"{rig}: nobody says what is a hazard for the plant {profile.plant.model}; name it in "
            "the mechanism's row (PlantModel.hazards)"
        )
    dangers = _checked(hazards(profile.mechanism_settings), profile.plant.model)
    look = _Look()
    with TemporaryDirectory() as out:
        plan = load_plan(experiments[0], rig=rig, configs=configs)
        result = run_experiment(plan, Backend.VIRTUAL, Path(out), watcher=look, report=False)
    if not look.connecting:
        raise ConfigurationError(f"{rig} does not run: {result.message}")
    settings = [entry.settings for entry in profile.devices.values()]
    kept = frozenset(channel for said in settings for channel in said.kept_channels())
    channels = {name: entry.settings.channel_names() for name, entry in profile.devices.items()}
    return Subject(
        rig=rig,
        experiments=experiments,
        period=profile.loop.period,
        channels={**channels, "plant": tuple(look.plant_channels)},
        knows=look.knows,
        frames=look.frames,
        on_bus={
            bus: tuple(name for name, entry in profile.devices.items() if entry.bus == bus)
            for bus in profile.buses
        },
        hazards=_but_kept(dangers, kept),
        connecting=look.connecting,
        reading_age=_reading_age(profile),
        base_pressure=getattr(profile.mechanism_settings, "base_pressure", math.inf),
        by_velocity=frozenset(
            name
            for name, entry in profile.devices.items()
            if entry.settings.holds_without_position()
        ),
        confirming={
            name: confirmed
            for name, entry in profile.devices.items()
            if any(confirmed := entry.settings.confirmed_bytes())
        },
        procedures=_procedures(profile),
        chosen=experiments if chosen else (),
        configs="" if configs is None else str(configs),
    )


def _procedures(profile: Profile) -> dict[str, float]:
    """Return how long those procedures take that move the rig, s."""
    found = {}
    for name, procedure in procedures(profile).items():
        with contextlib.suppress(RigLacks):
            excitation = procedure.excite(profile, ())
            if excitation is not None:
                found[name] = excitation.motion.duration
    return found


def _reading_age(profile: Profile) -> float:
    """Return for how long the loop bridges readings that do not come, s."""
    limits = REGISTRY.load("mechanism", profile.mechanism).limits_of(profile.mechanism_settings)
    least: float = 3.0 * profile.loop.period
    return float(getattr(limits, "reading_age", least))


def _but_kept(dangers: Sequence[Hazard], kept: frozenset[str]) -> tuple[Hazard, ...]:
    """Leave out the energy of chambers that are meant to keep it."""
    columns = {f"pressure_{channel}" for channel in kept}
    return tuple(
        danger._replace(columns=tuple(one for one in danger.columns if one not in columns))
        if danger.name == ENERGY_LEFT
        else danger
        for danger in dangers
    )


def _checked(hazards: object, plant: str) -> tuple[Hazard, ...]:
    """Return what a plant's `hazards` gave, if it is hazards."""
    found = hazards if isinstance(hazards, tuple) else (hazards,)
    for entry in found:
        if not isinstance(entry, Hazard):
            raise ConfigurationError(f"the hazards of the plant {plant} hold {entry!r}, no Hazard")
    return found
