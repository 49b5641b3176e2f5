"""Importing this imports every module that a command may need, and what those need."""

import contextlib
import gc
import importlib
import pkgutil

import numba

for name in ("rig", "drivers", "controllers"):
    for module in pkgutil.walk_packages(importlib.import_module(name).__path__, f"{name}."):
        if not module.name.endswith("__main__"):
            with contextlib.suppress(ImportError):  # of a camera's own software, say
                importlib.import_module(module.name)

# The first function that numba compiles, or finds compiled, takes as long as all the imports.
numba.njit(lambda x: x)(0.0)
gc.collect()
gc.freeze()  # the processes share what is there already, as long as nobody looks through it
