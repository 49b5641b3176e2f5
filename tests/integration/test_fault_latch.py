"""A fault on hardware outlives the process, until an operator beside the rig resets it.

The hardware is emulated nodes in virtual time, which the program takes for real ones.
"""

import os
import signal
import textwrap
from pathlib import Path

import numpy as np
import pytest
import warm_start

from rig.assembly import Backend, build_rig
from rig.assembly.simulated import build_virtual
from rig.cli import invoke
from rig.experiment.fault_latch import FaultLatch

CONFIGS = Path(__file__).parents[2] / "configs"
GENERATOR = np.random.default_rng(1010)
SHORT = [
    "reference.tones=[{frequency: 1 Hz, periods: 2}]",
    "approach=0.3 s",
    "metrics={}",
    "cylinder.limits.stop_energy=1 J",
    "loop.small_margin=a test",
]


def fault(at, name="emergency", value=None):
    given = "" if value is None else f", value: {value}"
    return f"{{at: {at}, device: regulators, fault: {name}{given}}}"


@pytest.fixture
def rig(tmp_path, monkeypatch):
    """Return what runs a `rig` command on hardware that is none."""

    def build(profile, backend, on=None, frames=None):
        if backend is not Backend.HARDWARE:
            return build_rig(profile, backend, on, frames)
        made = build_virtual(profile, frames)
        made.backend = backend
        return made

    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("rig.experiment.run.build_rig", build)
    monkeypatch.setattr("rig.assembly.build_rig", build)

    def run(command, *faults, yes="cylinder", settings=SHORT):
        words = ["--configs", str(CONFIGS), "--on", "hardware", "--yes", yes]
        words += [word for option in settings for word in ("--set", option)]
        words += ["--set", f"simulation.faults=[{', '.join(faults)}]"]
        if command == "run":
            words = ["cylinder-sine", "--no-report", "--out", str(tmp_path / "runs"), *words]
        else:
            words = ["cylinder", *words]
        return invoke([command, *words])

    return run


def reset(rig, *faults, **how):
    return rig("reset", *faults, settings=(), **how)


PRESSED = fault(1.0, "emergency_stop", 1)
RELEASED = fault(2.0, "emergency_stop", 0)


@pytest.mark.parametrize("at", GENERATOR.uniform(0.3, 2.0, 2).round(3))
def test_a_fault_is_latched_until_the_stop_is_pressed_and_released(rig, tmp_path, capsys, at):
    assert rig("run") == 0
    assert rig("run", fault(at)) == 4
    said = capsys.readouterr().err
    assert "cylinder is latched" in said and "rig reset cylinder" in said
    before = sorted((tmp_path / "runs").iterdir())
    for _ in range(2):
        assert rig("run") == 3
        said = " ".join(capsys.readouterr().err.split())
        assert "EMCY 0x1000" in said and before[-1].name in said
        assert "then: rig reset cylinder" in said
    assert sorted((tmp_path / "runs").iterdir()) == before, "nothing was opened"
    # Not by its name alone, nor by a contact that was open all the time, nor by one that opens.
    assert reset(rig) == 3
    assert reset(rig, fault(0.0, "emergency_stop", 1)) == 3
    assert reset(rig, PRESSED) == 3
    assert "not pressed and released within 60 s" in capsys.readouterr().err
    assert rig("run") == 3
    assert reset(rig, PRESSED, RELEASED) == 0
    assert "cylinder is reset" in capsys.readouterr().err
    assert rig("run") == 0
    assert reset(rig) == 0
    assert "has no latched fault" in capsys.readouterr().err


def test_what_never_energised_the_rig_latches_nothing(rig):
    assert rig("run", fault(0.0, "wrong_device_type")) == 3
    assert rig("run", fault(0.0, "emergency_stop", 1)) == 3
    assert rig("run") == 0


