"""All points of a sweep, by number: nothing of them is kept."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from rig.hal import ConfigurationError
from rig.sweeping.axis import SEED, Axis, DrawnAxis
from rig.sweeping.draws import draw_axes
from rig.sweeping.variations import Variations

AnyAxis = Axis | DrawnAxis | Variations

MAX_POINTS: Final = 1_000_000
"""Most points of a sweep: at a second each this is twelve days of one processor."""


@dataclass(frozen=True, slots=True)
class Design:
    """A grid of points: every combination of its blocks' rows, the first block slowest.

    Parameters
    ----------
    blocks : tuple of tuple of Axis or Variations
        The axes of a block vary together.
    """

    blocks: tuple[tuple[Axis | Variations, ...], ...]

    @property
    def axes(self) -> tuple[Axis | Variations, ...]:
        """All axes, in their order."""
        return tuple(axis for block in self.blocks for axis in block)

    @property
    def count(self) -> int:
        """How many points there are."""
        return math.prod(len(block[0].texts) for block in self.blocks)

    def texts(self, number: int) -> tuple[str, ...]:
        """Return the values of a point, in the order of the axes."""
        found: list[tuple[str, ...]] = []
        for block in reversed(self.blocks):
            number, row = divmod(number, len(block[0].texts))
            found.append(tuple(axis.texts[row] for axis in block))
        return tuple(text for block in reversed(found) for text in block)

    def options(self, number: int) -> tuple[str, ...]:
        """Return the settings of a point, as for ``--set``."""
        return self.options_of(self.texts(number))

    def options_of(self, texts: Sequence[str]) -> tuple[str, ...]:
        """Return the settings of values, one for each axis."""
        pairs = zip(self.axes, texts, strict=True)
        return tuple(option for axis, text in pairs for option in axis.options(text))


def make_design(axes: Sequence[AnyAxis], seeds: Axis | None = None, draw_seed: int = 0) -> Design:
    """Return the points of some axes: a grid of them, its draws and its seeds.

    Raises
    ------
    ConfigurationError
        A setting is varied twice, draws differ in number, or there are too many points.
    """
    settings = [axis.setting for axis in (*axes, *([seeds] if seeds else []))]
    settings += [name for axis in axes if isinstance(axis, Variations) for name in axis.varied]
    twice = next((name for name in settings if settings.count(name) > 1), None)
    if twice is not None:
        hint = "; --seeds varies it already" if twice == SEED and seeds else ""
        raise ConfigurationError(f"{twice} is varied twice{hint}")
    drawn = draw_axes([axis for axis in axes if isinstance(axis, DrawnAxis)], draw_seed)
    blocks = [(axis,) for axis in axes if not isinstance(axis, DrawnAxis)]
    design = Design(
        (*blocks, *((drawn,) if drawn else ()), *(((seeds,),) if seeds is not None else ()))
    )
    if design.count > MAX_POINTS:
        sizes = " x ".join(f"{len(block[0].texts):,}" for block in design.blocks)
        raise ConfigurationError(
            f"{sizes} are {design.count:,} points; a sweep has at most {MAX_POINTS:,}. "
            "Take fewer values, or draw some of the points: sobol:LOW..HIGH:N"
        )
    return design
