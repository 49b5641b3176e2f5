"""Compilation of the few functions that Python is measured to be too slow for.

Numba is imported by what compiles, not here, because of what it takes to start.
"""

import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

_SHARED = Path(__file__).parent / "singularity"
"""What kernels of several rigs call."""

_WAITING: list[Callable[..., Any]] = []


def inlined(function: Function) -> Function:
    """Let kernels call this function.

    It is left as it is: called from Python it runs as Python, called from a kernel it is compiled
    with it. So one source serves planning and tests, where starting a compiler costs more than it
    saves, and the cycle, where it saves most.
    """
    _WAITING.append(function)
    return function


@cache
def kernel_of(function: Function) -> Function:
    """Return an `inlined` function compiled, once in a process; see `compile_kernel`.

    The cache is that of the function's folder: what it calls has to be there, or in what is
    shared.
    """

    def build(digest: int) -> Function:
        def kernel(*arguments: Any) -> Any:
            _ = digest
            return function(*arguments)

        return cast(Function, kernel)

    return compile_kernel(build, Path(function.__code__.co_filename).parent)


def compile_kernel(build: Callable[[int], Function], folder: Path | None = None) -> Function:
    """Compile the kernel that `build` makes, from the cache if the sources did not change.

    Parameters
    ----------
    build : callable
        Takes the digest of the sources and returns a function that closes over it. Numba's cache
        watches only the kernel's own file, but what a function closes over is part of its key.
    folder : Path, optional
        Of the sources; that of `build` itself if not given.

    Returns
    -------
    callable
        The compiled kernel. Where no cache can be written it is compiled in each process.
    """
    from numba.extending import register_jitable

    while _WAITING:
        register_jitable(error_model="numpy")(_WAITING.pop())
    return _compile(build(_digest(folder or Path(build.__code__.co_filename).parent)))


def _compile(function: Function) -> Function:
    import numba

    try:
        return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # numba found no folder that it may write to
        return cast(Function, numba.njit(error_model="numpy")(function))


def _digest(folder: Path) -> int:
    digest = 0
    for path in sorted((*folder.glob("*.py"), *_SHARED.glob("*.py"))):
        digest = zlib.crc32(path.read_bytes(), digest)
    return digest
