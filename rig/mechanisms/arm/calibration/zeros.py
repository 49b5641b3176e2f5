"""Zeros and directions of an arm's joints, from small moves around where it stands.

Each joint moves alone, then all of them together, half a radian to either side; an instrument
measures a marker on the hand. Lengths are fitted along, for zeros that are not taken for them.
"""

from collections.abc import Sequence

import numpy as np

from rig.calibration.instruments import Instrument, Readings
from rig.calibration.procedure import Excitation, Finding, Procedure
from rig.calibration.recording import Recording
from rig.config import Profile
from rig.mechanisms.arm.calibration.hand_fit import find_directions, fit_hand
from rig.mechanisms.arm.calibration.hand_model import parameters_of
from rig.mechanisms.arm.calibration.poses import near_poses
from rig.mechanisms.arm.calibration.survey import (
    devices_of,
    drive_findings,
    excite,
    instruments_of,
    measured,
    panels_of,
)


class ArmZeros(Procedure[Recording]):
    """Procedure for zero and direction of every axis."""

    name = "zeros"
    title = "zeros and directions of the joints, from a marker on the hand"
    shares = ("links",)
    rests_on_dimensions = True

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the servo devices' files."""
        return devices_of(profile)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return what measures the marker."""
        return instruments_of(profile, near_poses())

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return small moves; they count from where the arm stands, so none is left out."""
        whole = all(name in done for name, _ in near_poses())
        return excite(profile, near_poses(), done if whole else (), relative=True)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Find the directions, then fit."""
        settings = profile.mechanism_settings
        sign, accuracy = float(settings.geometry.wrist_sign), settings.metrology.accuracy
        joints, hand = measured(profile, near_poses(), data, readings)
        parameters = parameters_of(settings.geometry, settings.metrology)
        directions = find_directions(parameters, joints, hand, sign, accuracy)
        turned = joints * np.array(directions)
        fit = fit_hand(parameters, turned, hand, sign, accuracy)
        return drive_findings(profile, fit, directions, panels_of(profile, fit, turned, hand))
