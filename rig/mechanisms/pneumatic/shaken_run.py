"""What the glides of a recorded run tell of the loop that a pair's law closes."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final

from controllers.cylinder.law import AnyPairLaw
from rig.hal import ConfigurationError
from rig.hal.measured_loop import Array, LoopUntold, MeasuredLoop
from rig.mechanisms.pneumatic.shaken_pair import ShakenLaw, ShakenPair

if TYPE_CHECKING:
    from rig.report.data import RunData

_ROUNDING: Final = 1e-6
"""s, of the times of cycles."""


def whole_glides(run: "RunData", signals: Array) -> Iterator[tuple[Array, Array]]:
    """Yield times from its beginning on, and signals, of each whole glide of a run.

    Parameters
    ----------
    run : RunData
        Its segments that are called ``"glide ..."`` count.
    signals : (n, 3) array
        What was sent, position, pressure, in each cycle.
    """
    t = run.time
    for segment in run.segments:
        if segment.name.startswith("glide") and t[-1] >= segment.end:
            part = (t >= segment.start - _ROUNDING) & (t < segment.end - _ROUNDING)
            yield t[part] - segment.start, signals[part]


def loop_of_glides(
    run: "RunData", frequencies: Array, glides: Iterable[tuple[Array, Array]], law: AnyPairLaw,
    what: str,
) -> MeasuredLoop:  # fmt: skip
    """Return the loop that a law closes around the pair that glides.

    Parameters
    ----------
    run : RunData
        That they are of.
    frequencies : (n,) array
        Of the shake, Hz.
    glides : iterable of (m,) and (m, 3) array
        As `whole_glides` yields.
    law : AnyPairLaw
        It is not changed, and need not be the one that ran.
    what : str
        That glides, in words.

    Raises
    ------
    ConfigurationError
        They are too few.
    LoopUntold
        They do not tell it.
    """
    path = run.folder.path
    try:
        pair = ShakenPair(frequencies, glides)
    except ValueError as error:
        raise ConfigurationError(f"{path}: {error}") from error
    try:
        return pair.under(ShakenLaw(law, frequencies))
    except ValueError as error:
        raise LoopUntold(
            f"{path}: {error}: {what} sticks, or swings by itself, while it glides"
        ) from error
