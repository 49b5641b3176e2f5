"""Compilation of the plants' kernels, with a cache that cannot go stale.

Numba's file cache watches only the file of the cached function: after a change in a function
that it calls, from another file, it would go on using the old machine code. So only whole
kernels are cached, and each closes over a digest of the sources of this folder, because the
values that a function closes over are part of numba's cache key.
"""

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from controllers.kernel_files import kept_kernel

Function = TypeVar("Function", bound=Callable[..., object])

_NOTHING = 1e-100
"""In SI units of anything: added to what is there, it changes no digit."""

Record = Any
"""A record of a structured array; numpy has no static type for one."""


def inlined(function: Function) -> Function:
    """Compile a function that kernels call; alone it costs nothing until it is called."""
    return cast(Function, numba.njit(error_model="numpy")(function))


def cached_kernel(build: Callable[[int], Function]) -> Function:
    """Compile the kernel that `build` makes, from the cache if the sources did not change.

    Parameters
    ----------
    build : callable
        Takes the digest of the sources and returns a function that refers to it.

    Returns
    -------
    callable
        The compiled kernel. Where no cache can be written it is compiled in each process.
    """
    return kept_kernel(build(_digest_of_sources()))


def _digest_of_sources() -> int:
    digest = 0
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest = zlib.crc32(path.read_bytes(), digest)
    return digest


@inlined
def vanish(value: float) -> float:
    """Return what decays towards 0, or 0 where nothing of it shows any more.

    Else it would stay among the numbers near 0 that processors take ten times as long with.
    """
    return value if abs(value) > _NOTHING else 0.0
