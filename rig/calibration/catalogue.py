"""The procedures that there are."""

from rig.calibration.procedure import Procedure
from rig.config import Profile
from rig.hal import ConfigurationError
from rig.mechanisms.joint.calibration.lens import Lens


def procedures(profile: Profile) -> dict[str, Procedure | Lens]:
    """Return the procedures of a rig by name, in the order in which they build on each other."""
    from rig.mechanisms.cylinder.calibration.friction import PairFriction
    from rig.mechanisms.joint.calibration.friction import JointFriction
    from rig.mechanisms.pneumatic.calibration.encoders import Encoders
    from rig.mechanisms.pneumatic.calibration.leak import Leak
    from rig.mechanisms.pneumatic.calibration.regulators import Regulators
    from rig.mechanisms.pneumatic.calibration.response import Response
    from rig.mechanisms.pneumatic.calibration.wires import Wires

    every: tuple[Procedure | Lens, ...] = (
        Regulators(), Encoders(), Wires(), Response(), PairFriction(), JointFriction(), Leak(),
        *_of_cameras(), *_of_servos(),
    )  # fmt: skip
    # Two mechanisms may have procedures of one name, which do different things.
    return {p.name: p for p in every if profile.mechanism in p.mechanisms and p.targets(profile)}


def _of_cameras() -> tuple[Procedure | Lens, ...]:
    from rig.mechanisms.joint.calibration.camera import Camera
    from rig.mechanisms.joint.calibration.geometry import Geometry

    return Lens(), Camera(), Geometry()


def _of_servos() -> tuple[Procedure, ...]:
    from rig.mechanisms.arm.calibration.links import ArmLinks
    from rig.mechanisms.arm.calibration.zeros import ArmZeros
    from rig.mechanisms.legs.calibration.scale import LegScale
    from rig.mechanisms.legs.calibration.zeros import LegZeros

    return ArmZeros(), ArmLinks(), LegZeros(), LegScale()


def pick(profile: Profile, names: tuple[str, ...]) -> list[Procedure | Lens]:
    """Return procedures by name, in their own order.

    Raises
    ------
    ConfigurationError
        There is none of a name; with the nearest.
    """
    from rig.config.diagnostics import nearest

    known = procedures(profile)
    for name in names:
        if name not in known:
            hint = nearest(name, known) or f"there is none for a {profile.mechanism}"
            raise ConfigurationError(f"no procedure of {profile.name} is called {name!r}; {hint}")
    return [procedure for name, procedure in known.items() if name in names]
