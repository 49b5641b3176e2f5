"""The arm's figures are shaded in the law's region, or where an index is below its bound."""

from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("agg")
from matplotlib.figure import Figure

from rig.hal.motion import Segment
from rig.mechanisms.arm.singular_band import mark_region

T = np.linspace(0.0, 10.0, 1001)


def run_of(*segments, settings=None, **indices):
    columns = {f"plan.index_{kind}": values for kind, values in indices.items()}
    return SimpleNamespace(
        segments=segments, time=T, has=lambda name: name in columns, trace=columns.__getitem__,
        law_settings=settings or {},
    )  # fmt: skip


def bands(run, **kinds):
    axes = Figure().subplots()
    mark_region(axes, run, **kinds)
    spans = [(p.get_x(), p.get_x() + p.get_width()) for p in axes.patches]
    return spans, axes.get_legend_handles_labels()[1]


def test_a_planned_region_is_all_that_is_shaded():
    run = run_of(Segment("all", 0, 10), Segment("region", 3, 4), elbow=0.0 * T)
    assert bands(run) == ([(3, 4)], ["singular region"])


@pytest.mark.parametrize(("settings", "width"), [({}, 0.05), ({"wrist_region": 0.2}, 0.2)])
def test_without_one_it_is_shaded_below_the_bound(settings, width):
    wrist = np.where(T < 8.0, np.abs(T - 2.0), 0.0)  # through at 2 s, and there from 8 s on
    run = run_of(settings=settings, wrist=-wrist, elbow=1.0 + T)
    spans, labels = bands(run, kinds=("wrist",))
    assert bands(run) == (spans, ["near singular"])
    assert labels == [f"near singular: $|S_5|$ < {width:g}"]
    assert spans == [
        pytest.approx((2.0 - width, 2.0 + width), abs=0.021), pytest.approx((8.0, 10.0), abs=0.011),
    ]  # fmt: skip


def test_a_panel_is_shaded_by_its_own_index():
    run = run_of(wrist=0.0 * T, shoulder=0.02 + T)
    assert bands(run, kinds=("elbow",)) == ([], [])
    spans, labels = bands(run)
    assert len(spans) == 2
    assert labels == ["near singular"]  # once, whatever is near
    assert bands(run, kinds=("shoulder",))[1] == ["near singular: $|c|$ < 0.03 m"]
    assert bands(run, kinds=("wrist",))[1] == ["near singular: $|S_5|$ < 0.05"]
