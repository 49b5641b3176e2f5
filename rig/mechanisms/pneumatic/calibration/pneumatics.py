"""What procedures need to know of a mechanism: its channels, devices and types."""

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rig.calibration.recording import Stretch
from rig.config import Profile

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


_SOFT = 0.3
_CALM = {"position_rate": 97.5, "velocity_rate": 344.0, "integral": 7.5e4}
"""Greatest gains of a joint's controller that slides its pairs: rad/s, rad/s and N/(m s)."""

_CALM_BASE = 120e3
"""Greatest base pressure under which a ring that leans is moved, Pa gauge: the more wires pull, the
faster it falls on, until no regulator can follow."""

_ABSENCE = 30.0
_SHRUNK = 0.9
"""For how long (s) a camera whose pose is wrong may see rays beside the marker's sphere, and how
much of its area a marker may lack or have too much: how it leans follows from that pose."""

_RESIDUAL = 8e-3
DISAGREEMENT = 60e-3
"""Of a joint's rods, and of its camera and rods, before they have been calibrated, m. Of a camera
half a metre away 2 degrees about every axis make 25 mm, and 2 % of all lengths as much again."""


class Pneumatics(NamedTuple):
    """A mechanism whose rods are pulled by pneumatic cylinders.

    Parameters
    ----------
    regulators : str
        The device.
    channels : tuple of str
        Its channels, in order.
    encoders : tuple of str
        The rods' encoders, in the order of the channels.
    lowest, highest : float
        Pressures that every chamber may have at once, Pa gauge.
    rods : str
        Start of the names of the log's columns of the rods.
    inwards : bool
        Whether these say how far a rod is pulled in from home, or how far it stands out.
    homes : tuple of float
        Extension of each rod at home as it is believed, m.
    """

    regulators: str
    channels: tuple[str, ...]
    encoders: tuple[str, ...]
    lowest: float
    highest: float
    rods: str
    inwards: bool
    homes: tuple[float, ...]

    def extension(self, stretch: Stretch, channel: str) -> "NDArray[np.float64]":
        """Return how far a rod stands out by its encoder, m, shape (n,)."""
        shown = stretch[f"{self.rods}_{channel}"]
        return self.homes[self.channels.index(channel)] - shown if self.inwards else shown


def pneumatics_of(profile: Profile) -> Pneumatics:
    """Return the pneumatic side of a ``cylinder`` or ``joint`` profile."""
    settings = profile.mechanism_settings
    low, high = settings.limits.pressure
    pair = profile.mechanism == "cylinder"
    if pair:
        encoders = (settings.encoder_agonist, settings.encoder_antagonist)
    else:
        encoders = tuple(settings.encoders)
        least, most = settings.limits.tension
        low, high = max(low, least / settings.area), min(high, most / settings.area)
    offsets = (0.0, 0.0) if pair else settings.wire_offsets
    span = high - low
    return Pneumatics(
        settings.regulators,
        tuple(profile.devices[settings.regulators].settings.channels),
        encoders,
        low + 0.06 * span,
        high - 0.08 * span,
        rods="reading.position" if pair else "reading.rod",
        inwards=not pair,
        homes=tuple(settings.home + offset for offset in offsets),
    )


def relaxed(profile: Profile, pair: float = 0.0) -> tuple[Profile, tuple[str, ...]]:
    """Return the profile without the bounds that rest on what is looked for, and notes on them.

    A joint's rods and camera agree on its pose only after all of them have been calibrated.

    Parameters
    ----------
    profile : Profile
        The rig's.
    pair : float
        By how much more than usual the two rods of a pair may disagree, m.
    """
    settings = profile.mechanism_settings
    usual = settings.limits
    if profile.mechanism == "cylinder":
        wanted = {"mismatch": usual.mismatch + pair}
    else:
        wanted = {
            "residual": max(usual.residual, _RESIDUAL),
            "disagreement": max(usual.disagreement, DISAGREEMENT),
        }
    changed = {name: value for name, value in wanted.items() if value != getattr(usual, name)}
    limits = dataclasses.replace(usual, **changed)
    notes = tuple(
        f"limits.{name} is {1e3 * value:g} mm instead of {1e3 * getattr(usual, name):g} mm: "
        "it rests on what is looked for"
        for name, value in changed.items()
    )
    mechanism = dataclasses.replace(settings, limits=limits)
    relaxed_profile = dataclasses.replace(profile, mechanism_settings=mechanism)
    if getattr(settings, "camera", None) is None:
        return relaxed_profile, notes
    patient, more = bear_with_camera(relaxed_profile, _ABSENCE)
    return patient, notes + more


