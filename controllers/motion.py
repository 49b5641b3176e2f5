"""What a law that plans a whole motion says when the motion cannot be done."""


class InfeasibleMotion(ValueError):
    """The requested motion cannot be done; nothing has moved.

    The message is a full sentence that names the number, its unit and its bound, and where there
    is one the least change of the request that would do.
    """


class LongMotion(InfeasibleMotion):
    """The requested motion takes longer than is permitted.

    Attributes
    ----------
    duration : float
        At least so long it takes, s.
    """

    def __init__(self, message: str, duration: float) -> None:
        super().__init__(message)
        self.duration = duration


def check_length(duration: float, longest: float) -> None:
    """Raise if a motion takes too long: its plan would not fit into memory, or never end.

    Parameters
    ----------
    duration : float
        At least so long it takes, s.
    longest : float
        That is permitted, s.

    Raises
    ------
    LongMotion
        With both.
    """
    if not duration <= longest:
        raise LongMotion(
            f"the motion takes at least {duration:.4g} s, the longest that is permitted is "
            f"{longest:g} s.",
            duration,
        )
