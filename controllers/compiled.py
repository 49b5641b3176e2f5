"""Compilation of the few functions that Python is measured to be too slow for.

Numba is imported by what compiles, not here, because of what it takes to start.
"""

import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

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


def compile_kernel(build: Callable[[int], Function], *folders: Path) -> Function:
    """Compile the kernel that `build` makes, from the cache if the sources did not change.

    Parameters
    ----------
    build : callable
        Takes the digest of the sources and returns a function that closes over it. Numba's cache
        watches only the kernel's own file, but what a function closes over is part of its key.
    folders : Path
        Of the sources; that of `build` itself if none is given.

    Returns
    -------
    callable
        The compiled kernel. Where no cache can be written it is compiled in each process.
    """
    from numba.extending import register_jitable

    while _WAITING:
        register_jitable(error_model="numpy")(_WAITING.pop())
    return _compile(build(_digest(*folders or (Path(build.__code__.co_filename).parent,))))


def memory_of(thing: object, kind: "np.dtype[np.void]") -> "NDArray[np.uint8]":
    """Lay an object's numbers out in memory, where kernels read and write them by their names.

    A method that is `inlined` and works on numbers alone takes a record for its ``self`` as well,
    ``memory.view(kind)[0]``: so one source serves Python, tests and kernels. It is
    handed over as plain bytes, because numba takes longer to recognise a structured array than
    many a law to run.

    Parameters
    ----------
    thing : object
        Its attributes are numbers, booleans or objects like it.
    kind : dtype
        Its `record_type`, which takes ten times as long to find.

    Returns
    -------
    ndarray, shape (n,)
        Bytes of the record; it starts with the attributes' values.
    """
    import numpy as np

    return np.array([_values(thing)], kind).view(np.uint8)


def record_type(thing: object) -> "np.dtype[np.void]":
    """Return the structured type of `memory_of`: its fields are the object's attributes.

    Whole numbers are floating-point there, so that the type does not depend on what they are now.

    Raises
    ------
    TypeError
        An attribute is neither a number nor an object like it.
    """
    import numpy as np

    fields: list[Any] = []
    for name, value in vars(thing).items():
        if isinstance(value, bool):
            fields.append((name, np.bool_))
        elif isinstance(value, float | int):
            fields.append((name, np.float64))
        elif hasattr(value, "__dict__"):
            fields.append((name, record_type(value)))
        else:
            raise TypeError(f"{type(thing).__name__}.{name} is {value!r}, which is no number")
    return np.dtype(fields, align=True)


def _values(thing: object) -> tuple[Any, ...]:
    return tuple(
        _values(value) if hasattr(value, "__dict__") else value for value in vars(thing).values()
    )


def _compile(function: Function) -> Function:
    import numba

    try:
        return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # numba found no folder that it may write to
        return cast(Function, numba.njit(error_model="numpy")(function))


def _digest(*folders: Path) -> int:
    digest = 0
    for folder in (*folders, _SHARED):
        for path in sorted(folder.glob("*.py")):
            digest = zlib.crc32(path.read_bytes(), digest)
    return digest
