"""The procedures that there are."""

from rig.calibration.procedure import Procedure
from rig.calibration.procedures.lens import Lens
from rig.config import Profile
from rig.hal import ConfigurationError


def procedures(profile: Profile) -> dict[str, Procedure | Lens]:
    """Return the procedures of a rig by name, in the order in which they build on each other."""
    from rig.calibration.procedures.encoders import Encoders
    from rig.calibration.procedures.joint_friction import JointFriction
    from rig.calibration.procedures.leak import Leak
    from rig.calibration.procedures.pair_friction import PairFriction
    from rig.calibration.procedures.regulators import Regulators
    from rig.calibration.procedures.response import Response
    from rig.calibration.procedures.wires import Wires

    every: tuple[Procedure | Lens, ...] = (
        Regulators(), Encoders(), Wires(), Response(), PairFriction(), JointFriction(), Leak(),
        *_of_cameras(), *_of_servos(),
    )  # fmt: skip
    # Two mechanisms may have procedures of one name, which do different things.
    return {p.name: p for p in every if profile.mechanism in p.mechanisms and p.targets(profile)}


def _of_cameras() -> tuple[Procedure | Lens, ...]:
    from rig.calibration.procedures.camera import Camera
    from rig.calibration.procedures.geometry import Geometry

    return Lens(), Camera(), Geometry()


def _of_servos() -> tuple[Procedure, ...]:
    from rig.calibration.procedures.arm_links import ArmLinks
    from rig.calibration.procedures.arm_zeros import ArmZeros
    from rig.calibration.procedures.leg_scale import LegScale
    from rig.calibration.procedures.leg_zeros import LegZeros

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
