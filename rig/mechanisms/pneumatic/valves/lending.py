"""A plant on valves with its inner loops, lent as one on regulators is: for compiled loops."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.compiled import KernelMemory, let_kernels_call
from controllers.cylinder.pressure_loop import PressureLoop
from rig.hal.plant import LentPlant

Kernel = Callable[..., None]
Bytes = NDArray[np.uint8]
Array = NDArray[np.float64]


def through_loops(lent: LentPlant, loops: Sequence[PressureLoop]) -> LentPlant:
    """Return a plant that takes wanted pressures for one that takes openings.

    Parameters
    ----------
    lent : LentPlant
        Of valves.
    loops : sequence of PressureLoop
        Of its chambers, as they are to begin. They are copied.
    """
    memories = [KernelMemory(loop) for loop in loops]
    kind = memories[0].kind
    laid = np.concatenate([memory.bytes for memory in memories])
    openings = np.zeros(len(loops))
    exchange = _exchange(lent.exchange, kind)
    return LentPlant(exchange, (laid, openings, lent.memory), lent.channels)


@cache
def _exchange(inner: Kernel, kind: "np.dtype[np.void]") -> Kernel:
    import numba

    let_kernels_call()
    step = PressureLoop.step

    def exchange(
        memory: tuple[Bytes, Array, object], setpoints: Array, seen: Array, truth: Array
    ) -> None:  # pragma: no cover - compiled
        laid, openings, plant = memory
        loops = laid.view(kind)
        count = len(loops)
        for k in range(count):
            openings[k] = step(loops[k], setpoints[k], seen[count + k], seen[k])
        inner(plant, openings, seen, truth)

    return cast(Kernel, numba.njit(error_model="numpy")(exchange))
