"""What a pair of limits must be, said where its type is: a profile tells it beside all the rest."""

from typing import NamedTuple


class Rising(NamedTuple):
    """Metadata of an annotated pair: the first number is below the second.

    A check in ``__post_init__`` would be told only when everything else of the mapping is right.

    Parameters
    ----------
    name : str
        Of the limits, for the message.
    """

    name: str

    def check(self, pair: tuple[float, float]) -> tuple[float, float]:
        """Return the pair; ValueError if it does not rise."""
        lower, upper = pair
        if not lower < upper:
            raise ValueError(f"{self.name}: the lower limit {lower:g} is not below {upper:g}.")
        return pair
