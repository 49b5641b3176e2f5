"""Whose a calibration or an acceptance record is: two profiles may have one name.

Both are kept by a rig's name. They say of which profile file they are, so that another rig of that
name in another folder does not take them for its own. One that says nothing is anybody's, as all
were before they said it.
"""

from collections.abc import Sequence
from pathlib import Path


def owner_label(files: Sequence[Path], search: Sequence[Path]) -> str | None:
    """Return what says of which profile something is, in a file that is kept.

    Parameters
    ----------
    files : sequence of Path
        What was read for the profile, its own file first.
    search : sequence of Path
        The folders of configurations.

    Returns
    -------
    str or None
        ``rigs/NAME.yaml`` in a folder of configurations, which may be moved as a whole; else the
        whole path. None: the profile was made by a program.
    """
    if not files:
        return None
    file = files[0].resolve()
    if any(file.parent == (configs / "rigs").resolve() for configs in search):
        return f"rigs/{file.name}"
    return str(file)


def is_owner(label: str | None, files: Sequence[Path], search: Sequence[Path]) -> bool:
    """Return whether what bears a label is a profile's own.

    Parameters
    ----------
    label : str or None
        As `owner_label` wrote it; None: it does not say.
    files : sequence of Path
        What was read for the profile, its own file first.
    search : sequence of Path
        The folders of configurations; the one that the label was read in is among them.
    """
    if label is None or not files:
        return True
    file = files[0].resolve()
    places = [Path(label)] if Path(label).is_absolute() else [at / label for at in search]
    return any(place.resolve() == file for place in places)