def bear_with_camera(profile: Profile, absence: float) -> tuple[Profile, tuple[str, ...]]:
    """Return a joint's profile with a camera that may err about its marker, and notes on it.

    Parameters
    ----------
    profile : Profile
        The rig's.
    absence : float
        For how long the marker may be out of sight, s.
    """
    name = profile.mechanism_settings.camera
    entry = profile.devices[name]
    absence = max(entry.settings.max_absence, absence)
    shrunk = max(entry.settings.marker.area_tolerance, _SHRUNK)
    marker = dataclasses.replace(entry.settings.marker, area_tolerance=shrunk)
    patient = dataclasses.replace(entry.settings, max_absence=absence, marker=marker)
    devices = {**profile.devices, name: dataclasses.replace(entry, settings=patient)}
    return dataclasses.replace(profile, devices=devices), (
        f"{name}.max_absence is {absence:g} s: a wrong pose puts rays beside the sphere",
        f"{name}.marker.area_tolerance is {shrunk:g}: a wrong pose tells wrongly how it leans",
    )


def follower(profile: Profile) -> tuple[Profile, str]:
    """Return the profile with the controller that is to slide a joint's pairs, and its name.

    The ring sticks so much that only one that observes what holds it keeps it sliding; it does
    not heed a camera that nobody has calibrated. Whatever the profile's is tuned for, this is the
    one for standard seals, with the profile's gains where somebody has set them lower. As it is
    used it hunts with weaker seals: it lives on their viscous friction, and a ring that leans falls
    on by itself. With half the stiffness and a third of the integral they slide evenly if they
    have 0.6 to 1.4 times the friction, a few millimetres off their line; with less the ring gets
    away. Nor does it shake the ring, and with it what it finds.
    """
    usual: Any = profile.controllers["cascade"]
    settings = type(usual)()
    calm = dataclasses.replace(
        settings.pair,
        **{name: min(getattr(usual.pair, name), most) for name, most in _CALM.items()},
    )
    blind = dataclasses.replace(
        settings, wire=usual.wire, pose=usual.pose, stretch=usual.stretch, pair=calm,
        camera=dataclasses.replace(settings.camera, gain=0.0), learning=None,
        dither=dataclasses.replace(settings.dither, amplitude=0.0),
        path_dither=dataclasses.replace(settings.path_dither, force=0.0),
    )  # fmt: skip
    return dataclasses.replace(
        profile, controllers={**profile.controllers, "cascade": blind}
    ), "cascade"


def mover(profile: Profile) -> tuple[Profile, str]:
    """Return the profile with a controller that is at rest when it is at its place, and its name.

    Where exactly is of no matter; but a pair of little friction that hunts would be let go on its
    way. A joint's ring sticks where it leans, and flies off when a PID has pushed for long enough.
    """
    if profile.mechanism == "joint":
        return follower(profile)
    pid: Any = profile.controllers["pid"]
    soft = dataclasses.replace(
        pid, proportional=_SOFT * pid.proportional, integral=_SOFT**2 * pid.integral,
        derivative=_SOFT * pid.derivative,
    )  # fmt: skip
    return dataclasses.replace(profile, controllers={**profile.controllers, "pid": soft}), "pid"


def reach(profile: Profile, share: float) -> float:
    """Return how far a pair, or a joint's ring along the ball, may go from home, m.

    Parameters
    ----------
    profile : Profile
        The rig's.
    share : float
        Of what is permitted; of a joint's tilt three quarters, since its rods may not know it yet.
    """
    settings = profile.mechanism_settings
    if profile.mechanism == "cylinder":
        low, high = settings.limits.position
        return float(share * min(-low, high))
    return 0.75 * share * float(settings.limits.tilt * settings.geometry.ball_radius)


