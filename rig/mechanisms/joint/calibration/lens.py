"""Lens of a joint's camera, from views of a board that somebody shows it by hand.

Nothing moves. Without views the default lens of the profile stays in force: good for a start, but
the camera's distance is then only as right as its focal length.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.estimates import interval
from rig.calibration.instruments import Readings
from rig.calibration.procedure import FilesOffered, Finding, Panel, Procedure
from rig.calibration.recording import CalibrationRefused, NoFiles
from rig.config import Profile
from rig.mechanisms.joint.calibration.board_lens import (
    Board,
    Views,
    fit_lens,
    project,
    read_views,
)
from rig.mechanisms.joint.calibration.board_views import VIEWS, simulate_views
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder

_BOUND: Final = 0.3
"""Rms of a corner, pixels: above, the board is not flat or the images are not sharp."""


class Lens(Procedure[Views]):
    """Procedure for focal lengths, principal point and radial distortion."""

    name = "lens"
    title = "lens of the camera, from views of a chessboard"

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the camera's file, if there is a camera."""
        camera = profile.mechanism_settings.camera
        return () if camera is None else (camera,)

    def describe_files(self, files: FilesOffered) -> Iterator[str]:
        """Yield which board is looked for, and where."""
        board = Board.parse(files.board)
        none = "simulated views" if files.simulated else "nothing: say --views FOLDER or VIDEO"
        yield (
            f"nothing moves; looks for a board of {board.columns} x {board.rows} squares of "
            f"{1e3 * board.square:g} mm in {none if files.source is None else files.source}"
        )

    def read_files(self, profile: Profile, files: FilesOffered) -> tuple[Views, Path]:
        """Return views of the board; see `Procedure.read_files`."""
        board, source = Board.parse(files.board), files.source
        if source is not None:
            folder = RunFolder.create(files.out, "calibrate-lens", "images", inputs={})
            folder.finish(RunStatus.OK, 0, f"images of {source}")
            return read_views(source, board), folder.path
        if not files.simulated:
            raise NoFiles(
                f"no views of a board (--views): the lens of the profile {profile.name} stays in "
                "force"
            )
        (device,) = self.targets(profile)
        path = simulate_views(profile, device, board, files.out)
        return read_views(path / VIEWS, board), path

    def identify(self, profile: Profile, data: Views, readings: Readings) -> Sequence[Finding]:
        """Return what the views say of the lens.

        Raises
        ------
        CalibrationRefused
            The images are not those of this camera, or do not determine the lens.
        """
        (device,) = self.targets(profile)
        settings = profile.devices[device].settings
        if data.size != (settings.width, settings.height):
            raise CalibrationRefused(
                f"the images have {data.size[0]} x {data.size[1]} pixels, {device} has "
                f"{settings.width} x {settings.height}: a lens holds for one size"
            )
        found = fit_lens(data, settings.intrinsics)
        count, corners, _ = found.residuals.shape
        # Six of the lens, six of each view's pose.
        freedom = 2.0 * count * corners - 6.0 * (count + 1)
        units = dict.fromkeys(found.values, "1")
        estimates = [
            interval(name, value, units[name], found.stds[name], freedom)
            for name, value in found.values.items()
        ]
        blank = data.seen - count
        notes = (f"the whole board in {blank} of {data.seen} images",) if blank else ()
        written = {name: float(f"{value:.9g}") for name, value in found.values.items()}
        straight = {"p1": 0.0, "p2": 0.0, "k3": 0.0}
        return (
            Finding(
                device, {"intrinsics": {**written, **straight}}, estimates,
                found.residuals.ravel(), "px", _BOUND, count,
                _panels(data, found.residuals, project(data, settings.intrinsics)),
                notes=notes,
            ),
        )  # fmt: skip


def _panels(views: Views, residuals: Array, before: Array) -> list[Panel]:
    """Return one panel across the image and one down it."""
    old = views.corners - before
    panels = []
    for k, (name, way) in enumerate((("x", "across"), ("y", "down"))):
        x = views.corners[..., k].ravel()
        misfit = old[..., k].ravel()
        panels.append(
            Panel(
                f"corners, {way}", f"{name} (pixels)", "less the lens before (pixels)",
                "residual (pixels)", x, misfit, misfit - residuals[..., k].ravel(),
                np.zeros_like(x),
            )
        )  # fmt: skip
    return panels
