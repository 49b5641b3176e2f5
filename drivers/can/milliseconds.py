"""Times that a node is told in milliseconds."""


def check_milliseconds(name: str, seconds: float, told_by: str) -> None:
    """Raise if a node cannot be told a time, for it would keep another one.

    Parameters
    ----------
    name : str
        The setting.
    seconds : float
        Its value, s.
    told_by : str
        What takes it: an object, or a setting of the node.

    Raises
    ------
    ValueError
    """
    told = to_milliseconds(seconds)
    if abs(seconds * 1e3 - told) > 1e-6:
        raise ValueError(
            f"{name} ({seconds * 1e3:g} ms) is not a whole number of milliseconds, which is all "
            f"that {told_by} can hold; give {told} ms or another whole number."
        )


def to_milliseconds(seconds: float) -> int:
    """Return what a node is told of a time, ms: 1 at least, for 0 switches it off."""
    return max(1, round(seconds * 1e3))
