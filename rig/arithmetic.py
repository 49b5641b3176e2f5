"""Which kernels multiply matrices: set before numpy is imported, the same on every processor."""

import os
import platform
from pathlib import Path

KERNELS = "Haswell"
"""Of OpenBLAS: every processor with AVX2 can run them, and all round alike with them."""

PROCESSORS = Path("/proc/cpuinfo")


def round_alike() -> None:
    """Let one experiment give the same numbers on every computer.

    OpenBLAS picks kernels by the processor, and they add in different orders. Where seals stick and
    slide, a last bit grows to a sixth of a figure within one motion. What is set already stays.
    """
    if _has_avx2():  # what cannot run a kernel would die of it, without a word
        os.environ.setdefault("OPENBLAS_CORETYPE", KERNELS)


def _has_avx2() -> bool:
    if platform.machine() not in ("x86_64", "AMD64"):
        return False
    try:
        with PROCESSORS.open() as lines:
            flags = next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return False
    return {"avx2", "fma"} <= set(flags.split())
