"""Compilation of what the arm computes in every cycle; the sources stay plain Python.

A function marked `inlined` is left as it is: called from Python it runs as Python, called from a
kernel it is compiled with it. So one source serves planning and tests, where starting a compiler
costs more than it saves, and the cycle, where it saves four fifths.
"""

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

_WAITING: list[Callable[..., Any]] = []


def inlined(function: Function) -> Function:
    """Let kernels call this function."""
    _WAITING.append(function)
    return function


def compile_kernel(build: Callable[[int], Function]) -> Function:
    """Compile the kernel that `build` makes, from the cache if the sources did not change.

    Parameters
    ----------
    build : callable
        Takes the digest of the sources and returns a function that closes over it. Numba's cache
        watches only the kernel's own file, but what a function closes over is part of its key.

    Returns
    -------
    callable
        The compiled kernel. Where no cache can be written it is compiled in each process.
    """
    import numba
    from numba.extending import register_jitable

    while _WAITING:
        register_jitable(error_model="numpy")(_WAITING.pop())
    function = build(_digest_of_sources())
    try:
        return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # numba found no folder that it may write to
        return cast(Function, numba.njit(error_model="numpy")(function))


def _digest_of_sources() -> int:
    digest = 0
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest = zlib.crc32(path.read_bytes(), digest)
    return digest
