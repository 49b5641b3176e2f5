"""How far the loop of a law is from instability, and what of it keeps hardware from running."""

from collections.abc import Callable

from rig.assembly import REGISTRY, controller_class
from rig.assembly.contract_check import ask
from rig.config import Profile
from rig.experiment.plan import Plan
from rig.hal import DeviceError, Mechanism
from rig.hal.closed_loop import ClosedLoop


def loop_of(profile: Profile, controller: object) -> ClosedLoop | None:
    """Return the margins of the loop that a controller closes; None: nothing is known of it."""
    view = REGISTRY.load("mechanism", profile.mechanism)
    what = f"the mechanism {profile.mechanism}"
    loop = ask(what, Mechanism, "closed_loop", view, profile.mechanism_settings, controller)
    return loop if isinstance(loop, ClosedLoop) else None


def advice_on(profile: Profile, controller: str, loop: ClosedLoop) -> str | None:
    """Return what is wrong with a loop, and what would mend it; None: nothing is wrong.

    Parameters
    ----------
    profile : Profile
        Of the rig.
    controller : str
        The law's name, as in `profile.controllers`.
    loop : ClosedLoop
        What `loop_of` says of it.
    """
    if loop.is_robust:
        return None
    how = f"has a sensitivity of {loop.sensitivity:.2g}, above 2" if loop.stable else (
        "is stable by friction only"
    )  # fmt: skip
    said = f"the loop of {controller} {how}"
    law = controller_class(profile, controller)
    if REGISTRY.bench(profile.mechanism) is None or not getattr(law, "tunables", ()):
        return said
    tune = f"`rig tune {profile.argument} --controller {controller}`"
    return f"{said}: {tune} looks for gains that bear this rig"


def refuse_small_margin(plan: Plan, say: Callable[[str], None]) -> None:
    """Refuse a loop that is near to instability, or say why the profile accepts it.

    Raises
    ------
    DeviceError
        The loop is not robust, and ``loop.small_margin`` gives no reason to run it.
    """
    profile = plan.profile
    loop = loop_of(profile, plan.controller)
    wrong = None if loop is None else advice_on(profile, plan.experiment.controller, loop)
    if wrong is None:
        return
    reason = profile.loop.small_margin
    if reason is None:
        how = "--set 'loop.small_margin=REASON'"
        raise DeviceError(
            profile.name, f"{wrong}; hardware runs it only if a reason is given: {how}"
        )
    say(f"{wrong}; it runs all the same: {reason}")
