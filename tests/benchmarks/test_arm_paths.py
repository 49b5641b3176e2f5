"""Drawn paths through singularities: finished, within the limits, and as fast as can be."""

import arm_paths
import pytest


def check(seeds):
    for seed in seeds:
        kind, outcome, found, _ = arm_paths.judge(seed, ())
        told = f"seed {seed}, {kind}: {outcome} {found}"
        assert outcome == "done", told
        assert found["rate"] <= 1.001, told
        assert found["off"] < 1e-6, told
        if kind != "dwell":  # how long it lasts is asked for, and esc promises rates alone
            assert found["acceleration"] <= 1.001, told
            assert found["optimum"] <= 1.02, told


@pytest.mark.slow
def test_a_path_of_each_kind():
    check(range(len(arm_paths.KINDS)))


@pytest.mark.slow
def test_paths_with_two_near_misses_at_once_or_near_the_boundary():
    check((58, 115, 131, 148))
