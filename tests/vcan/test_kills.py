"""Programs that are killed, or not run for a while, at a drawn moment of each phase of a run.

The simulation in the other process lives on, and what was true of its plant judges the rig until
1.5 s after the program's death or end. ``KILLS_SEED`` draws other moments, and ``KILLS_EACH`` more
of them. A run that ended before its moment came is judged too, and then skipped.
"""

import os
import random
import signal
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from two_processes import Program, now, pause, set_all, simulate

from rig.assembly import REGISTRY
from rig.assembly.simulated import make_plant
from rig.config import load_profile
from rig.config.names import find_configs
from rig.faults.oracle import judge

pytestmark = [pytest.mark.vcan, pytest.mark.slow]

SEED, EACH = int(os.environ.get("KILLS_SEED", "0")), int(os.environ.get("KILLS_EACH", "1"))
AFTERMATH = 1.5
"""How long the world is watched after the program has ended or died, s."""
ENERGISE, APPROACH, RELEASE, AT_ONCE = 1.0, 2.0, 1.0, 0.01
"""How long a phase lasts, s."""
SHORTEST, LONGEST = 0.01, 0.5
"""For so long a program is not run, s."""


class Rig(NamedTuple):
    """One rig, what it does, and how long it takes to connect, s."""

    name: str
    experiment: str
    on: str
    connecting: float
    moves: float
    options: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    """Of both programs."""


LAP = str(Path(__file__).with_name("joint-lap.yaml"))
APPROACHES = set_all(approach="2 s")
RIGS = (
    Rig("cylinder", "cylinder-sine", "vcan0", 0.3, 2.0, settings=set_all(loop__rate="200 Hz")),
    Rig("joint", LAP, "vcan1,vcan2", 0.4, 2.0),
    Rig("arm", "arm-wrist-hit", "vcan3", 0.5, 1.5, APPROACHES),
    Rig("arm-odrive", "arm-wrist-hit", "vcan4", 0.6, 1.5, APPROACHES),
    Rig("legs-can", "legs-squat", "vcan5,vcan6", 0.9, 1.5, APPROACHES),
)
PHASES = ("connect", "energise", "approach", "run", "release", "stop")


def comes_to(phase, program, rig, draw):
    """Let a run go on to a drawn moment of a phase; return whether it came there."""
    try:
        _wait_for(phase, program, rig, draw)
    except AssertionError:  # it has ended: a busy host, say, has held the simulation up
        return False
    return program.process.poll() is None or phase == "stop"


def _wait_for(phase, program, rig, draw):
    if phase == "connect":
        program.wait_for("recording to")
        pause(draw.uniform(0.0, rig.connecting))
        return
    program.wait_for("approach …")
    if phase == "energise":
        pause(draw.uniform(0.0, ENERGISE))
        return
    if phase == "approach":
        pause(ENERGISE + draw.uniform(0.0, APPROACH))
        return
    program.wait_for("run …")
    pause(draw.uniform(0.0, rig.moves))
    if phase == "release":
        program.send(signal.SIGINT)
        pause(draw.uniform(0.0, RELEASE))
    elif phase == "stop":
        program.send(signal.SIGINT)
        program.send(signal.SIGINT)
        pause(draw.uniform(0.0, AT_ONCE))


def judged(rig, truth, until, safe_from):
    """Return what was a hazard, from what the simulation has written down."""
    profile = load_profile(rig.name, REGISTRY, [], find_configs(None))
    hazards = REGISTRY.hazards(profile.plant.model)(profile.mechanism_settings)
    columns = [name for name, _ in make_plant(profile).truth_columns]
    seen = np.load(truth)
    times, rows = seen["t"], seen["rows"]
    kept = times <= until
    assert kept.sum() > 500, "nothing was watched"
    return judge(hazards, columns, times[kept], rows[kept], safe_from=safe_from)


@pytest.mark.parametrize("number", range(EACH))
@pytest.mark.parametrize("how", ["killed", "paused"])
@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("rig", RIGS, ids=lambda rig: rig.name)
def test_nobody_is_hurt(rig, phase, how, number, tmp_path):
    draw = random.Random(zlib.crc32(f"{SEED} {rig.name} {phase} {how} {number}".encode()))
    truth = tmp_path / "truth.npz"
    command = ["run", rig.experiment, "--rig", rig.name, "--on", rig.on, "--no-report"]
    with simulate(rig.name, rig.on, *rig.settings, truth=truth) as simulation:
        with Program(*command, "--out", tmp_path / "runs", *rig.options, *rig.settings) as program:
            came = comes_to(phase, program, rig, draw)
            program.send(signal.SIGKILL if how == "killed" else signal.SIGSTOP)
            if how == "paused":
                pause(draw.uniform(SHORTEST, LONGEST))
                program.send(signal.SIGCONT)
                pause(1.0)
                program.send(signal.SIGINT)
            code = program.end()
        over = now()
        pause(AFTERMATH)
        assert simulation.stop() == 0, simulation.talk
    # The dead say nothing; what devices do of themselves has to be done by then.
    safe_from = over + AFTERMATH - 0.1 if how == "killed" else over
    wrong = judged(rig, truth, over + AFTERMATH, safe_from)
    assert not wrong, f"{'; '.join(map(str, wrong))}\n{code}: {program.talk}"
    if not came:
        pytest.skip(f"nobody was hurt, but it had ended before its moment:\n{program.talk}")
    assert code in ((-signal.SIGKILL, 130) if how == "killed" else (0, 3, 4, 130)), program.talk