def leaning(
    profile: Profile,
    motion: Any,
    azimuth: float,
    controller: Any,
    bases: Sequence[tuple[float, float]] = (),
) -> Any:
    """Return a motion along a line as one of the mechanism.

    Parameters
    ----------
    profile : Profile
        The rig's.
    motion : object
        Settings of a reference of a pair: positions of wires, m.
    azimuth : float
        Of the line, rad; a pair has but one.
    controller : object
        Who is to follow it.
    bases : sequence of tuple of float
        See `rig.mechanisms.pneumatic.calibration.pressure_steps.Leaning`; a pair keeps its own.

    Raises
    ------
    MotionRefused
        The joint cannot be or may not be in one of its poses.
    """
    if profile.mechanism == "cylinder":
        return motion
    from rig.assembly import plan_motion
    from rig.mechanisms.pneumatic.calibration.pressure_steps import Leaning

    radius = profile.mechanism_settings.geometry.ball_radius
    return plan_motion(profile, Leaning(motion, azimuth, radius, bases), controller)


def calm_base(profile: Profile) -> float:
    """Return the base pressure under which a mechanism is moved, Pa gauge; a pair keeps its own."""
    base = float(profile.mechanism_settings.base_pressure)
    return base if profile.mechanism == "cylinder" else min(base, _CALM_BASE)


def open_loop(
    profile: Profile, times: Sequence[float], pressures: Sequence[Sequence[float]], segments: Any
) -> Any:
    """Return motion and controller in one, which gives pressures and leaves the pose alone."""
    from rig.mechanisms.pneumatic.calibration.pressure_steps import OpenLoop

    if profile.mechanism == "cylinder":
        from controllers.cylinder.types import PairCommand, PairEstimate, PairReference

        return OpenLoop(
            times, pressures, segments,
            rest=PairReference(0.0, 0.0, 0.0), command=PairCommand,
            estimate=PairEstimate(0.0, 0.0),
        )  # fmt: skip
    from controllers.spherical_joint.types import JointCommand, JointEstimate, JointReference

    nothing = (0.0, 0.0, 0.0)
    return OpenLoop(
        times, pressures, segments,
        rest=JointReference((0.0, 0.0, 1.0), nothing, nothing), command=JointCommand,
        estimate=JointEstimate(nothing, nothing, 0.0, (0.0,) * 4, (0.0,) * 4),
    )  # fmt: skip


def unseen(profile: Profile, give: float) -> tuple[Profile, tuple[str, ...]]:
    """Return the profile for chambers that its monitors do not see for a while, and notes on it.

    A joint's alarms work out by the monitors how far its wires give.

    Parameters
    ----------
    profile : Profile
        The rig's.
    give : float
        How far a wire may seem to move meanwhile, m.
    """
    if profile.mechanism == "cylinder":
        return profile, ()
    settings = profile.mechanism_settings
    usual = settings.alarms.frozen
    if usual.distance >= give:
        return profile, ()
    frozen = dataclasses.replace(usual, distance=give)
    alarms = dataclasses.replace(settings.alarms, frozen=frozen)
    note = (
        f"alarms.frozen.distance is {1e3 * give:g} mm instead of {1e3 * usual.distance:g} mm: "
        "a monitor does not see behind a shut valve how far a wire gives"
    )
    mechanism = dataclasses.replace(settings, alarms=alarms)
    return dataclasses.replace(profile, mechanism_settings=mechanism), (note,)


def balanced(profile: Profile, reference: Any, pressure: float) -> tuple[float, ...]:
    """Return pressures that hold a pose by themselves, Pa gauge.

    Parameters
    ----------
    profile : Profile
        The rig's.
    reference : object
        The pose; a pair is held by equal pressures wherever it is.
    pressure : float
        Their mean, as far as none gets above what is permitted, Pa gauge.
    """
    pneumatics = pneumatics_of(profile)
    count = len(pneumatics.channels)
    if profile.mechanism == "cylinder":
        return (min(pressure, pneumatics.highest),) * count
    from controllers.spherical_joint.poses import natural_rotation
    from controllers.spherical_joint.tension import TensionDistribution

    distribution = TensionDistribution(profile.mechanism_settings.geometry)
    shares = distribution.shares(natural_rotation(reference.axis))
    total = min(count * pressure, pneumatics.highest / max(shares))
    return tuple(total * share for share in shares)


def command_type(profile: Profile) -> Any:
    """Return what makes the mechanism's command of one pressure per channel."""
    if profile.mechanism == "cylinder":
        from controllers.cylinder.types import PairCommand

        return PairCommand
    from controllers.spherical_joint.types import JointCommand

    return JointCommand
