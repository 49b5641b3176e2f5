"""The mechanism's scene, row by row, as numbers for the page."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rig.assembly import REGISTRY
from rig.config import load_profile
from rig.hal import ConfigurationError
from rig.hal.columns import Column
from rig.hal.scene import Pane, Scene, Shape

if TYPE_CHECKING:
    from numpy.typing import NDArray

Plain = dict[str, object]


class Picture:
    """The scene of one run; without one, the scope is all that there is.

    Parameters
    ----------
    run : Path
        The run's folder, whose profile says what the mechanism is.
    columns : sequence of Column
        Of its log.

    Attributes
    ----------
    trouble : str or None
        Why there is no scene.
    bounds : list of tuple
        Index of a column, least and greatest permitted value.
    """

    def __init__(self, run: Path, columns: Sequence[Column]) -> None:
        self._index = {column.name: k for k, column in enumerate(columns)}
        self._scene: Scene | None = None
        self.trouble: str | None = None
        self.bounds: list[tuple[int, float, float]] = []
        try:
            self._scene = scene_of(run)
        except (ConfigurationError, OSError) as error:
            self.trouble = str(error)
        if self._scene is None:
            return
        self.bounds = [
            (self._index[name], low, high)
            for name, (low, high) in self._scene.bounds.items()
            if name in self._index
        ]
        try:
            self.frames(np.zeros((2, len(columns))))
        except Exception as error:  # whoever's scene it is: the page goes on without it
            self.trouble = f"the scene cannot be drawn: {type(error).__name__}: {error}"
            self._scene.shapes = ()

    @property
    def is_drawn(self) -> bool:
        """Whether there is anything to be drawn."""
        return self._scene is not None and bool(self._scene.shapes)

    def described(self) -> Plain:
        """Return what the page has to know of the scene beside its points."""
        scene = self._scene
        if scene is None:
            return {"shapes": [], "panes": [], "bounds": [], "trouble": self.trouble}
        return {
            "shapes": [_described_shape(shape) for shape in scene.shapes],
            "panes": [self._described_pane(pane) for pane in scene.panes],
            "bounds": [
                [k, low if np.isfinite(low) else None, high if np.isfinite(high) else None]
                for k, low, high in self.bounds
            ],
            "centre": list(scene.centre),
            "size": scene.size,
            "follows": scene.follows,
            "trouble": self.trouble,
        }

    def frames(self, values: "NDArray[np.float64]") -> "NDArray[np.float32]":
        """Return the scene in some rows.

        Parameters
        ----------
        values : ndarray, shape (n, k)
            Rows of the log.

        Returns
        -------
        ndarray, shape (n, m)
            The coordinates of all points, shape by shape, and then the tone of each shape that
            has one.
        """
        scene, rows = self._scene, len(values)
        if scene is None or not scene.shapes:
            return np.empty((rows, 0), np.float32)

        def column(name: str) -> "NDArray[np.float64]":
            return values[:, self._index[name]]

        points = [np.asarray(place).reshape(rows, -1) for place in scene.place(column)]
        expected = [3 * shape.points for shape in scene.shapes]
        if [place.shape[1] for place in points] != expected:
            raise ValueError("place() gives other points than shapes says")
        tones = [column(shape.tone)[:, None] for shape in scene.shapes if shape.tone]
        return np.concatenate([*points, *tones], axis=1).astype(np.float32)

    def margins(self, values: "NDArray[np.float64]", most: int = 3) -> list[tuple[int, float]]:
        """Return the columns that are nearest to their limits in some rows, shape (n, k).

        Beside each: how far it is at least, 1 in the middle or at nothing, 0 on the limit.
        """
        found = []
        for k, low, high in self.bounds:
            column = values[:, k]
            if np.isfinite(low) and np.isfinite(high):
                far = np.minimum(column - low, high - column) / max(0.5 * (high - low), 1e-300)
            elif np.isfinite(high) and high > 0.0:
                far = 1.0 - column / high
            else:
                continue
            found.append((k, min(float(np.nanmin(far, initial=1.0)), 1.0)))
        return sorted(found, key=lambda margin: margin[1])[:most]

    def _described_pane(self, pane: Pane) -> Plain:
        known = [self._index[name] for name in pane.columns if name in self._index]
        return {"title": pane.title, "columns": known}


def scene_of(run: Path) -> Scene | None:
    """Return the scene of a run's mechanism; None: it has none."""
    profile = load_profile(run / "profile.yaml", REGISTRY)
    kind = REGISTRY.scene(profile.mechanism)
    return None if kind is None else kind(profile.mechanism_settings)


def _described_shape(shape: Shape) -> Plain:
    return {
        "name": shape.name,
        "kind": shape.kind,
        "role": shape.role,
        "points": shape.points,
        "width": shape.width,
        "radius": shape.radius,
        "trail": shape.trail,
        "tone": shape.tone,
        "range": list(shape.tone_range),
    }
