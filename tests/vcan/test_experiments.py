"""An experiment of each rig within its bounds, as two processes on SocketCAN."""

import sys
from typing import NamedTuple

import pytest
from two_processes import Program, only_run, simulate

pytestmark = pytest.mark.vcan


class Case(NamedTuple):
    rig: str
    experiment: str
    on: str
    """The same for both processes."""


CASES = (
    Case("cylinder", "cylinder-step", "vcan0"),
    Case("joint", "joint-circle", "vcan1,vcan2"),
    Case("arm", "arm-wrist-hit", "vcan3"),
    Case("arm-odrive", "arm-wrist-hit", "vcan4"),
    Case("legs-can", "legs-squat", "vcan5,vcan6"),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.rig)
def test_experiment_within_its_bounds(case, tmp_path):
    run = ["run", case.experiment, "--rig", case.rig, "--on", case.on, "--out", tmp_path]
    with simulate(case.rig, case.on) as simulation, Program(*run, "--no-report") as program:
        code = program.end()
        sys.stdout.write("\n".join(["", *program.printed, ""]))
        assert code == 0, program.talk
        assert simulation.stop() == 0, simulation.talk
    manifest, _ = only_run(tmp_path)
    assert manifest["status"] == "ok"
    assert manifest["backend"] == "vcan"
    for counts in manifest["buses"].values():
        assert counts["refused"] == counts["error_frames"] == 0
        assert counts["frames_in"] > 1000
