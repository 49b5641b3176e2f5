"""What rounds: other libraries, or a processor of other instructions, may differ in last bits."""

import json
import math
import os
import platform

import numba
import numpy as np
import scipy
from replay.corpus_files import CORPUS

RECORDED = CORPUS / "arithmetic.json"
NEARLY = 1e-6
"""Of a command, relative or absolute in SI: what rounding comes to over a few hundred cycles."""


def arithmetic():
    """Return the versions and the instructions that decide how a number is rounded."""
    features = np.lib.introspect.opt_func_info(func_name="^sin$", signature="float64")
    return {
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
        "libc": " ".join(platform.libc_ver()),
        "kernels": os.environ.get("OPENBLAS_CORETYPE"),
        "sine": json.dumps(features, sort_keys=True),
    }


def is_as_recorded():
    """Return whether the corpus was recorded where numbers are rounded as here."""
    return json.loads(RECORDED.read_text()) == arithmetic()


def keep():
    """Note that what is recorded now was recorded here."""
    RECORDED.write_text(json.dumps(arithmetic(), indent=2) + "\n")


def nearly(one, other):
    """Return whether two numbers differ by no more than rounding."""
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) and math.isnan(other)
    return one == other or abs(one - other) <= NEARLY * max(1.0, abs(one))
