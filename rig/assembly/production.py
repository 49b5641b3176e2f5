"""From a profile's entries to production drivers, mechanism, controller and motion."""

from collections.abc import Callable, Mapping
from typing import Any

from controllers.base import AnyLaw, PlanningLaw
from controllers.motion import InfeasibleMotion, LongMotion, check_length
from rig.assembly.answers import check_motion
from rig.assembly.contract_check import check_offers, make
from rig.assembly.registry import REGISTRY
from rig.config import Profile
from rig.config.named_settings import controller_key, controller_names
from rig.hal import (
    Clock,
    ConfigurationError,
    ContractBroken,
    CyclicBus,
    Device,
    EmergencyStopInput,
    Mechanism,
    MotionRefused,
    SeveralErrors,
)
from rig.hal.fits import where
from rig.hal.motion import Motion
from rig.kernel_cache import check_compiler

_LONGEST_STOP = 60.0
"""No rig takes longer to come to rest, s: a stop that never ends would keep it energised."""


def make_devices(
    profile: Profile,
    buses: Mapping[str, CyclicBus],
    clock: Clock,
    links: Mapping[str, Any] | None = None,
) -> dict[str, Device]:
    """Make the production driver of every device.

    Parameters
    ----------
    profile : Profile
        What the rig is.
    buses : mapping
        By name.
    clock : Clock
        The rig's, for devices that hang on no bus.
    links : mapping, optional
        What stands in for the hardware of such a device, by its name.

    Raises
    ------
    ConfigurationError
        A device needs a bus and has none, or has one and takes none.
    """
    devices: dict[str, Device] = {}
    misplaced: list[str] = []
    for name, entry in profile.devices.items():
        driver = REGISTRY.load("driver", entry.driver)
        what = f"{name}: the driver {entry.driver}"
        needs_bus = REGISTRY.driver(entry.driver).on_bus
        if needs_bus != (entry.bus is not None):
            misplaced.append(f"{what} {'needs a bus' if needs_bus else 'hangs on no bus'}")
            continue
        if entry.bus is not None:
            bus = buses[entry.bus]
            devices[name] = make(what, driver, name, entry.settings, bus, serial=entry.serial)
        else:
            link = {"link": links[name]} if links and name in links else {}
            devices[name] = make(
                what, driver, name, entry.settings, clock, serial=entry.serial, **link
            )
        check_offers(what, devices[name], Device)
    SeveralErrors.raise_if_any(misplaced)
    return devices


def make_mechanism(profile: Profile, devices: Mapping[str, Device]) -> Any:
    """Make the loop's view of the rig."""
    view = REGISTRY.load("mechanism", profile.mechanism)
    mechanism = view.assemble(profile.mechanism_settings, devices, profile.loop.period)
    what = f"the mechanism {profile.mechanism}"
    check_offers(what, mechanism, Mechanism)
    for name in ("stopping_time", "venting_time"):
        time = getattr(mechanism, name)
        if not 0.0 <= time <= _LONGEST_STOP:
            raise ContractBroken(
                f"{what}: {where(type(mechanism))}.{name} is {time:g} s, and "
                f"not between 0 and {_LONGEST_STOP:g} s"
            )
    stop = mechanism.stop_input()
    if stop is not None:
        check_offers(f"{what}: its stop_input", stop, EmergencyStopInput)
        if stop.no_contact:  # it would read pressed for ever
            raise ConfigurationError(
                f"{profile.mechanism}.emergency_stop: {stop.name} reads no contact; give "
                f"devices.{stop.name}.{stop.no_contact}, where the contact is wired to, or leave "
                "emergency_stop out, if the rig has none"
            )
    return mechanism


def controller_class(profile: Profile, name: str) -> Callable[..., AnyLaw]:
    """Return the class of a controller that the profile has settings for; nothing is made.

    Raises
    ------
    ConfigurationError
        The profile has no settings for it.
    """
    if name not in profile.controllers:
        entry = f"; with its own gains: --set 'controllers.{name}={{}}'"
        raise ConfigurationError(
            f"the profile {profile.name} has no controller {name!r}; "
            f"it has {', '.join(profile.controllers)}"
            f"{entry if name in controller_names(REGISTRY, profile.mechanism) else ''}"
        )
    key = controller_key(REGISTRY, profile.mechanism, name)
    found: Callable[..., AnyLaw] = REGISTRY.load("controller", key)
    return found


def make_controller(profile: Profile, name: str) -> Any:
    """Make a controller that a loop can run: `make_law`, compiled.

    Raises
    ------
    ConfigurationError
        As `make_law`, or numba is told to compile nothing.
    MotionRefused
        As `make_law`.
    """
    check_compiler()
    made = make_law(profile, name)
    made.compile()
    return made


def make_law(profile: Profile, name: str) -> Any:
    """Make a controller with the profile's settings, for the profile's mechanism.

    It is not compiled: what is asked about its loop takes no compiler, whose import alone takes
    longer than the answer.

    Raises
    ------
    ConfigurationError
        The profile has no settings for it.
    MotionRefused
        It cannot be had here: a package that it needs is not installed, or the rig's settings
        leave it no room.
    """
    controller = controller_class(profile, name)
    view = REGISTRY.load("mechanism", profile.mechanism)
    try:
        model = view.model_of(profile.mechanism_settings)
    except ValueError as error:  # settings that are each right do not go together
        raise MotionRefused(str(error)) from error
    what = f"the controller {name} of a {profile.mechanism}"
    try:
        made = make(what, controller, profile.controllers[name], model, profile.loop.period)
    except InfeasibleMotion as error:
        raise MotionRefused(str(error)) from error
    check_offers(what, made, view.law)
    if isinstance(made, PlanningLaw):
        made.longest = profile.loop.longest_motion
    return made


def plan_motion(profile: Profile, reference: Any, controller: Any) -> Motion[Any]:
    """Turn an experiment's reference into a motion of the profile's mechanism.

    Raises
    ------
    MotionRefused
        The rig cannot or must not move so.
    """
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    longest = profile.loop.longest_motion
    what = f"the motion that the mechanism {profile.mechanism} has planned"
    try:
        if Motion in type(reference).__mro__:
            check_length(reference.duration, longest)
        motion: Motion[object] = mechanism.plan(
            profile.mechanism_settings, reference, controller, profile.loop.period
        )
        check_motion(what, motion, profile.loop.period)
        check_length(motion.duration, longest)
    except LongMotion as error:
        raise MotionRefused(
            f"{str(error).removesuffix('.')} (loop.longest_motion of the profile)."
        ) from error
    except ValueError as error:
        raise MotionRefused(str(error)) from error
    bounds = [entry.settings.axis_bounds() for entry in profile.devices.values()]
    beyond = mechanism.beyond_drives(
        profile.mechanism_settings,
        motion,
        {axis: bound for axes in bounds for axis, bound in axes.items()},
        profile.loop.period,
    )
    if beyond is not None:
        raise MotionRefused(beyond)
    return motion