def test_who_stops_a_run_has_no_fault(rig, monkeypatch):
    os_kill = []

    def progressed(self, progress):
        if progress.t > 0.0 and not os_kill:
            os_kill.append(os.kill(os.getpid(), signal.SIGINT))

    monkeypatch.setattr("rig.cli.progress.ProgressLine.progressed", progressed)
    assert rig("run") == 130
    assert rig("run") == 0


@pytest.mark.parametrize("content", [b"", b"{}", b"[1]", b"\xff\xfe", b'{"fault": "x"'])
def test_a_latch_that_cannot_be_read_is_shut(rig, tmp_path, capsys, content):
    path = tmp_path / "state" / "rig" / "cylinder.fault"
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    assert rig("run") == 3
    assert "cylinder.fault cannot be read" in " ".join(capsys.readouterr().err.split())
    assert reset(rig, PRESSED, RELEASED) == 0
    assert rig("run") == 0


def test_without_a_place_for_its_fault_a_rig_is_not_energised(rig, tmp_path, capsys):
    (tmp_path / "state").write_text("a file where a folder belongs")
    assert rig("run") == 3
    assert "cannot be read" in capsys.readouterr().err
    (tmp_path / "state").unlink()
    (tmp_path / "state" / "rig").mkdir(parents=True)
    (tmp_path / "state" / "rig" / f"cylinder.{os.getpid()}").mkdir()
    assert rig("run") == 3
    assert "could not be latched" in capsys.readouterr().err


def test_a_rig_without_a_contact_asks_for_its_name(rig, capsys):
    FaultLatch("cylinder").set(Path("runs/1"), "it fell")
    contactless = ["cylinder.emergency_stop=null"]
    assert rig("reset", settings=contactless, yes="joint") == 2
    assert "--yes joint: this is the rig cylinder" in capsys.readouterr().err
    assert FaultLatch("cylinder").reason() is not None
    assert rig("reset", settings=contactless) == 0
    assert FaultLatch("cylinder").reason() is None


@pytest.mark.parametrize("declared", [[], ["cylinder.limits.stop_energy=1 J"]])
def test_a_reset_asks_for_the_stop_that_bears_a_cut_wire_as_a_run_does(
    tmp_path, monkeypatch, capsys, declared
):
    """With it, only the bus is missing that there is not."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    FaultLatch("cylinder").set(Path("runs/1"), "a wire was cut")
    settings = ["buses.can0.channel=nowhere", *declared]
    options = [word for option in settings for word in ("--set", option)]
    assert invoke(["reset", "cylinder", "--configs", str(CONFIGS), *options]) == 3
    said = capsys.readouterr().err
    assert ("limits.stop_energy is not declared" in said) == (not declared)
    assert ("nowhere" in said) == bool(declared)
    assert FaultLatch("cylinder").reason() is not None


KILLED = """
    import os, signal
    from rig.assembly import Backend
    from rig.assembly.simulated import build_virtual
    import rig.experiment.run as run
    def build(profile, backend, on=None, frames=None):
        made = build_virtual(profile, frames)
        made.backend = backend
        return made
    run.build_rig = build
    from rig.cli.progress import ProgressLine
    def progressed(self, progress):
        if progress.t > {when}:
            os.kill(os.getpid(), signal.SIGKILL)
    ProgressLine.progressed = progressed
    from rig.cli import main
    main()
"""


def test_a_program_that_was_killed_leaves_the_rig_latched(rig, tmp_path, capsys):
    words = ["run", "cylinder-sine", "--on", "hardware", "--yes", "cylinder", "--no-report"]
    words += ["--configs", str(CONFIGS), "--out", str(tmp_path / "runs")]
    words += [word for option in SHORT for word in ("--set", option)]
    program = textwrap.dedent(KILLED).format(when=GENERATOR.uniform(-1.0, 0.9))
    done = warm_start.run(words, program)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert rig("run") == 3
    assert "ended while the rig was energised" in " ".join(capsys.readouterr().err.split())
