"""Gains in force beside those before them, on a loop that was measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY, make_law
from rig.calibration.put_back import restore, take_back
from rig.calibration.store import history, load
from rig.config import Profile, load_profile
from rig.config.laid_over import TUNED
from rig.config.ownership import owner_label
from rig.hal import ConfigurationError
from rig.hal.closed_loop import SENSITIVITY
from rig.hal.measured_loop import MeasuredLoop
from rig.report.data import RunData, load_run
from rig.tuning.gains import with_gains


class Former(NamedTuple):
    """The gains that were in force before those that `rig tune` has found.

    Parameters
    ----------
    settings : object
        Of the law.
    what : str
        Which they are, in words.
    kept : Path or None
        The file that keeps them; None: the profile has them.
    """

    settings: object
    what: str
    kept: Path | None


class LoopsBeside(NamedTuple):
    """The loop of the gains in force, and of those before them, around one rig.

    Parameters
    ----------
    now : MeasuredLoop
        With the gains in force.
    before : MeasuredLoop or None
        With those before them; None: what is in force was not tuned.
    former : Former or None
        Those.
    """

    now: MeasuredLoop
    before: MeasuredLoop | None
    former: Former | None

    @property
    def is_worse(self) -> bool:
        """Whether what was tuned is nearer to instability than before, and than is asked for.

        By more than either is known to: what scatters takes no gains away.
        """
        if self.before is None or self.now.margins.sensitivity <= SENSITIVITY:
            return False
        least, most = self.now.interval("sensitivity")[0], self.before.interval("sensitivity")[1]
        return least > most


def measured_beside(
    run: Path,
    profile: Profile,
    controller: str,
    search: Sequence[Path],
    overrides: Sequence[str],
) -> LoopsBeside:
    """Return the loops that a run tells of.

    Parameters
    ----------
    run : Path
        A run of the mechanism's experiment of margins.
    profile : Profile
        Of the rig, with the gains in force.
    controller : str
        The law.
    search : sequence of Path
        The folders of configurations.
    overrides : sequence of str
        Options of the profile.

    Raises
    ------
    ConfigurationError
        The run does not tell it.
    """
    tell = loop_teller(profile)
    data = load_run(run)
    former = former_gains(profile, controller, search, overrides)
    before = None
    if former is not None:
        settings = {**profile.controllers, controller: former.settings}
        before = tell(data, make_law(replace(profile, controllers=settings), controller))
    return LoopsBeside(tell(data, make_law(profile, controller)), before, former)


def loop_teller(profile: Profile) -> Callable[[RunData, object], MeasuredLoop]:
    """Return what tells a loop of a profile's mechanism from a run.

    Raises
    ------
    ConfigurationError
        Its loops cannot be measured.
    """
    found = REGISTRY.measured_loop(profile.mechanism)
    if found is None:
        rig = profile.argument
        other = f"how well its laws follow is told by `rig compare EXPERIMENT --rig {rig}`"
        if REGISTRY.bench(profile.mechanism) is not None:
            other = (
                f"what a linear model says of them, as calibrated, is printed by `rig status {rig}`"
                f", and which plants its gains bear by `rig tune {rig} --dry-run`"
            )
        raise ConfigurationError(
            f"the loops of {profile.mechanism} cannot be measured: nothing is known that shakes "
            f"one of them alone (its row names no `measured_loop`); {other}"
        )
    return found


def former_gains(
    profile: Profile, controller: str, search: Sequence[Path], overrides: Sequence[str]
) -> Former | None:
    """Return the gains before those that were tuned; None if none were."""
    now = profile.tunings.get(controller)
    if now is None:
        return None
    own = load_profile(profile.argument, REGISTRY, (*overrides, "calibration=false"), search)
    parent = now.provenance.parent
    for path in history(search, profile.name, f"{TUNED}{controller}") if parent else ():
        kept = load(path)
        if kept["provenance"]["date"] == parent:
            settings = with_gains(own.controllers[controller], _flat(kept["values"]))
            return Former(settings, f"those of {parent}", path)
    return Former(own.controllers[controller], "the profile's own", None)


def _flat(values: Mapping[str, object], above: str = "") -> dict[str, float]:
    """Return gains by their keys with dots, as `nested` has taken them apart."""
    found: dict[str, float] = {}
    for name, value in values.items():
        found |= _flat(value, f"{above}{name}.") if isinstance(value, Mapping) else {
            f"{above}{name}": float(str(value))
        }  # fmt: skip
    return found


def put_back(profile: Profile, controller: str, former: Former, search: Sequence[Path]) -> Path:
    """Put former gains in force again; those that were in force stay among the kept ones.

    Raises
    ------
    ConfigurationError
        The file cannot be written.
    """
    target = f"{TUNED}{controller}"
    if former.kept is None:
        return take_back(search, profile.name, target)
    owner = owner_label(profile.files, search)
    return restore(search, profile.name, target, former.kept.stem, owner)
