"""Whether a run on hardware may use all that its profile permits: asked before it is opened."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY, Backend, check_profile, make_controller
from rig.commissioning.derating import EFFORT, SPEED, SlowMotion, derated
from rig.commissioning.record import Verdict, judge, load_record
from rig.commissioning.step import Step
from rig.config import find_configs
from rig.experiment.plan import Plan
from rig.hal import DeviceError


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
    DeviceError
        Nobody knows limits for slow motions of the mechanism.
    """
    verdict = verdict_of(plan, backend)
    said = [f"commissioning {verdict.digest}"] if verdict.digest else []
    if backend is not Backend.HARDWARE:
        return Permitted(plan, said)
    if not verdict.lack:
        return Permitted(plan, said)
    remedy = f"mend it with: rig commission {plan.profile.name} --on hardware"
    if override is not None:
        why = f"{verdict.lack}; all of the speed and the effort is used all the same: {override}"
        return Permitted(plan, [*said, why])
    share = f"{SPEED:g} of the speed and {EFFORT:g} of pressure and torque are used"
    return Permitted(_held_back(plan), [*said, f"{verdict.lack}; {share}; {remedy}"])


def verdict_of(plan: Plan, backend: Backend) -> Verdict:
    """Return whether the rig of a plan is commissioned on a backend."""
    profile = plan.profile
    steps = REGISTRY.commissioning(profile.mechanism, Step)
    record = load_record(profile.name, configs_of(plan))
    return judge(profile, record, [step.name for step in steps], backend.value)


def configs_of(plan: Plan) -> list[Path]:
    """Return the folders of configurations of a plan, that of its profile first."""
    files = plan.profile.files
    own = [files[0].parent.parent] if files and files[0].parent.name == "rigs" else []
    return [*own, *find_configs()]


def _held_back(plan: Plan) -> Plan:
    """Return a plan with a share of its speed and its effort."""
    profile = derated(plan.profile)
    check_profile(profile)
    motion = plan.motion
    if motion.foreseen is not motion:
        raise DeviceError(
            profile.name,
            "it is not commissioned, and this motion depends on what is measured: it cannot be "
            f"slowed down; mend it with: rig commission {profile.name} --on hardware",
        )
    view = REGISTRY.load("mechanism", profile.mechanism)
    controller = make_controller(profile, plan.experiment.controller)
    return plan._replace(profile=profile, controller=controller, motion=SlowMotion(view, motion))
