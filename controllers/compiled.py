"""Compilation of the few functions that Python is measured to be too slow for."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Compile a function, from the cache if its file did not change.

    Numba's cache watches the file of the function alone: what it calls has to be in the same
    file, or changes there would go unnoticed.
    """
    try:
        return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # numba found no folder that it may write to
        return cast(Function, numba.njit(error_model="numpy")(function))
