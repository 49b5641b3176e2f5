"""What the simulated ends of all buses share: their world, and messages that get lost."""

import random
from collections.abc import Callable

Post = Callable[[float, Callable[[float], None]], None]
"""``post(delay, action)`` has an action done later, at its time."""


class LossyBus:
    """The simulated end of a bus that loses messages at random.

    Parameters
    ----------
    name : str
        The bus's name in the profile.

    Attributes
    ----------
    frame_loss : float
        Probability that a frame or packet is lost, each way.
    """

    _post: Post

    def __init__(self, name: str) -> None:
        self.name = name
        self.frame_loss = 0.0
        self._random = random.Random(0)
        self._now = 0.0

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` accepts."""
        return ("frame_loss",)

    def attach(self, post: Post, generator: random.Random) -> None:
        """Join a world, which does what is posted at its time."""
        self._post = post
        self._random = generator

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the bus itself happen.

        ``frame_loss`` (value: probability, default 1) loses messages at random from now on.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault != "frame_loss":
            raise ValueError(
                f"bus {self.name}: no fault {fault!r}; known are {', '.join(self.known_faults)}"
            )
        probability = 1.0 if value is None else value
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"bus {self.name}: frame_loss is 0 … 1, not {probability:g}")
        self.frame_loss = probability

    def _lost(self) -> bool:
        return self.frame_loss > 0.0 and self._random.random() < self.frame_loss
