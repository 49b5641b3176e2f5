"""The first motion, under the limits of a rig that was never commissioned."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rig.assembly import Rig, check_profile, make_controller, plan_motion
from rig.commissioning.derating import derated
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult, require_within
from rig.config import Experiment, Profile, ReferenceEntry, format_quantity
from rig.experiment.watcher import Watcher
from rig.hal.motion import Motion
from rig.run_facts import RunStatus
from rig.runtime.phases import Phase

if TYPE_CHECKING:
    from rig.experiment.plan import Plan

_TUNED = "; if the rig swung, its gains are too high for it: `rig tune` looks for others"
"""What a fault of the first motion may have come from, beside the rig."""


class Moved(NamedTuple):
    """The way that a first motion goes.

    Parameters
    ----------
    columns : sequence of str
        Of the log, where the motion is seen.
    travel, unit : float, str
        How far they go, and its SI unit.
    all : bool
        Each of them goes that far; else the one that goes furthest.
    """

    columns: Sequence[str]
    travel: float
    unit: str
    all: bool = False


class Planned(NamedTuple):
    """A motion with whoever follows it.

    Parameters
    ----------
    reference : ReferenceEntry
        Name and settings of what is followed.
    law : str
        Its name in the profile.
    controller, motion : Controller, Motion
        As the loop takes them.
    """

    reference: ReferenceEntry
    law: str
    controller: Any
    motion: Motion[object]


class _Prepares(Watcher):
    """Does what there is to do once the rig of a run has been built."""

    def __init__(self, prepare: Callable[[Rig], None]) -> None:
        self._prepare = prepare

    def built(self, rig: Rig) -> None:
        """See `Watcher.built`."""
        self._prepare(rig)


class FirstMotion(AcceptanceStep):
    """A small motion under control.

    Parameters
    ----------
    moved : Moved
        How far it goes.
    plan : callable
        ``plan(profile)`` returns how, as `Planned`.
    prepare : callable, optional
        ``prepare(site, rig)`` is done before the rig is connected.
    prepared : callable, optional
        ``prepared(site)`` returns the site's profile for it: as far as that can be used before any
        calibration, and with gains for it; by default as it is.
    strays : callable, optional
        ``strays(site)`` returns how far beyond either end of its way the rig may go, SI: twice its
        way is permitted anyhow. Seals that let go slide on until late regulators have taken their
        pressure back, whatever the law.
    """

    name = "first-motion"
    expects = (
        "It goes as far as it is sent, and comes to rest; with law, log and setpoints the computer "
        "wakes up in time, and no bus is too full or loses a frame."
    )

    def __init__(
        self,
        moved: Moved,
        plan: Callable[[Profile], Planned],
        prepare: Callable[[Site, Rig], None] = lambda site, rig: None,
        prepared: Callable[[Site], Profile] = lambda site: site.profile,
        strays: Callable[[Site], float] = lambda site: 0.0,
    ) -> None:
        way = format_quantity(moved.travel, moved.unit)
        each = "each axis of it " if moved.all else ""
        self.does = f"The rig is energised and {each}moves by {way} under control."
        self._moved = moved
        self._plan_motion = plan
        self._prepare = prepare
        self._prepared = prepared
        self._strays = strays

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        # Commands that perform no step ask which there are, and this is slow to import.
        from rig.commissioning.steps.under_load import judge_load
        from rig.experiment.ending import EXIT_INTERRUPTED
        from rig.experiment.run import run_experiment
        from rig.runtime.log import read_log

        rig = site.make_rig(site.profile)
        rig.close()
        result = run_experiment(
            self._plan(site), rig.backend, site.out, on=site.on, report=False,
            heed_calibrations=False, watcher=_Prepares(partial(self._prepare, site)),
        )  # fmt: skip
        if result.exit_code == EXIT_INTERRUPTED:  # which says nothing about the rig
            raise KeyboardInterrupt
        if result.status is not RunStatus.OK:
            raise Defect("first motion", f"{result.status}: {result.message}{_TUNED}")
        log = read_log(result.path / "log.mcap")
        runs = log.column("phase") == Phase.RUN
        columns, travel, unit, each = self._moved
        paths = {name: log.column(name)[runs] for name in columns}
        went = {name: float(path.max() - path.min()) for name, path in paths.items()}
        judged = went if each else {"": max(went.values())}
        farthest = travel + max(travel, 2.0 * self._strays(site))  # on either side
        measured = []
        for name, way in judged.items():
            what = " ".join(("moved by", name.removeprefix("reading."))).strip()
            moved = MeasuredValue(what, way, unit, 0.5 * travel, farthest)
            why = f"it does not go as far as it was sent{_TUNED}"
            measured.append(require_within("first motion", moved, why))
        measured += judge_load(rig.profile, result.path, log)
        return StepResult(tuple(measured), {"run": str(result.path)})

    def _plan(self, site: Site) -> "Plan":
        from rig.experiment.plan import Plan

        profile = derated(self._prepared(site), is_first=True)
        check_profile(profile)
        planned = self._plan_motion(profile)
        experiment = Experiment(
            name="commission-first-motion",
            description="the first motion of the acceptance test",
            rig=profile.name,
            controller=planned.law,
            reference=planned.reference,
            approach=5.0,
            metrics={},
            figures=(),
        )
        return Plan(experiment, profile, planned.controller, planned.motion)


def by_law(kind: str, reference: object, wanted: str = "") -> Callable[[Profile], Planned]:
    """Return what has a law of the profile follow a reference.

    Parameters
    ----------
    kind, reference : str, object
        Name and settings of the reference.
    wanted : str, optional
        Name of the law; default: the profile's first one.
    """

    def plan(profile: Profile) -> Planned:
        law = wanted or next(iter(profile.controllers))
        controller = make_controller(profile, law)
        motion = plan_motion(profile, reference, controller)
        return Planned(ReferenceEntry(kind, reference), law, controller, motion)

    return plan
