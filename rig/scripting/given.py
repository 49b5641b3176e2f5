"""Python objects in the place of what an experiment names: for trying things."""

import contextlib
import inspect
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, is_dataclass, replace
from typing import TypeAlias, cast

from rig.assembly import REGISTRY, plan_motion
from rig.assembly.contract_check import check_offers, note_given, whose_bug
from rig.config import Experiment, Profile, ReferenceEntry
from rig.config.from_python import as_from_a_file
from rig.config.models import MetricSpec
from rig.config.quantities import USUAL_UNITS, UnitError, parse_unit
from rig.experiment.measure import Measure, Windows
from rig.experiment.plan import Plan
from rig.experiment.rehearsal import play_through
from rig.hal import ConfigurationError, ContractBroken, RigError
from rig.hal.controller import Law
from rig.hal.fits import shown
from rig.hal.motion import Motion
from rig.scripting.played import PlanFunction, PlayedPlan
from rig.scripting.sources import first_line_of, keep_source, line_of

AnyLaw: TypeAlias = Law[object, object, object]

MOST = 600.0
"""A plan that takes longer is a fault, s."""


@dataclass(frozen=True, slots=True)
class GivenInPython:
    """The name of an object that was given, and the place of its code in the run folder."""

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
        for thing in (self.reference, self.plan, self.controller):
            if thing is not None:
                note_given(thing)
        if self.reference is not None and self.plan is not None:
            raise ConfigurationError("give a reference or a plan, not both")
        if self.controller is not None:
            controller = _controller(self.controller, plan)
            name = keep_source(self.controller, sources)
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
        measures = {}
        wanted = dict(experiment.metrics)
        for name, measure in (self.measures or {}).items():
            if name in wanted:
                raise ConfigurationError(
                    f"measure {name}: {plan.experiment.name} has a metric of this name; choose "
                    f"another name than {', '.join(wanted)}"
                )
            made, source = _measure(name, measure, sources)
            measures[source] = made
            wanted[name] = MetricSpec(measure=source)
        experiment = replace(experiment, metrics=wanted)
        return Plan(experiment, profile, controller, motion, measures, sources)


@contextlib.contextmanager
def naming_theirs() -> Iterator[None]:
    """Turn what code of others raises before there is a run into a sentence that names it.

    Raises
    ------
    ContractBroken
        In the place of their exception, from it.
    """
    try:
        yield
    except RigError:
        raise
    except Exception as error:
        place = whose_bug(error)
        if place is None:
            raise
        raise ContractBroken(f"{place}: {type(error).__name__}: {error}") from error


def _played(
    play: PlanFunction, plan: Plan, controller: object, most: float, *, rehearsing: bool
) -> PlayedPlan:
    if not (isinstance(most, int | float) and 0.0 < most < math.inf):
        raise ConfigurationError(f"most is {most!r}, and must be a time above 0, s")
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


def _motion(reference: object, profile: Profile, controller: object) -> Motion[object]:
    if isinstance(reference, type):
        raise ConfigurationError(f"the reference is the class {reference.__name__}: make one of it")
    as_from_a_file(reference, f"reference={type(reference).__name__}(…)")
    return plan_motion(profile, reference, controller)


def _following(
    experiment: Experiment, given: object, motion: Motion[object] | None, sources: dict[str, str]
) -> Experiment:
    """Return an experiment that follows something else: its bounds were not made for that."""
    metrics = {
        name: replace(spec, max=None, min=None)
        for name, spec in experiment.metrics.items()
        if spec.segments == "*" and (motion is None or (spec.measure or name) not in motion.facts)
    }
    if motion is None or motion.watches:  # what a law would have planned is not known
        planned = REGISTRY.measures(None, Measure)
        metrics = {n: spec for n, spec in metrics.items() if (spec.measure or n) in planned}
    kept = keep_source(given, sources)
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


def _controller(given: object, plan: Plan) -> object:
    """Return a controller, made if it is a class."""
    profile = plan.profile
    view = REGISTRY.load("mechanism", profile.mechanism)
    made = given
    if isinstance(given, type):
        check_offers(f"the controller {given.__name__}", given, view.law)
        settings = _settings_for(cast("type[AnyLaw]", given), profile)
        model = view.model_of(profile.mechanism_settings)
        made = given(settings, model, profile.loop.period)
    check_offers(f"the controller {type(made).__name__}", made, view.law)
    cast("AnyLaw", made).compile()
    return made


def _settings_for(law: "type[AnyLaw]", profile: Profile) -> object:
    """Return the profile's section for a law, or the defaults of its settings."""
    for own in profile.controllers.values():
        if type(own) is law.Settings:
            return own
    try:
        return law.Settings()
    except TypeError as error:
        raise ConfigurationError(
            f"{law.__name__}: its Settings have no defaults, and {profile.name} has no section "
            f"for them ({error})"
        ) from error


def _measure(name: str, given: object, sources: dict[str, str]) -> tuple[Measure, str]:
    """Return a function of a run's data as a measure, and what it is called: no other is."""
    function, unit = given if isinstance(given, tuple) and len(given) == 2 else (given, "")
    if not callable(function) or not isinstance(unit, str):
        raise ConfigurationError(
            f"measure {name}: {given!r} is neither a function of the data nor (function, unit)"
        )
    try:
        parse_unit(unit)
    except UnitError as error:
        usual = ", ".join(USUAL_UNITS)
        raise ConfigurationError(f"measure {name}: {error}; usual units are {usual}") from error
    source = f"code/{keep_source(function, sources)}.py {name}"

    def compute(windows: Windows) -> float:
        from rig.scripting.recorded import as_structured

        if not windows:
            raise ValueError("nothing was followed")
        log = windows[0].samples.log
        followed = as_structured(log)[log.column("phase") == 1.0]
        try:
            value = function(followed)
        except (Exception, SystemExit) as error:  # nobody's measure ends the program
            what = f"measure {name}{line_of(error)}: {type(error).__name__}: {error}"
            raise ContractBroken(what) from error
        try:
            return float(value)
        except (TypeError, ValueError):
            what = f"measure {name}{first_line_of(function)} returned {shown(value)}, and no number"
            raise ContractBroken(what) from None

    described = inspect.getdoc(function) or f"{name}, given in Python"
    return Measure(compute, unit, described), source
