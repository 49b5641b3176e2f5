"""An experiment of each rig within its bounds, as two processes on SocketCAN."""

import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from two_processes import Program, only_run, set_all, simulate

pytestmark = pytest.mark.vcan


class Case(NamedTuple):
    rig: str
    experiment: str
    on: str
    """The same for both processes."""
    options: tuple[str, ...] = ()


# At their own rates, the joint at 1 kHz; what is repeated in an experiment is done once here.
CASES = (
    # A step ends where the seals hold it: within 0.6 mm nine times of ten, 1.1 mm off with frames
    # that take no time.
    Case("cylinder", "cylinder-sine", "vcan0"),
    Case("joint", str(Path(__file__).with_name("joint-lap.yaml")), "vcan1,vcan2"),
    Case("arm", "arm-wrist-hit", "vcan3"),
    Case("arm-odrive", "arm-wrist-hit", "vcan4"),
    Case("legs-can", "legs-squat", "vcan5,vcan6", set_all(reference__repeats=1)),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.rig)
def test_experiment_within_its_bounds(case, tmp_path):
    run = ["run", case.experiment, "--rig", case.rig, "--on", case.on, "--out", tmp_path]
    run += ["--no-report", *case.options]
    with simulate(case.rig, case.on) as simulation, Program(*run) as program:
        code = program.end()
        sys.stdout.write("\n".join(["", *program.printed, ""]))
        assert code == 0, program.talk
        assert simulation.stop() == 0, simulation.talk
    manifest, _ = only_run(tmp_path)
    assert manifest["status"] == "ok"
    assert manifest["backend"] == "vcan"
    for counts in manifest["buses"].values():
        assert counts["refused"] == counts["error_frames"] == counts["dropped"] == 0
        assert counts["frames_in"] > 1000
