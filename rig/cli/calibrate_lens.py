"""`rig calibrate RIG lens`: from images instead of a run."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.run_folder import RunFolder, RunStatus

if TYPE_CHECKING:
    from rig.calibration.session import Calibrated
    from rig.calibration.store import Circumstances
    from rig.config import Profile
    from rig.mechanisms.joint.calibration.board_lens import Board
    from rig.mechanisms.joint.calibration.lens import Lens


def preview_lens(lens: "Lens", board: "Board", source: Path | None, *, simulated: bool) -> None:
    """Say what will be looked at."""
    said = "simulated views" if simulated else "nothing: say --views FOLDER or VIDEO"
    click.echo(f"{lens.name}: {lens.title}", err=True)
    click.echo(
        f"  nothing moves; looks for a board of {board.columns} x {board.rows} squares of "
        f"{1e3 * board.square:g} mm in {said if source is None else source}",
        err=True,
    )


def calibrate_lens(
    lens: "Lens",
    profile: "Profile",
    board: "Board",
    source: Path | None,
    circumstances: "Circumstances",
    search: Sequence[Path],
    out: Path,
    *,
    simulated: bool,
    replace: bool,
) -> "Calibrated | None":
    """Find a lens and write it; None if there are no images, and the default lens stays.

    Raises
    ------
    CalibrationRefused
        The images do not suffice, or the fit is worse than the one in force.
    """
    from rig.calibration.session import keep
    from rig.mechanisms.joint.calibration.board_lens import read_views
    from rig.mechanisms.joint.calibration.board_views import VIEWS, simulate_views

    if source is not None:
        folder = RunFolder.create(out, "calibrate-lens", "images", inputs={})
        folder.finish(RunStatus.OK, 0, f"images of {source}")
        path = folder.path
    elif simulated:
        (device,) = lens.targets(profile)
        path = simulate_views(profile, device, board, out)
        source = path / VIEWS
    else:
        click.echo(
            f"no views of a board (--views): the lens of the profile {profile.name} stays in force",
            err=True,
        )
        return None
    views = read_views(source, board)
    findings = lens.find(profile, views, board)
    return keep(
        lens.name, findings, profile, views, path, circumstances, search[0], search, replace=replace
    )
