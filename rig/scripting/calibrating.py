"""`rig.calibrate`: a calibration procedure from Python."""

import getpass
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

from rig.assembly import REGISTRY, Backend, backend_of
from rig.calibration.catalogue import pick
from rig.calibration.instrument_files import read_file
from rig.calibration.preview import preview
from rig.calibration.procedure import AnyProcedure, FilesOffered
from rig.calibration.recording import CalibrationRefused, RigLacks
from rig.calibration.session import Calibrated, conclude, read_instruments, record, recorded
from rig.calibration.store import Circumstances
from rig.config import Profile, load_profile
from rig.config.names import find_configs
from rig.experiment.fault_latch import FaultLatch
from rig.hal import ConfigurationError
from rig.run_facts import RunStatus
from rig.scripting.errors import error_of
from rig.scripting.played import refuse_within_plan
from rig.scripting.recorded import Run
from rig.scripting.running import Settings, as_options

_DAY = 86_400.0


def calibrate(
    rig: str,
    procedure: str,
    *,
    on: str = "virtual",
    set: Settings | None = None,
    out: str | Path = "runs",
    configs: str | Path | None = None,
    readings: str | Path | None = None,
    replace: bool = False,
    operator: str | None = None,
    valid_for: int = 365,
    conditions: Mapping[str, str] | None = None,
    yes: str | None = None,
) -> Calibrated:
    """Carry out a procedure that moves the rig, and write the calibration files.

    Parameters
    ----------
    rig, procedure : str
        As ``rig calibrate RIG PROCEDURE``.
    on, set, out, configs
        See `rig.run`.
    readings : Path, optional
        File of what the reference instruments showed: quantity,stretch,value lines.
    replace : bool
        Replace a better or an unreadable calibration.
    operator : str, optional
        Who calibrates; default: the user's name.
    valid_for : int
        Days.
    conditions : mapping, optional
        For the record: temperature, supply pressure.
    yes : str, optional
        The rig's name: without it hardware is refused.

    Returns
    -------
    Calibrated
        What was found, with its intervals, and the files.

    Raises
    ------
    CalibrationRefused
        The data do not suffice, or the fit is worse than the one in force: nothing was changed.
    RunFaulted, RunInterrupted, NotEnergised
        The recording ended early: nothing was changed.
    ConfigurationError, DeviceError
        As for `rig.run`.
    """
    refuse_within_plan("rig.calibrate")
    if not (isinstance(valid_for, int) and valid_for > 0):
        raise ConfigurationError(f"valid_for is {valid_for!r}, and must be whole days, 1 at least")
    _check_words(rig, procedure, on, operator, conditions)
    search = find_configs(None if configs is None else Path(configs))
    profile = load_profile(rig, REGISTRY, as_options(set), search)
    (chosen,) = pick(profile, (procedure,))
    backend = backend_of(on)
    if backend is Backend.HARDWARE:
        FaultLatch.of(profile, on).check()
        if yes != profile.name:
            raise ConfigurationError(f"nothing was moved: give the rig's name, yes={rig!r}")
    try:
        excitation = chosen.excite(profile, ())
    except RigLacks as lack:
        raise CalibrationRefused(f"{procedure}: {lack}") from lack
    if excitation is None:
        raise ConfigurationError(f"{procedure} moves nothing: rig calibrate {rig} {procedure}")
    if readings is not None:  # a slip in it is said before the rig moves
        _check_readings(chosen, profile, readings)
    files = FilesOffered(None, "10x7x8mm", backend.is_simulated, Path(out))
    tuple(preview(chosen, profile, excitation, files))  # refuses what must not be moved
    result, folders = record(
        chosen, profile, backend, Path(out), on=None if on in list(Backend) else on
    )
    if result is not None and result.status is not RunStatus.OK:
        error = error_of(Run(result.path), result.exit_code, strict=True)
        if error is not None:
            raise error
    shown = read_instruments(
        chosen, profile, folders, simulated=backend.is_simulated,
        readings=None if readings is None else Path(readings),
    )  # fmt: skip
    circumstances = Circumstances(
        operator or getpass.getuser(), valid_for * _DAY, dict(conditions or {}),
        datetime.now(UTC), backend.value,
        None if backend is Backend.HARDWARE else profile.simulation.seed,
    )  # fmt: skip
    return conclude(
        chosen, profile, recorded(folders), folders[-1], shown, circumstances, search,
        replace=replace,
    )  # fmt: skip


def _check_words(
    rig: object, procedure: object, on: object, operator: object, conditions: object
) -> None:
    words = {"rig": rig, "procedure": procedure, "on": on, "operator": operator or ""}
    for name, word in words.items():
        if not isinstance(word, str):
            raise ConfigurationError(f"{name} is {word!r}, and must be a word")
    told = {} if conditions is None else conditions
    if not isinstance(told, Mapping) or not all(
        isinstance(word, str) for pair in told.items() for word in pair
    ):
        raise ConfigurationError(
            f"conditions are {told!r}, and must be words by their names, "
            'as in {"temperature": "21 degC"}'
        )


def _check_readings(chosen: AnyProcedure, profile: Profile, readings: str | Path) -> None:
    if not isinstance(readings, str | Path):
        raise ConfigurationError(f"readings is {readings!r}, and no path of a file")
    wanted = chosen.instruments(profile)
    if not wanted:
        raise ConfigurationError(f"{chosen.name} reads no instruments: leave readings out")
    read_file(wanted, Path(readings))
