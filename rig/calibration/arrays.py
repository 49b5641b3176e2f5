"""Short names of the arrays that fits work on."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int_]
Flags: TypeAlias = NDArray[np.bool_]
