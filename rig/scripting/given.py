"""Python objects in the place of what an experiment names: for trying things."""

import inspect
import types
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from rig.assembly import REGISTRY, plan_motion
from rig.assembly.contract_check import check_offers
from rig.config import Experiment, Profile, ReferenceEntry
from rig.config.models import MetricSpec
from rig.experiment.measure import Measure, Windows
from rig.experiment.plan import Plan
from rig.experiment.rehearsal import play_through
from rig.hal import ConfigurationError
from rig.hal.motion import Motion
from rig.scripting.played import PlanFunction, PlayedPlan

MOST = 600.0
"""A plan that takes longer is a fault, s."""


@dataclass(frozen=True, slots=True)
class GivenInPython:
    """What a run folder says of an object that was given: its name, and where its code is kept."""

    name: str
    source: str


@dataclass(frozen=True, slots=True)
class Given:
    """The Python objects of one run, each in the place of what the experiment names.

    Parameters
    ----------
    reference : object, optional
        An instance of a reference's settings (`rig.mechanisms.cylinder.references.Sine`), or of a
        class of your own that inherits the same base.
    plan : callable, optional
        ``def plan(rig): yield rig.move(…)``.
    controller : object, optional
        A controller, or a class of one, which gets its section of the profile or its defaults.
    measures : mapping of str to callable, optional
        ``measure(data)`` of the followed part of the log returns a number; ``(measure, "mm")``
        says its unit.
    """

    reference: object | None = None
    plan: PlanFunction | None = None
    controller: object | None = None
    measures: Mapping[str, object] | None = None

    def applied(self, plan: Plan, *, rehearse: bool, most: float = MOST) -> Plan:
        """Return the plan with these objects in it, checked.

        Parameters
        ----------
        plan : Plan
            As the experiment's file has it.
        rehearse : bool
            Go through a Python plan in simulation first.
        most : float
            A Python plan that takes longer is a fault, s.

        Raises
        ------
        ConfigurationError
            An object lacks something, or the motion is not possible or not permitted.
        """
        sources: dict[str, str] = {}
        experiment, profile = plan.experiment, plan.profile
        controller, motion = plan.controller, plan.motion
        if self.reference is not None and self.plan is not None:
            raise ConfigurationError("give a reference or a plan, not both")
        if self.controller is not None:
            controller = _controller(self.controller, plan)
            name = _keep(self.controller, sources)
            experiment = replace(experiment, controller=name)
            if self.reference is None and self.plan is None:
                motion = plan_motion(profile, experiment.reference.settings, controller)
        if self.reference is not None:
            motion = _motion(self.reference, profile, controller)
            experiment = _following(experiment, self.reference, motion, sources)
        if self.plan is not None:
            played = _played(self.plan, plan, controller, most, rehearsing=False)
            if rehearse:
                rehearsed = _played(self.plan, plan, controller, most, rehearsing=True)
                play_through(plan._replace(controller=controller, motion=rehearsed))
                played.known = rehearsed
            motion = played
            experiment = _following(experiment, self.plan, None, sources)
        measures = {
            name: _measure(name, given, sources) for name, given in (self.measures or {}).items()
        }
        wanted = {**experiment.metrics, **{name: MetricSpec() for name in measures}}
        experiment = replace(experiment, metrics=wanted)
        return Plan(experiment, profile, controller, motion, measures, sources)


def _played(
    play: PlanFunction, plan: Plan, controller: Any, most: float, *, rehearsing: bool
) -> PlayedPlan:
    if not callable(play):
        raise ConfigurationError(f"the plan is {play!r}, which is no function of the rig")
    view = REGISTRY.load("mechanism", plan.profile.mechanism)
    targets = view.targets(plan.profile.mechanism_settings, controller)
    if targets is None:
        raise ConfigurationError(
            f"a {plan.profile.mechanism} cannot be sent by numbers (its mechanism has no targets): "
            "give it a reference"
        )
    begin = plan.motion.at(0.0)
    start = view.approach(begin, begin, 1.0, 1.0)
    return PlayedPlan(play, targets, view.approach, start, most=most, rehearsing=rehearsing)


