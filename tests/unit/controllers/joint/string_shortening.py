"""Taut strings around a ball, found by pulling: this knows nothing of great circles."""

import numpy as np

COARSEST, FINEST = 25, 800


def shortest_strings(starts, ends, radius):
    """Return the lengths of the shortest strings outside a ball, one per start and end.

    Chains of points are relaxed towards equal links (successive over-relaxation, every second
    point at a time) and pushed out of the ball, on ever finer chains. At the finest the links cut
    into the ball by a relative 3e-7 at most.
    """
    starts, ends = np.asarray(starts), np.asarray(ends)
    count = COARSEST
    chains = np.linspace(starts, ends, count + 1)
    while True:
        push_out(chains, radius)
        relaxation = 2.0 / (1.0 + np.sin(np.pi / count))
        for _ in range(4 * count):
            for first in (1, 2):
                middle = slice(first, count, 2)
                before = chains[first - 1 : count - 1 : 2]
                after = chains[first + 1 : count + 1 : 2]
                chains[middle] += relaxation * (0.5 * (before + after) - chains[middle])
                push_out(chains[middle], radius)
        if count >= FINEST:
            return np.linalg.norm(np.diff(chains, axis=0), axis=-1).sum(axis=0)
        finer = np.empty((2 * count + 1, *chains.shape[1:]))
        finer[::2] = chains
        finer[1::2] = 0.5 * (chains[1:] + chains[:-1])
        chains, count = finer, 2 * count


def push_out(points, radius):
    """Move points that are inside the ball to its surface."""
    distances = np.sqrt(np.einsum("...k,...k->...", points, points))[..., None]
    points *= np.maximum(1.0, radius / distances)
