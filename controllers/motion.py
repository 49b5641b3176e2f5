"""What a law that plans a whole motion says when the motion cannot be done."""


class InfeasibleMotion(ValueError):
    """The requested motion cannot be done; nothing has moved.

    The message is a full sentence that names the number, its unit and its bound, and where there
    is one the least change of the request that would do.
    """
