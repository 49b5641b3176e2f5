"""Compilation of the few functions that Python is measured to be too slow for.

Numba is imported by what compiles, not here, because of what it takes to start.
"""

import zlib
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Concatenate, Generic, ParamSpec, TypeVar, cast

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Value = bool | float | tuple["Value", ...]

Function = TypeVar("Function", bound=Callable[..., object])

_SHARED = (Path(__file__).parent, Path(__file__).parent / "singularity")
"""Folders of what kernels of several rigs call."""

_WAITING: list[Callable[..., object]] = []


def inlined(function: Function) -> Function:
    """Let kernels call this function.

    It is left as it is: called from Python it runs as Python, called from a kernel it is compiled
    with it. So one source serves planning and tests, where starting a compiler costs more than it
    saves, and the cycle, where it saves most.
    """
    _WAITING.append(function)
    return function


class PlainNumbers:
    """An object of numbers alone, which `KernelMemory` lays out for kernels.

    Its attributes are numbers, booleans, tuples or lists of numbers, or objects like it. What a
    kernel changes is a number or a list.
    """


Numbers = TypeVar("Numbers", bound=PlainNumbers)
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class KernelMemory(Generic[Numbers]):
    """An object's numbers laid out in memory, where kernels read and write them by their names.

    An `inlined` function or method that takes the object takes a record of this memory as well: so
    one source serves Python, tests and kernels. The record is handed over as plain bytes, because
    numba takes longer to recognise a structured array than many a law to run.

    Parameters
    ----------
    numbers : PlainNumbers
        It is copied, and stays as it is whatever kernels do.
    """

    def __init__(self, numbers: Numbers) -> None:
        self.kind = record_type(numbers)
        """Of the record."""
        self.bytes = _bytes_of(numbers, self.kind)
        """The record; a kernel sees it as ``bytes.view(kind)[0]``."""

    def lay(self, numbers: Numbers) -> None:
        """Copy the numbers of an object of the same kind anew."""
        self.bytes[:] = _bytes_of(numbers, self.kind)

    def change(self, before: Numbers, after: Numbers) -> None:
        """Change what two objects differ in that are both as they were made.

        What kernels remember is the same in both, and stays. What differs are constants, which no
        kernel changes: the memory has those of `before`, and has those of `after` from now on.
        """
        old, new = _bytes_of(before, self.kind), _bytes_of(after, self.kind)
        differs = old != new
        self.bytes[differs] = new[differs]

    def bind(
        self, function: Callable[Concatenate[Numbers, Arguments], Result]
    ) -> Callable[Arguments, Result]:
        """Return an `inlined` function compiled, with this memory for its first argument."""
        return partial(kernel_of(function, self.kind), self.bytes)


def record_type(numbers: PlainNumbers) -> "np.dtype[np.void]":
    """Return the structured type of `KernelMemory`: its fields are the object's attributes.

    Whole numbers are floating-point there, so that the type does not depend on what they are now.

    Raises
    ------
    TypeError
        An attribute is neither a number, nor numbers, nor an object like it.
    """
    import numpy as np

    fields: list[tuple[str, np.dtype[np.void] | type, tuple[int, ...]]] = []
    for name, value in vars(numbers).items():
        if isinstance(value, PlainNumbers):
            fields.append((name, record_type(value), ()))
        elif isinstance(value, bool):
            fields.append((name, np.bool_, ()))
        elif np.asarray(value).dtype.kind in "fi":
            fields.append((name, np.float64, np.shape(value)))
        else:
            raise TypeError(f"{type(numbers).__name__}.{name} is {value!r}, which is no number")
    return np.dtype(fields, align=True)


def change_constants(numbers: PlainNumbers, before: PlainNumbers, after: PlainNumbers) -> None:
    """Do to an object what `KernelMemory.change` does to a memory of its kind."""
    for name, old in vars(before).items():
        new = getattr(after, name)
        if isinstance(old, PlainNumbers):
            change_constants(getattr(numbers, name), old, new)
        elif old != new:
            setattr(numbers, name, new)


def _bytes_of(numbers: PlainNumbers, kind: "np.dtype[np.void]") -> "NDArray[np.uint8]":
    import numpy as np

    return np.array([_values(numbers)], kind).view(np.uint8)


def _values(numbers: PlainNumbers) -> "tuple[Value, ...]":
    return tuple(
        _values(value) if isinstance(value, PlainNumbers) else value
        for value in vars(numbers).values()
    )


def let_kernels_call() -> None:
    """Make everything that is `inlined` callable by functions that numba compiles."""
    from numba.extending import register_jitable

    while _WAITING:
        register_jitable(error_model="numpy")(_WAITING.pop())


@cache
def kernel_of(function: Function, kind: "np.dtype[np.void]") -> Function:
    """Return an `inlined` function compiled for memory, once in a process, or from the cache.

    Parameters
    ----------
    function : callable
        What it calls has to be in its folder or in what is shared: numba's own cache watches no
        file but the kernel's, so a digest of these sources is part of the kernel's key. Where no
        cache can be written it is compiled in each process.
    kind : dtype
        The `record_type` of the memory that the kernel takes for its first argument.
    """
    from controllers.kernel_files import kept_kernel

    let_kernels_call()
    digest = _digest(Path(function.__code__.co_filename).parent)

    def kernel(memory: "NDArray[np.uint8]", *arguments: object) -> object:
        _ = digest
        return function(memory.view(kind)[0], *arguments)

    return cast(Function, kept_kernel(kernel))


def _digest(folder: Path) -> int:
    digest = 0
    for shared in (folder, *_SHARED):
        for path in sorted(shared.glob("*.py")):
            digest = zlib.crc32(path.read_bytes(), digest)
    return digest
