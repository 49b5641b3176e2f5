"""What a procedure will move and how far, said before anything is opened."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from rig.calibration.procedure import Procedure
from rig.config import Profile, format_quantity
from rig.mechanisms.cylinder.calibration.glides import Gliding
from rig.mechanisms.joint.calibration.tugs import DEPTH, Tugging
from rig.mechanisms.pneumatic.calibration.lock_cycles import Locking
from rig.mechanisms.pneumatic.calibration.pressure_steps import OpenLoop
from rig.mechanisms.servo.calibration.posture_moves import PostureMoves

_STEP = 0.01
"""The motion is looked at every so often, s."""


def preview(procedure: Procedure, profile: Profile, done: Sequence[str]) -> Iterator[str]:
    """Yield sentences on what will happen.

    Parameters
    ----------
    procedure, profile
        What is to be done on what.
    done : sequence of str
        Stretches that are recorded already.
    """
    excitation = procedure.excite(profile, done)
    motion = excitation.motion
    yield f"{procedure.name}: {procedure.title}"
    if not motion.segments:
        yield "  everything is recorded: nothing moves"
        return
    yield f"  {len(motion.segments)} stretches in {motion.duration:.0f} s"
    if isinstance(motion, PostureMoves):
        yield from _joints(motion)
    elif isinstance(motion, OpenLoop):
        yield from _pressures(motion)
    elif isinstance(motion, Gliding):
        yield from _glides(motion)
    else:
        yield from _positions(motion)
    if isinstance(motion, Locking):
        yield from _locks(motion)
    if isinstance(motion, Tugging):
        yield from _tugs(motion)
    limits = excitation.profile.mechanism_settings
    for name in ("position", "speed", "pressure", "pair_force", "tilt", "tension"):
        bound = getattr(getattr(limits, "limits", None), name, None)
        if bound is not None:
            yield f"  in force: limits.{name} {_bound(bound, name)}"
    yield from (f"  but: {note}" for note in excitation.notes)
    if excitation.placing:
        yield f"  first of all: {excitation.placing}"
    for instrument in procedure.instruments(profile):
        accuracy = format_quantity(instrument.accuracy, instrument.unit)
        if instrument.expected:
            continue  # what holds it says it
        yield (
            f"  to be read: {instrument.name}, {len(instrument.stretches)} times, "
            f"to {accuracy} or better"
        )
    yield f"  writes: {', '.join(f'{name}.yaml' for name in procedure.targets(profile))}"


def _pressures(motion: OpenLoop[Any, Any]) -> Iterator[str]:
    columns = list(zip(*motion.pressures, strict=True))
    for number, column in enumerate(columns, 1):
        low, high = format_quantity(min(column), "Pa"), format_quantity(max(column), "Pa")
        yield f"  chamber {number}: set-points {low} … {high}"
    if all(column == columns[0] for column in columns):
        yield "  all chambers alike: their pulls cancel, and no rod is meant to move"


def _glides(motion: Gliding) -> Iterator[str]:
    glides = motion.settings
    low, high = (format_quantity(side * glides.travel, "m") for side in (-1.0, 1.0))
    force, rate = format_quantity(glides.most, "N"), format_quantity(glides.rate, "N/s")
    speed = format_quantity(glides.fastest, "m/s")
    least, most = (format_quantity(f(glides.bases), "Pa") for f in (min, max))
    yield f"  the pair moves {low} … {high} and glides between them, no controller holding it"
    yield f"  to break it away, a force that rises by {rate}, up to {force}"
    yield f"  then a spring of {glides.stiffness:g} N/m, pulled at {speed} and ever more slowly"
    yield f"  mean pressures {least} … {most}"


def _tugs(motion: Tugging) -> Iterator[str]:
    settings = motion.settings
    force, rate = format_quantity(settings.most, "N"), format_quantity(settings.rate, "N/s")
    base, highest = (format_quantity(share * motion.base, "Pa") for share in (1.0, 1.0 + DEPTH))
    count = len(settings.tugs)
    yield f"  then upright, at {base}: {count} times one pair is pushed until it moves,"
    yield f"  no controller holding it, with a force that rises by {rate}, up to {force}"
    yield f"  before each of them all four pressures swing, up to {highest} and ever less"


def _locks(motion: Locking) -> Iterator[str]:
    for number, column in enumerate(zip(*motion.pressures.values(), strict=True), 1):
        highest = max(column)
        low, high = (format_quantity(p, "Pa") for p in (min(column) - motion.below, highest))
        yield f"  chamber {number}: set-points {low} … {high}, locked in {motion.count} times"
    yield "  while they are locked, no controller holds the rods: friction does"


def _joints(motion: PostureMoves) -> Iterator[str]:
    settings = motion.settings
    if not motion.has_torque:
        yield "  no torque: the joints are moved by hand, and nothing moves by itself"
        return
    fastest = [0.0] * len(settings.joints)
    for k in range(int(motion.duration / _STEP)):
        speeds = motion.at(k * _STEP).velocities
        fastest = [max(a, abs(b)) for a, b in zip(fastest, speeds, strict=True)]
    where = " from where it stands" if settings.relative else ""
    for k, name in enumerate(settings.joints):
        angles = [posture[k] for posture in settings.angles]
        low, high = format_quantity(min(angles), "rad"), format_quantity(max(angles), "rad")
        speed = format_quantity(fastest[k], "rad/s")
        yield f"  {name} moves {low} … {high}{where}, up to {speed}"


def _positions(motion: Any) -> Iterator[str]:
    count = max(int(motion.duration / _STEP), 2)
    rows = [motion.at(motion.duration * k / count) for k in range(count + 1)]
    if hasattr(rows[0], "position"):
        places = [row.position for row in rows]
        speeds = [abs(row.velocity) for row in rows]
        low, high = format_quantity(min(places), "m"), format_quantity(max(places), "m")
        yield f"  the pair moves {low} … {high}, up to {format_quantity(max(speeds), 'm/s')}"
    elif hasattr(rows[0], "axis"):
        tilt = math.acos(min(max(min(row.axis[2] for row in rows), -1.0), 1.0))
        speed = max(math.hypot(*row.velocity) for row in rows)
        yield (
            f"  the ring leans by up to {format_quantity(tilt, 'rad')}, at up to "
            f"{math.degrees(speed):.3g} deg/s"
        )


def _bound(bound: Any, name: str) -> str:
    unit = {
        "position": "m", "speed": "m/s", "pressure": "Pa", "pair_force": "N", "tilt": "rad",
        "tension": "N",
    }[name]  # fmt: skip
    ends = bound if isinstance(bound, tuple) else (bound,)
    return " … ".join(format_quantity(end, unit) for end in ends)
