"""Views of a board before a simulated camera: what somebody would show it by hand."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from rig.calibration.arrays import Array
from rig.config import Profile
from rig.mechanisms.joint.calibration.board_lens import Board
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder

VIEWS: Final = "views"
_COUNT: Final = 14


def simulate_views(profile: Profile, device: str, board: Board, out: Path) -> Path:
    """Render views of a board into a run folder, and return it."""
    import cv2

    from rig.assembly.simulated import board_renderer

    seed = profile.simulation.seed
    folder = RunFolder.create(out, "calibrate-lens", "virtual", inputs={}, seed=seed)
    (folder.path / VIEWS).mkdir()
    render = board_renderer(profile, device, board.columns, board.rows, board.square)
    for number, (turn, place) in enumerate(_poses(profile, device, board, seed)):
        cv2.imwrite(str(folder.path / VIEWS / f"{number:02d}.png"), render(turn, place))
    folder.finish(RunStatus.OK, 0)
    return folder.path


def _poses(profile: Profile, device: str, board: Board, seed: int) -> Iterator[tuple[Array, Array]]:
    """Yield where a hand holds the board: tilted to all sides, now here and now there."""
    settings = profile.devices[device].settings
    generator = np.random.default_rng([seed, 7])
    wide = board.columns * board.square
    near = 1.9 * wide * settings.intrinsics.fx / settings.width
    for k in range(_COUNT):
        distance = near * generator.uniform(1.0, 1.35)
        azimuth, tilt = 2.4 * k + generator.uniform(0.0, 0.5), generator.uniform(0.35, 0.7)
        spin = generator.uniform(-0.3, 0.3)
        room = 0.5 * distance / settings.intrinsics.fx
        free = (room * settings.width - 0.62 * wide, room * settings.height - 0.5 * wide)
        corner = np.array([(-1.0, 1.0)[k % 2], (-1.0, 1.0)[k // 2 % 2]])
        place = corner * np.maximum(free, 0.0) * generator.uniform(0.5, 1.0, 2)
        turn = np.array([tilt * np.cos(azimuth), tilt * np.sin(azimuth), spin])
        yield turn, np.array([*place, distance])
