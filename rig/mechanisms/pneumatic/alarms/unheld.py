"""Tell that a rod may have been moved before anybody saw where it was."""

from collections.abc import Sequence

from rig.hal import DeviceFault


def explain_unheld(error: Exception, encoders: Sequence[str], moved: str) -> str | None:
    """Return why a rod is beyond its bounds in the first cycle of all; None: that is not the error.

    Empty chambers hold nothing, and the opposite rod does not show a push: its wire gets slack.

    Parameters
    ----------
    error : Exception
        Of a device, before any state was checked.
    encoders : sequence of str
        Names of the encoders.
    moved : str
        What the rods move, for messages: ``the carriage``.
    """
    if not isinstance(error, DeviceFault) or error.device not in encoders or error.bound is None:
        return None
    return f"{error.device} is wrong, or {moved} was pushed or struck while empty chambers held it"
