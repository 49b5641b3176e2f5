"""An experiment of each rig but the joint within its bounds, as two processes on SocketCAN."""

import sys
from typing import NamedTuple

import pytest
from two_processes import Program, only_run, set_all, simulate

pytestmark = pytest.mark.vcan


class Case(NamedTuple):
    rig: str
    experiment: str
    on: str
    """The same for both processes."""
    rate: str = "200 Hz"
    """Of the loop: user-mode Linux takes 60 µs for a system call, and there is one processor."""


# joint-circle holds its bounds at 1 kHz only, which user-mode Linux does not reach: two
# processes run it to its end (`README.md`), and its bounds are held with `--on virtual`.
CASES = (
    Case("cylinder", "cylinder-step", "vcan0"),
    Case("arm", "arm-wrist-hit", "vcan3"),
    Case("arm-odrive", "arm-wrist-hit", "vcan4"),
    Case("legs-can", "legs-squat", "vcan5,vcan6"),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.rig)
def test_experiment_within_its_bounds(case, tmp_path):
    rate = set_all(loop__rate=case.rate)
    run = ["run", case.experiment, "--rig", case.rig, "--on", case.on, "--out", tmp_path, *rate]
    with simulate(case.rig, case.on, *rate) as simulation, Program(*run, "--no-report") as program:
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
