"""One online cycle of the gait's law beside one step of general inverse-kinematics libraries.

Ours is what runs in the loop: both legs in one system, twelve positions and rates out. The peers
solve for the same soles under the same waist, with the joints' rate limit, and integrate. Only the
step's own CPU time counts. What is not installed is skipped, with its name.
"""

import importlib
import time
from statistics import median

import numpy as np
import pytest
from gait_laws import LAWS
from gait_peers import DampedStep, MinkStep, PinkStep, PlacoStep

from controllers.gait.motions import WalkSettings
from controllers.gait.smooth import SmoothLaw
from controllers.gait.types import GaitModel, LegsState

PERIOD = 1e-3
ROUNDS = 3
OURS = 30e-6
SHIFT = slice(12_000, 18_000)
"""Both legs move, from one straight knee to the next."""
PEER_STEPS = 400
"""From the start of the shift."""

pytestmark = pytest.mark.benchmark

STANDING = LegsState(0.0, (0.0,) * 12, (0.0,) * 12)


def cycle_costs(law):
    """Return the CPU time of each update of a whole walk, s."""
    made = law.prepare(WalkSettings())
    reference = made.at(0.0)
    clock, update = time.perf_counter, law.update
    costs = []
    for _ in made.t:
        began = clock()
        update(STANDING, reference)
        costs.append(clock() - began)
    return costs


@pytest.mark.parametrize("kind", LAWS, ids=[kind.name for kind in LAWS])
def test_gait_cycle_cost(table, kind):
    rounds = []
    for _ in range(ROUNDS):
        law = kind(kind.Settings(), GaitModel(), PERIOD)
        costs = np.array(cycle_costs(law))
        rounds.append((float(np.median(costs[SHIFT])), float(np.median(costs))))
    shift, whole = (median(each) for each in zip(*rounds, strict=True))
    table(
        what=f"{kind.name}: one cycle",
        both_legs_us=1e6 * shift,
        walk_us=1e6 * whole,
        bound_us=1e6 * OURS,
    )
    assert shift <= OURS


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of what the peers import
@pytest.mark.parametrize(
    ("name", "modules", "make", "bound"),
    [
        ("mink", ("mink", "daqp"), MinkStep, 1.0 / 20.0),
        ("Pink", ("pinocchio", "pink", "daqp"), PinkStep, 1.0 / 20.0),
        ("placo", ("placo",), PlacoStep, 0.5),
        ("Pinocchio with damped least squares", ("pinocchio",), DampedStep, 0.5),
    ],
    ids=["mink", "pink", "placo", "pinocchio"],
)
def test_gait_cost_beside_a_peer(table, tmp_path, name, modules, make, bound):
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            pytest.skip(f"{name} needs {module}, which is not installed: {error}")
    law = SmoothLaw(SmoothLaw.Settings(), GaitModel(), PERIOD)
    plan = law.prepare(WalkSettings())
    ours, theirs = [], []
    for _ in range(ROUNDS):
        peer = make(plan, PERIOD, *[tmp_path] * (make is PlacoStep))
        first = SHIFT.start - 3000  # where the knee is not straight: what follows is theirs to do
        peer.start(plan.q[first])
        clock = time.perf_counter
        costs = []
        for sample in range(first, first + PEER_STEPS):
            began = clock()
            peer.step(sample)
            costs.append(clock() - began)
        # It is the same problem: they end up where we do.
        np.testing.assert_allclose(peer.angles, plan.q[first + PEER_STEPS - 1], atol=2e-3)
        theirs.append(median(costs))
        ours.append(float(np.median(cycle_costs(law)[SHIFT])))
    ratio = median(ours) / median(theirs)
    table(
        what=f"one step of {name}",
        us=1e6 * median(theirs),
        ours_us=1e6 * median(ours),
        ours_over_it=ratio,
        bound=bound,
    )
    assert ratio <= bound