def _motion(reference: object, profile: Profile, controller: Any) -> Motion[Any]:
    if isinstance(reference, type):
        raise ConfigurationError(f"the reference is the class {reference.__name__}: make one of it")
    return plan_motion(profile, reference, controller)


def _following(
    experiment: Experiment, given: object, motion: Motion[Any] | None, sources: dict[str, str]
) -> Experiment:
    """Return an experiment that follows something else: its bounds were not made for that."""
    metrics = {
        name: replace(spec, max=None, min=None)
        for name, spec in experiment.metrics.items()
        if spec.segments == "*" and (motion is None or (spec.measure or name) not in motion.facts)
    }
    if motion is None:  # what a law has planned is not known of a plan in Python
        planned = REGISTRY.measures(None, Measure)
        metrics = {n: spec for n, spec in metrics.items() if (spec.measure or n) in planned}
    kept = _keep(given, sources)
    own = type(given)
    entry = given if is_dataclass(given) and not isinstance(given, type) else None
    return replace(
        experiment,
        name=kept if motion is None else experiment.name,
        reference=ReferenceEntry(
            "python" if entry is None else own.__name__.lower(),
            GivenInPython(kept, f"code/{kept}.py") if entry is None else entry,
        ),
        metrics=metrics,
    )


def _controller(given: object, plan: Plan) -> Any:
    """Return a controller, made if it is a class."""
    view = REGISTRY.load("mechanism", plan.profile.mechanism)
    made: Any = given
    if isinstance(given, type):
        kind: Any = given
        wanted = getattr(kind, "Settings", None)
        settings = next(
            (own for own in plan.profile.controllers.values() if type(own) is wanted), None
        )
        if settings is None and wanted is not None:
            try:
                settings = wanted()
            except TypeError as error:
                lacking = [f.name for f in fields(wanted)] if is_dataclass(wanted) else []
                raise ConfigurationError(
                    f"{kind.__name__}: its Settings ({', '.join(lacking)}) have no defaults, and "
                    f"{plan.profile.name} has no section for them"
                ) from error
        model = view.model_of(plan.profile.mechanism_settings)
        made = kind(settings, model, plan.profile.loop.period)
    check_offers(f"the controller {type(made).__name__}", made, view.law)
    made.compile()
    return made


def _measure(name: str, given: object, sources: dict[str, str]) -> Measure:
    """Return a function of a run's data as a measure."""
    function, unit = given if isinstance(given, tuple) and len(given) == 2 else (given, "")
    if not callable(function) or not isinstance(unit, str):
        raise ConfigurationError(
            f"measure {name}: {given!r} is neither a function of the data nor (function, unit)"
        )
    _keep(function, sources)

    def compute(windows: Windows) -> float:
        from rig.scripting.recorded import as_structured

        if not windows:
            raise ValueError("nothing was followed")
        log = windows[0].samples.log
        followed = as_structured(log)[log.column("phase") == 1.0]
        try:
            return float(function(followed))
        except Exception as error:
            raise ValueError(f"{type(error).__name__}: {error}") from error

    return Measure(compute, unit, inspect.getdoc(function) or f"{name}, given in Python")


def _keep(given: object, sources: dict[str, str]) -> str:
    """Keep the text of an object's code for the run folder; return the object's name."""
    named: Any = given if isinstance(given, type | types.FunctionType) else type(given)
    name = "".join(c if c.isalnum() else "-" for c in named.__name__).strip("-") or "given"
    try:
        file = inspect.getsourcefile(named)
        text = Path(file).read_text(encoding="utf-8") if file and Path(file).is_file() else ""
        text = text or inspect.getsource(named)
    except (OSError, TypeError):
        text = f"# {named!r}: its source cannot be had\n"
    sources[f"code/{name}.py"] = text
    return name
