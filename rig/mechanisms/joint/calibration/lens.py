"""Lens of a joint's camera, from views of a board that somebody shows it by hand.

Nothing moves. Without views the default lens of the profile stays in force: good for a start, but
the camera's distance is then only as right as its focal length.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.calibration.estimates import interval
from rig.calibration.procedure import Finding, Panel
from rig.calibration.recording import CalibrationRefused
from rig.config import Profile
from rig.mechanisms.joint.calibration.board_lens import Board, Views, fit_lens, project

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_BOUND: Final = 0.3
"""Rms of a corner, pixels: above, the board is not flat or the images are not sharp."""


class Lens:
    """Focal lengths, principal point and radial distortion."""

    name = "lens"
    title = "lens of the camera, from views of a chessboard"

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the camera's file, if there is a camera."""
        camera = profile.mechanism_settings.camera
        return () if camera is None else (camera,)

    def find(self, profile: Profile, views: Views, board: Board) -> Sequence[Finding]:
        """Return what the views say of the lens.

        Raises
        ------
        CalibrationRefused
            The images are not those of this camera, or do not determine the lens.
        """
        (device,) = self.targets(profile)
        settings = profile.devices[device].settings
        if views.size != (settings.width, settings.height):
            raise CalibrationRefused(
                f"the images have {views.size[0]} x {views.size[1]} pixels, {device} has "
                f"{settings.width} x {settings.height}: a lens holds for one size"
            )
        found = fit_lens(views, board, settings.intrinsics)
        count, corners, _ = found.residuals.shape
        # Six of the lens, six of each view's pose.
        freedom = 2.0 * count * corners - 6.0 * (count + 1)
        units = dict.fromkeys(found.values, "1")
        estimates = [
            interval(name, value, units[name], found.stds[name], freedom)
            for name, value in found.values.items()
        ]
        blank = views.seen - count
        notes = (f"the whole board in {blank} of {views.seen} images",) if blank else ()
        written = {name: float(f"{value:.9g}") for name, value in found.values.items()}
        straight = {"p1": 0.0, "p2": 0.0, "k3": 0.0}
        return (
            Finding(
                device, {"intrinsics": {**written, **straight}}, estimates,
                found.residuals.ravel(), "pixels", _BOUND, count,
                _panels(views, board, found.residuals, project(views, board, settings.intrinsics)),
                notes=notes,
            ),
        )  # fmt: skip


def _panels(
    views: Views,
    board: Board,
    residuals: "Array",
    before: "Array",
) -> list[Panel]:
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
