"""What a procedure will move and how far, said before anything is opened."""

from collections.abc import Iterator
from pathlib import Path

from rig.calibration.procedure import AnyProcedure, Excitation, FilesOffered
from rig.config import Profile, format_quantity
from rig.config.names import say_where


def preview(
    procedure: AnyProcedure,
    profile: Profile,
    excitation: Excitation | None,
    files: FilesOffered | None = None,
    configs: Path | None = None,
) -> Iterator[str]:
    """Yield sentences on what will happen.

    Parameters
    ----------
    procedure, profile
        What is to be done on what.
    excitation : Excitation, optional
        Of the procedure; None: nothing moves.
    files : FilesOffered, optional
        What a procedure without a motion may read.
    configs : Path, optional
        The folder of configurations that is written into, to be told.

    Raises
    ------
    CalibrationRefused
        The files are not what it takes.
    """
    reads = [] if files is None else list(procedure.describe_files(files))
    yield f"{procedure.name}: {procedure.title}"
    yield from (f"  {sentence}" for sentence in reads)
    names = ", ".join(f"{name}.yaml" for name in procedure.targets(profile))
    into = "" if configs is None else f", calibrations of {profile.name} in {say_where(configs)}"
    if excitation is None:
        yield f"  writes: {names}{into}"
        return
    motion = excitation.motion
    if not motion.segments:
        yield "  everything is recorded: nothing moves"
        return
    yield f"  {len(motion.segments)} stretches in {motion.duration:.0f} s"
    yield from (f"  {sentence}" for sentence in excitation.describe())
    yield from (f"  but: {note}" for note in excitation.notes)
    if excitation.placing:
        yield f"  first of all: {excitation.placing}"
    for instrument in procedure.instruments(profile):
        if instrument.expected:
            continue  # what holds it says it
        accuracy = format_quantity(instrument.accuracy, instrument.unit)
        yield (
            f"  to be read: {instrument.name}, {len(instrument.stretches)} times, "
            f"to {accuracy} or better"
        )
    yield f"  writes: {names}{into}"
