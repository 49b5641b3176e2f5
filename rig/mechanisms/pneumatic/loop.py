"""What a linear model says of the loop around a pair of cylinders."""

from controllers.cylinder.law import AnyPairLaw
from rig.hal.closed_loop import ClosedLoop


def loop_of(law: AnyPairLaw) -> ClosedLoop:
    """Return the margins of a pair's law on the pair that it was told of."""
    from controllers.cylinder.margins import loop_margins  # with numpy, which `rig check` spares

    return ClosedLoop(*loop_margins(law, law.model))
