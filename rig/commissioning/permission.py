"""Whether a run on hardware may use all that its profile permits: asked before it is opened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rig.assembly import REGISTRY, Backend, check_profile, make_controller
from rig.commissioning.derating import EFFORT, SPEED, SlowMotion, derated
from rig.commissioning.record import CommissioningState, judge, load_record, whose
from rig.commissioning.step import AcceptanceStep
from rig.config import Profile, find_configs
from rig.hal import ConfigurationError, DeviceError

if TYPE_CHECKING:
    from rig.experiment.plan import Plan


class Permitted(NamedTuple):
    """A plan as it may be carried out, and what there is to say of it.

    Parameters
    ----------
    plan : Plan
        As it was, or slower and weaker.
    sentences : sequence of str
        For the operator and the run's events.
    """

    plan: Plan
    sentences: Sequence[str] = ()


def as_commissioned(plan: Plan, backend: Backend, override: str | None = None) -> Permitted:
    """Return a plan as a rig may carry it out that is commissioned, or is not.

    Parameters
    ----------
    plan : Plan
        Checked.
    backend : Backend
        What it is to run on; in simulation nothing is held back.
    override : str, optional
        Why the operator wants all of it from a rig that is not commissioned.

    Raises
    ------
    ConfigurationError
        Its record is broken: no hardware moves by it, whatever the operator says.
    DeviceError
        Nobody knows limits for slow motions of the mechanism.
    """
    verdict = verdict_of(plan.profile, backend)
    said = [verdict.label] if verdict.label else []
    if backend is not Backend.HARDWARE:
        return Permitted(plan, [*said, verdict.trouble] if verdict.trouble else said)
    if verdict.trouble:
        raise ConfigurationError(verdict.trouble)
    if not verdict.lack:
        return Permitted(plan, said)
    remedy = f"mend it with: rig commission {plan.profile.argument} --on hardware"
    if override is not None:
        why = f"{verdict.lack}; all of the speed and the effort is used all the same: {override}"
        return Permitted(plan, [*said, why])
    share = f"{SPEED:g} of the speed and {EFFORT:g} of pressure and torque are used"
    return Permitted(_held_back(plan), [*said, f"{verdict.lack}; {share}; {remedy}"])


def refuse_uncommissioned(profile: Profile, override: str | None) -> str | None:
    """Refuse hardware that is not commissioned to what cannot be held back; return what to keep.

    Raises
    ------
    ConfigurationError
        Its record is broken.
    DeviceError
        It is not commissioned, and nobody said why it is to be used all the same.
    """
    verdict = verdict_of(profile, Backend.HARDWARE)
    if verdict.trouble:
        raise ConfigurationError(verdict.trouble)
    if not verdict.lack:
        return f"commissioning {verdict.digest}"
    if override is None:
        raise DeviceError(
            profile.name,
            f"{verdict.lack}; mend it with: rig commission {profile.argument} --on hardware, or "
            "say why it moves all the same with --uncommissioned REASON",
        )
    return f"{verdict.lack}; it moves all the same: {override}"


def verdict_of(
    profile: Profile, backend: Backend, search: Sequence[Path] | None = None
) -> CommissioningState:
    """Return whether a rig is commissioned on a backend; one with a broken record is not.

    Parameters
    ----------
    profile : Profile
        As it is now.
    backend : Backend
        Where it is to be used.
    search : sequence of Path, optional
        Folders of configurations; default: the profile's own, then the usual ones.
    """
    steps = REGISTRY.commissioning(profile.mechanism, AcceptanceStep)
    places = configs_of(profile) if search is None else search
    try:
        record = load_record(profile.name, places)
    except ConfigurationError as error:
        trouble = f"the record of its commissioning cannot be used: {error}"
        return CommissioningState("", trouble, trouble)
    other = whose(profile, record, [*configs_of(profile), *places])
    if other:
        lack = f"it was never commissioned: the record of its name belongs to another rig: {other}"
        return CommissioningState("", lack)
    return judge(profile, record, [step.name for step in steps], backend.value)


def configs_of(profile: Profile) -> list[Path]:
    """Return the folders in which records of a profile may be, in the order of commands.

    A profile of another folder has its own one first, and no record beside the program's profiles.
    """
    usual, files = find_configs(), profile.files
    folder = files[0].resolve().parent if files else None
    if folder is None or folder in [(at / "rigs").resolve() for at in usual]:
        return list(usual)
    return [folder.parent, usual[0]] if folder.name == "rigs" else [usual[0]]


def _held_back(plan: Plan) -> Plan:
    """Return a plan with a share of its speed and its effort."""
    profile = derated(plan.profile)
    check_profile(profile)
    motion = plan.motion
    if motion.foreseen is not motion:
        raise DeviceError(
            profile.name,
            "it is not commissioned, and this motion depends on what is measured: it cannot be "
            f"slowed down; mend it with: rig commission {profile.argument} --on hardware",
        )
    view = REGISTRY.load("mechanism", profile.mechanism)
    experiment = replace(plan.experiment, approach=plan.experiment.approach / SPEED)
    try:
        slowed = view.slowed(
            plan.profile.mechanism_settings, experiment.reference.settings, plan.controller,
            profile.loop.period, SPEED,
        )  # fmt: skip
    except ValueError as error:
        raise DeviceError(
            profile.name,
            f"it is not commissioned, and with {SPEED:g} of the speed: {error}; mend it with: "
            f"rig commission {profile.argument} --on hardware",
        ) from error
    if slowed is None:
        slowed = make_controller(profile, experiment.controller), SlowMotion(view, motion)
    controller, slow = slowed
    return plan._replace(experiment=experiment, profile=profile, motion=slow, controller=controller)
