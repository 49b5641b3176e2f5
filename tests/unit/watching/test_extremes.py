"""However long a run is: what stuck out for one cycle is seen on a screen, in bounded memory."""

import numpy as np

from rig.watching.extremes import Extremes

COLUMNS = np.arange(3)


def spiky(chance, n, spikes):
    values = chance.normal(size=(n, 3)) * 1e-3
    places = chance.choice(n, spikes, replace=False)
    heights = np.where(chance.random(spikes) < 0.5, -1.0, 1.0) * chance.uniform(5.0, 9.0, spikes)
    values[places, 1] = heights
    return values, places, heights


def test_the_whole_of_a_long_run_shows_every_stretch_as_it_was():
    """Added by random pieces, and against a search through all rows."""
    chance = np.random.default_rng(9)
    n = 700_000
    values, _, _ = spiky(chance, n, 1000)
    t = np.arange(n, dtype=float)
    kept = Extremes(3)
    done = 0
    while done < n:
        step = int(chance.integers(1, 3000))
        kept.add(t[done : done + step], values[done : done + step])
        done += step
    assert kept.count == n
    begun = int(chance.integers(0, n // 2))
    for first, last, most in ((0, n, 2000), (begun, begun + 90_000, 1200), (n - 5, n, 100)):
        at, extremes = kept.between(first, last, COLUMNS, most)
        assert 0 < len(at) <= most + 2
        edges = np.append(at[::2], last if last < n else n).astype(int)
        for k in range(len(edges) - 2):
            here = values[edges[k] : edges[k + 1]].astype(np.float32)
            assert np.array_equal(extremes[2 * k], here.min(axis=0))
            assert np.array_equal(extremes[2 * k + 1], here.max(axis=0))
    # No stretch of the overview is wider than a pixel of a screen of 2000 points is.
    assert np.diff(kept.between(0, n, COLUMNS, 2000)[0][::2]).max() <= 2.2 * n / 2000


def test_memory_does_not_grow_with_the_run():
    kept = Extremes(4, capacity=64)
    sizes = set()
    for _ in range(50):
        kept.add(np.zeros(5000), np.zeros((5000, 4)))
        sizes.add(kept._least.nbytes + kept._most.nbytes + kept._start.nbytes)
    assert len(sizes) == 1
    assert kept.stretch >= 250_000 / 64


def test_what_is_not_a_number_hides_nothing():
    kept = Extremes(1)
    values = np.full((160, 1), np.nan)
    values[77] = 3.0
    kept.add(np.arange(160.0), values)
    assert np.nanmax(kept.between(0, 160, np.array([0]), 8)[1]) == 3.0
