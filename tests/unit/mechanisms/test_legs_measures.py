"""What the legs' measures say of a log whose robot stood anywhere at the start."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from rig.mechanisms.legs.measures import feet_astray_end, from_first_stance

ROWS = 9


def window_of(planned, measured):
    columns = {
        f"{source}.{leg}_foot_{axis}": feet[:, number, k]
        for source, feet in (("reference", planned), ("truth", measured))
        for number, leg in enumerate(("right", "left"))
        for k, axis in enumerate("xyz")
    }
    return SimpleNamespace(column=columns.__getitem__)


@pytest.mark.parametrize("seed", range(5))
def test_where_the_robot_stood_ready_is_no_part_of_its_walk(seed):
    rng = np.random.default_rng(seed)
    planned = rng.uniform(-0.2, 0.2, (ROWS, 2, 3))
    planned[0] = ((0.0, -0.039, 0.0), (0.0, 0.039, 0.0))
    turn, moved = rng.uniform(-math.pi, math.pi), rng.uniform(-1.0, 1.0, 3)
    s, c = math.sin(turn), math.cos(turn)
    frame = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
    off = rng.normal(size=3)
    off *= 0.007 / np.linalg.norm(off)
    measured = planned @ frame.T + moved
    measured[-1, 1] += frame @ off
    assert feet_astray_end([window_of(planned, measured)]) == pytest.approx(0.007, abs=1e-12)
    np.testing.assert_allclose(from_first_stance(planned), planned, atol=1e-15)
