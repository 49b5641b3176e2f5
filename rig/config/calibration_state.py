"""Find the calibrations of a profile that no longer hold, and what would mend them."""

import socket
from datetime import date, datetime
from typing import NamedTuple

from rig.config.basis import changes_of, say_changes
from rig.config.calibration import HARDWARE, STATED, UNKNOWN
from rig.config.laid_over import TUNED
from rig.config.models import Calibration, Profile


class CalibrationState(NamedTuple):
    """One calibration in force.

    Parameters
    ----------
    name : str
        The device, or the mechanism.
    calibration : Calibration
        What was laid over its settings.
    problems : tuple of str
        Why it does not hold; empty if it does.
    remedy : str
        The command that would mend it.
    """

    name: str
    calibration: Calibration
    problems: tuple[str, ...]
    remedy: str

    @property
    def sentence(self) -> str:
        """What is wrong and how to mend it, in one sentence."""
        return f"its calibration {'; '.join(self.problems)}; mend it with: {self.remedy}"


def calibration_states(
    profile: Profile, today: date, *, on_hardware: bool = False
) -> tuple[CalibrationState, ...]:
    """Return the state of every calibration in force, and of those that are another rig's.

    Parameters
    ----------
    profile : Profile
        As loaded.
    today : date
        The day to judge it at.
    on_hardware : bool
        It is to hold on the rig itself: what was measured in simulation does not.
    """
    found = []
    for name, calibration in profile.calibrations.items():
        entry = profile.devices.get(name)
        serial = None if entry is None else entry.serial
        procedure = calibration.provenance.procedure or "--all"
        problems = _problems(calibration, serial, today)
        changes = changes_of(calibration, profile)
        if changes:
            told = say_changes(changes)
            is_gains = name.startswith(TUNED)
            changed = f"has gains that were {told}" if is_gains else f"was {told}"
            procedure = procedure if problems else " ".join(changes)
            problems = (*problems, changed)
        remedy = f"rig calibrate {profile.argument} {procedure} --replace --on hardware"
        if name.startswith(TUNED):
            law = name.removeprefix(TUNED)
            remedy = f"rig tune {profile.argument} --controller {law} --replace"
        if on_hardware:
            elsewhere = _elsewhere(calibration, serial)
            if elsewhere and not problems:
                day = calibration.provenance.date.replace(":", "").replace("+0000", "Z")
                remedy = (
                    f"rig calibrate {profile.argument} --restore {name}/{day}, if it is the same "
                    "rig on another computer; else calibrate anew"
                )
            problems = (*elsewhere, *_strangeness(calibration), *problems)
        found.append(CalibrationState(name, calibration, problems, remedy))
    for name, calibration in profile.foreign.items():
        found.append(CalibrationState(name, calibration, (_not_ours(calibration),), _own(profile)))
    return tuple(found)


def sentences_of_bases(profile: Profile) -> list[str]:
    """Say which rigs that a profile extends are calibrated where it is not, and what mends it."""
    of: dict[str, list[str]] = {}
    for target, base in profile.calibrated_bases.items():
        of.setdefault(base, []).append(target)
    return [
        f"{profile.name} extends {base}, and has nothing of its calibration "
        f"({', '.join(targets)}): calibrations are of one rig; find its own with: "
        f"rig calibrate {profile.argument} --all"
        for base, targets in of.items()
    ]


def _not_ours(calibration: Calibration) -> str:
    return (
        f"({calibration.file}) belongs to another rig: {calibration.provenance.profile}, and is "
        "not in force here"
    )


def _own(profile: Profile) -> str:
    return (
        f"name: NAME in {profile.argument}, a name of its own; if it is the same rig, moved: "
        f"rig calibrate {profile.argument} --restore DEVICE/DATE"
    )


def _strangeness(calibration: Calibration) -> tuple[str, ...]:
    of = calibration.provenance
    if of.backend in (HARDWARE, STATED):
        return ()
    if of.backend in (None, UNKNOWN):
        return ("does not say whether it was measured on hardware",)
    seed = "" if of.seed is None else f", seed {of.seed}"
    return (f"was measured in simulation ({of.backend}{seed}), not on hardware",)


def _elsewhere(calibration: Calibration, serial: int | None) -> tuple[str, ...]:
    """Return that another computer has measured it, where no serial number tells that it is ours.

    Records come along with a folder of configurations that is copied or cloned.
    """
    of = calibration.provenance
    here = socket.gethostname()
    if of.backend != HARDWARE or of.host in (None, here):
        return ()
    if of.serial is not None and of.serial == serial:
        return ()
    return (f"was measured at the rig of another computer ({of.host}; this is {here})",)


def _problems(calibration: Calibration, serial: int | None, today: date) -> tuple[str, ...]:
    of = calibration.provenance
    problems = []
    if None not in (serial, of.serial) and serial != of.serial:
        problems.append(f"is of serial number {of.serial}, the profile's device has {serial}")
    if of.valid_until is not None and datetime.fromisoformat(of.valid_until).date() < today:
        problems.append(f"expired on {of.valid_until}")
    if (
        of.residual_rms is not None
        and of.residual_bound is not None
        and of.residual_rms > of.residual_bound
    ):
        problems.append(
            f"leaves {of.residual_rms:g} {of.unit or ''} rms, "
            f"above the bound of {of.residual_bound:g} {of.unit or ''}"
        )
    return tuple(problems)
