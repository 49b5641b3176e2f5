"""Gains in force beside those before them, on a loop that was measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY, controller_class, make_law
from rig.calibration.store import Content, history, in_force, load, write
from rig.config import Profile, load_profile
from rig.config.laid_over import TUNED
from rig.config.ownership import owner_label
from rig.hal import ConfigurationError
from rig.hal.measured_loop import MeasuredLoop
from rig.report.data import RunData, load_run
from rig.sweeping.code import code_version
from rig.tuning.gains import nested, values_of, with_gains
from rig.tuning.score import SENSITIVITY

_HOLDS = 365.0
"""Days after which gains should be looked at again."""


class Former(NamedTuple):
    """The gains that were in force before those that `rig tune` has found.

    Parameters
    ----------
    settings : object
        Of the law.
    what : str
        Which they are, in words.
    """

    settings: object
    what: str


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
        raise ConfigurationError(
            f"the loop of a {profile.mechanism} cannot be measured: its row names no "
            "`measured_loop`; what the linear model says of it is printed by `rig check`"
        )
    return found


def former_gains(
    profile: Profile, controller: str, search: Sequence[Path], overrides: Sequence[str]
) -> Former | None:
    """Return the gains before those that were tuned; None if none were."""
    now = profile.tunings.get(controller)
    if now is None:
        return None
    kept = [load(path) for path in history(search, profile.name, f"{TUNED}{controller}")]
    earlier = [one for one in kept if one["provenance"]["date"] < now.provenance.date]
    own = load_profile(profile.argument, REGISTRY, (*overrides, "calibration=false"), search)
    if not earlier:
        return Former(own.controllers[controller], "the profile's own")
    latest = max(earlier, key=lambda one: one["provenance"]["date"])
    settings = with_gains(own.controllers[controller], _flat(latest["values"]))
    return Former(settings, f"those of {latest['provenance']['date']}")


def _flat(values: Mapping[str, object], above: str = "") -> dict[str, float]:
    """Return gains by their keys with dots, as `nested` has taken them apart."""
    found: dict[str, float] = {}
    for name, value in values.items():
        found |= _flat(value, f"{above}{name}.") if isinstance(value, Mapping) else {
            f"{above}{name}": float(str(value))
        }  # fmt: skip
    return found


def put_back(
    profile: Profile,
    controller: str,
    former: Former,
    search: Sequence[Path],
    *,
    why: str,
    operator: str,
) -> Path:
    """Put former gains in force again; those that were in force stay among the kept ones.

    Raises
    ------
    ConfigurationError
        The file cannot be written.
    """
    target = f"{TUNED}{controller}"
    old = in_force(profile, search, target)
    assert old is not None
    moment = datetime.now(UTC)
    tunables = getattr(controller_class(profile, controller), "tunables", ())
    gains = values_of(tunables, former.settings)
    content: Content = {
        "values": nested(gains),
        "measured": [
            {"name": name, "value": gain, "unit": "", "std": 0.0, "interval": [gain, gain],
             "procedure": "margins"}
            for name, gain in gains.items()
        ],
        "provenance": {
            **old["provenance"],
            "procedure": "margins",
            "date": moment.isoformat(timespec="seconds"),
            "operator": operator,
            "profile": owner_label(profile.files, search),
            "parent": old["provenance"]["date"],
            "valid_until": (moment + timedelta(days=_HOLDS)).date().isoformat(),
            "software": f"rig-controller {metadata.version('rig-controller')}",
            "conditions": {"put back": f"{former.what}: {why}", "code": code_version().digest},
        },
    }  # fmt: skip
    return write(search[0], profile.name, target, content, "margins")
