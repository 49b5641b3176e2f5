"""The pneumatic side of one antagonistic pair."""

from collections.abc import Iterator, Sequence

from controllers.cylinder.types import PairCommand, PairEstimate, PairReference
from rig.calibration.arrays import Array
from rig.calibration.profile_changes import with_wider_limits
from rig.calibration.recording import Stretch
from rig.config import Profile, format_quantity
from rig.hal.motion import Motion
from rig.mechanisms.cylinder.first_gains import with_placing_law
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.pneumatic.calibration.pneumatics import Limit, Pneumatics
from rig.mechanisms.pneumatic.calibration.smoothing import PairSignals

_STRETCHED = 1.25
"""Times the wires' stretch by the greatest pressure, rods may disagree: stiffness is a guess."""


class PairPneumatics(Pneumatics[PairReference, PairCommand]):
    """The pneumatic side of a pair."""

    locked_share = 0.5
    still = PairReference(0.0, 0.0, 0.0)
    no_estimate = PairEstimate(0.0, 0.0)
    command = PairCommand

    def __init__(self, profile: Profile) -> None:
        self.settings: CylinderSettings = profile.mechanism_settings
        super().__init__(profile)

    @property
    def encoders(self) -> tuple[str, ...]:
        """See `Pneumatics.encoders`."""
        return (self.settings.encoder_agonist, self.settings.encoder_antagonist)

    def extension(self, stretch: Stretch, channel: str) -> Array:
        """See `Pneumatics.extension`."""
        return stretch[f"reading.position_{channel}"]

    def signals(self, stretch: Stretch) -> PairSignals:
        """Return what the pair did in a stretch."""
        pulls = (self.area * stretch[f"reading.pressure_{c}"] for c in self.channels)
        agonist, antagonist = pulls
        return PairSignals(
            "", agonist - antagonist, stretch["reading.position"], agonist + antagonist
        )

    def _pressures(self) -> tuple[float, float]:
        return self.settings.limits.pressure

    def limits_in_force(self) -> Iterator[Limit]:
        """See `Pneumatics.limits_in_force`."""
        limits = self.settings.limits
        yield "position", limits.position, "m"
        yield "speed", limits.speed, "m/s"
        yield "pressure", limits.pressure, "Pa"
        yield "pair_force", limits.pair_force, "N"

    def with_wider_limits(self, pair: float = 0.0) -> tuple[Profile, tuple[str, ...]]:
        """See `Pneumatics.with_wider_limits`; a pair that glides by itself follows nothing.

        Procedures go to pressures that no experiment needs, where a large bore stretches the
        wires by more than the rods may disagree otherwise.
        """
        limits = self.settings.limits
        low, high = limits.position
        stretch = self.settings.area * limits.pressure[1] / self.settings.wire_stiffness
        mismatch = max(limits.mismatch, _STRETCHED * stretch) + pair
        return self.with_unknown_response(
            *with_wider_limits(self.profile, {"mismatch": mismatch, "following": high - low})
        )

    def with_blind_monitors(self, give: float) -> tuple[Profile, tuple[str, ...]]:
        """See `Pneumatics.with_blind_monitors`; a pair's limits do not heed how wires give."""
        return self.profile, ()

    @property
    def gentle_pressure(self) -> float:
        """See `Pneumatics.gentle_pressure`; a pair keeps its own."""
        return self.base_pressure

    def with_gentle_controller(self) -> tuple[Profile, str]:
        """See `Pneumatics.with_gentle_controller`; the place need not be exact."""
        return with_placing_law(self.profile)

    def with_placing_controller(self) -> tuple[Profile, str]:
        """See `Pneumatics.with_placing_controller`; encoders come before friction and response."""
        return self.with_gentle_controller()

    def reach(self, share: float) -> float:
        """See `Pneumatics.reach`."""
        low, high = self.settings.limits.position
        return share * min(-low, high)

    def along_line(
        self,
        motion: Motion[PairReference],
        controller: object,
        bases: Sequence[tuple[float, float]] = (),
    ) -> Motion[PairReference]:
        """See `Pneumatics.along_line`; a pair moves along nothing else."""
        return motion

    def describe_path(self, path: Sequence[PairReference]) -> Iterator[str]:
        """See `Pneumatics.describe_path`."""
        low, high = (format_quantity(f(row.position for row in path), "m") for f in (min, max))
        speed = format_quantity(max(abs(row.velocity) for row in path), "m/s")
        yield f"the pair moves {low} … {high}, up to {speed}"

    def balanced(self, reference: PairReference, pressure: float) -> tuple[float, ...]:
        """See `Pneumatics.balanced`; equal pressures hold a pair wherever it is."""
        return (min(pressure, self.highest),) * len(self.channels)
