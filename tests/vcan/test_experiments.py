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
    rate: str = "200 Hz"
    """Of the loop: user-mode Linux takes 60 µs for a system call, and there is one processor."""


CASES = (
    Case("cylinder", "cylinder-step", "vcan0"),
    Case("joint", "joint-circle", "vcan1"),
    Case("arm", "arm-wrist-hit", "vcan3"),
    Case("arm-odrive", "arm-wrist-hit", "vcan4"),
    Case("legs-can", "legs-squat", "vcan5,vcan6"),
)


@pytest.fixture(scope="module")
def started(tmp_path_factory, request):
    """All that are wanted, at the same time: each is on links of its own."""
    wanted = [
        item.callspec.params["case"]
        for item in request.session.items
        if item.fspath == request.fspath
    ]
    programs = {}
    try:
        for case in wanted:
            options = ["--set", f"loop.rate={case.rate}"]
            programs[case, "simulation"] = simulate(case.rig, case.on, *options)
        for case in wanted:
            options = ["--set", f"loop.rate={case.rate}"]
            out = tmp_path_factory.mktemp(case.rig)
            run = Program(
                "run", case.experiment, "--rig", case.rig, "--on", case.on, "--no-report",
                "--out", out, *options,
            )  # fmt: skip
            run.out = out
            programs[case, "run"] = run
            run.wait_for("run …")  # what starts must not disturb what is being armed
        yield programs
    finally:
        for program in programs.values():
            program.__exit__()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.rig)
def test_experiment_within_its_bounds(case, started):
    run, simulation = started[case, "run"], started[case, "simulation"]
    assert run.end() == 0, run.talk
    assert simulation.stop() == 0, simulation.talk
    manifest, _ = only_run(run.out)
    assert manifest["status"] == "ok"
    assert manifest["backend"] == "vcan"
    sys.stdout.write("\n".join(["", *run.printed, ""]))
    for counts in manifest["buses"].values():
        assert counts["refused"] == counts["error_frames"] == 0
        assert counts["frames_in"] > 1000
