"""Lengths of an arm's links together with its joints' zeros, from poses all over its workspace."""

from collections.abc import Sequence

from rig.calibration.instruments import Instrument, Readings
from rig.calibration.procedure import Excitation, Finding, Procedure
from rig.calibration.recording import Recording
from rig.config import Profile
from rig.mechanisms.arm.calibration.hand_fit import fit_hand
from rig.mechanisms.arm.calibration.hand_model import parameters_of
from rig.mechanisms.arm.calibration.poses import wide_poses
from rig.mechanisms.arm.calibration.survey import (
    Poses,
    devices_of,
    drive_findings,
    excite,
    instruments_of,
    length_finding,
    measured,
    panels_of,
)


class ArmLinks(Procedure[Recording]):
    """Procedure for lengths and zeros in one fit."""

    name = "links"
    title = "link lengths and zeros of the joints, from a marker on the hand"
    shares = ("zeros",)
    rests_on_dimensions = True

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the servo devices' files and the mechanism's: what is fitted as one is used so."""
        return (*devices_of(profile), profile.mechanism)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return what measures the marker."""
        return instruments_of(profile, _poses(profile))

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the poses that are not done."""
        return excite(profile, _poses(profile), done, relative=False)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit all poses."""
        settings = profile.mechanism_settings
        joints, hand = measured(profile, _poses(profile), data, readings)
        parameters = parameters_of(settings.geometry, settings.metrology)
        sign = float(settings.geometry.wrist_sign)
        fit = fit_hand(parameters, joints, hand, sign, settings.metrology.accuracy)
        panels = panels_of(profile, fit, joints, hand)
        return (*drive_findings(profile, fit, (1.0,) * 6, panels), length_finding(profile, fit))


def _poses(profile: Profile) -> Poses:
    settings = profile.mechanism_settings
    return wide_poses(settings.geometry, settings.metrology)
