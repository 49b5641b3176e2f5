"""What every scene does with the rows of its mechanism's log."""

import math

import numpy as np
from numpy.typing import NDArray

from rig.assembly import REGISTRY
from rig.hal.scene import Scene
from rig.testing.of_experiment import OfExperiment
from rig.testing.rehearsal import Rehearsal


class SceneSuite(OfExperiment):
    """The picture of an experiment's rig, over a stretch of it in simulation."""

    def test_every_shape_has_its_points_in_every_row(self, rehearsal: Rehearsal) -> None:
        scene, values = _scene(rehearsal), _values(rehearsal)
        placed = scene.place(lambda name: _column(rehearsal, values, name))
        assert len(placed) == len(scene.shapes)
        for shape, points in zip(scene.shapes, placed, strict=True):
            assert np.shape(points) == (len(values), shape.points, 3), shape.name
            assert np.isfinite(points).all(), shape.name

    def test_one_row_is_placed_as_among_others(self, rehearsal: Rehearsal) -> None:
        scene, values = _scene(rehearsal), _values(rehearsal)
        all_rows = scene.place(lambda name: _column(rehearsal, values, name))
        last = scene.place(lambda name: _column(rehearsal, values[-1:], name))
        for one, many in zip(last, all_rows, strict=True):
            assert np.allclose(one[0], many[-1], atol=1e-12)

    def test_what_moves_is_within_what_the_camera_shows(self, rehearsal: Rehearsal) -> None:
        scene, values = _scene(rehearsal), _values(rehearsal)
        placed = scene.place(lambda name: _column(rehearsal, values, name))
        for shape, points in zip(scene.shapes, placed, strict=True):
            if shape.role == "reading" and not scene.follows:
                away = np.linalg.norm(points - np.asarray(scene.centre), axis=2)
                assert away.max() <= 2.0 * scene.size, shape.name

    def test_tones_and_follows_name_what_there_is(self, rehearsal: Rehearsal) -> None:
        scene = _scene(rehearsal)
        names = {column.name for column in rehearsal.columns}
        for shape in scene.shapes:
            assert not shape.tone or shape.tone in names
            assert shape.tone_range[0] < shape.tone_range[1]
        assert not scene.follows or scene.follows in {shape.name for shape in scene.shapes}

    def test_panes_are_of_one_unit_and_have_columns(self, rehearsal: Rehearsal) -> None:
        units = {column.name: column.unit for column in rehearsal.columns}
        for pane in _scene(rehearsal).panes:
            known = {units[name] or "1" for name in pane.columns if name in units}
            assert len(known) == 1, pane.title

    def test_limits_are_in_their_order(self, rehearsal: Rehearsal) -> None:
        for name, (low, high) in _scene(rehearsal).bounds.items():
            assert low < high, name
            assert not math.isnan(low + high)


def _scene(rehearsal: Rehearsal) -> Scene:
    profile = rehearsal.plan.profile
    kind = REGISTRY.scene(profile.mechanism)
    assert kind is not None
    return kind(profile.mechanism_settings)


def _values(rehearsal: Rehearsal) -> "NDArray[np.float64]":
    return np.asarray(rehearsal.rows[:: max(len(rehearsal.rows) // 50, 1)], float)


def _column(
    rehearsal: Rehearsal, values: "NDArray[np.float64]", name: str
) -> "NDArray[np.float64]":
    index = [column.name for column in rehearsal.columns].index(name)
    column: NDArray[np.float64] = values[:, index]
    return column
