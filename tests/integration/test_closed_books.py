"""Every way out of a run closes its manifest with what ended it; some in processes of their own."""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from small_disk import may_mount, on_a_small_disk
from warm_start import WarmProcess

from rig.assembly import Backend
from rig.experiment import run as run_module
from rig.experiment.plan import load_plan
from rig.experiment.run import Watcher, run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"
SHORT = ["reference.tones=[{frequency: 1 Hz, periods: 3}]", "approach=0.5 s", "metrics={}"]
BRIEF = ["reference.tones=[{frequency: 2 Hz, periods: 2}]", *SHORT[1:]]
RIG = [sys.executable, "-m", "rig"]
WORDS = ["--configs", str(CONFIGS), *[word for option in SHORT for word in ("--set", option)]]
GENERATOR = np.random.default_rng(14)
MISSED = ["--no-report", "--set", "metrics={tracking_rms: {max: 1e-9 m}}"]
FAULT = "simulation.faults=[{at: 2, device: regulators, fault: emergency}]"


def rig_run(out, *options):
    return ["run", "cylinder-sine", "--out", str(out), *WORDS, *options]


def manifest_of(out):
    (folder,) = out.iterdir()
    assert not list(folder.glob(".*")), "nothing hidden stays behind"
    return json.loads((folder / "manifest.json").read_text())


def raising(update, error, at):
    calls = 0

    def updated(self, state, reference):
        nonlocal calls
        calls += 1
        if calls == at:
            raise error
        return update(self, state, reference)

    return updated


@pytest.mark.parametrize("at", GENERATOR.integers(1, 1500, 2))
def test_a_run_whose_folder_is_removed_has_not_gone_well(tmp_path, monkeypatch, at):
    """What it did is lost with its log, so no bound of it is known to be kept."""
    plan = load_plan("cylinder-sine", BRIEF, configs=CONFIGS)
    update = type(plan.controller).update
    calls = 0

    def updated(self, state, reference):
        nonlocal calls
        calls += 1
        if calls == at:
            shutil.rmtree(next(tmp_path.iterdir()))
        return update(self, state, reference)

    monkeypatch.setattr(type(plan.controller), "update", updated)
    result = run_experiment(plan, Backend.SIM, tmp_path)
    assert (result.status, result.exit_code) == ("faulted", 4)
    assert "removed while it was written" in result.message


@pytest.mark.parametrize("at", GENERATOR.integers(1, 1500, 3))
def test_a_bug_in_a_controller_is_written_down_and_raised(tmp_path, monkeypatch, at):
    plan = load_plan("cylinder-sine", SHORT, configs=CONFIGS)
    kind = type(plan.controller)
    monkeypatch.setattr(kind, "update", raising(kind.update, ZeroDivisionError("1 / 0"), at))
    with pytest.raises(ZeroDivisionError):
        run_experiment(plan, Backend.VIRTUAL, tmp_path, report=False)
    manifest = manifest_of(tmp_path)
    assert (manifest["status"], manifest["exit_code"]) == ("crashed", 70)
    assert manifest["message"] == "ZeroDivisionError: 1 / 0"
    assert manifest["buses"]["can0"]["frames_in"] > 0
    (folder,) = tmp_path.iterdir()
    assert RunFolder.open(folder).events()[-1]["data"]["type"] == "ZeroDivisionError"
    assert (folder / "timing.json").exists()


@pytest.mark.parametrize("error", [KeyboardInterrupt(), RuntimeError("odd")], ids=["ctrl-c", "bug"])
@pytest.mark.parametrize("step", ["build", "frames", "watch", "connect", "arm", "report", "judge"])
def test_whatever_comes_between_two_steps_is_written_down(tmp_path, monkeypatch, step, error):
    def fail(*_, **__):
        raise error

    places = {
        "frames": (run_module, "Events"),
        "connect": (run_module.Rig, "__enter__"),
        "arm": (run_module.Rig, "arm"),
        "judge": (run_module, "_judge"),
        "report": (run_module, "write_results"),
        "watch": (Watcher, "started"),
        "build": (run_module, "Stopwatch"),
    }
    monkeypatch.setattr(*places[step], fail)
    plan = load_plan("cylinder-sine", BRIEF, configs=CONFIGS)
    code = None
    try:
        code = run_experiment(plan, Backend.VIRTUAL, tmp_path, report=False).exit_code
    except BaseException as raised:
        assert raised is error
    manifest = manifest_of(tmp_path)
    if isinstance(error, KeyboardInterrupt):
        assert (manifest["status"], manifest["exit_code"]) == ("aborted", 130)
        assert "interrupted" in manifest["message"]
        assert code in (None, 130)
        before = "before the rig was energised" in manifest["message"]
        assert before == (step in ("connect", "arm"))
    else:
        assert (manifest["status"], manifest["exit_code"]) == ("crashed", 70)
        assert manifest["message"] == "RuntimeError: odd"
        assert code is None


def test_a_request_while_the_folder_is_made_waits_until_it_is_whole(tmp_path, monkeypatch):
    create = run_module.create_folder

    def interrupted(*arguments):
        os.kill(os.getpid(), signal.SIGTERM)
        return create(*arguments)

    monkeypatch.setattr(run_module, "create_folder", interrupted)
    plan = load_plan("cylinder-sine", SHORT, configs=CONFIGS)
    with pytest.raises(KeyboardInterrupt):
        run_experiment(plan, Backend.VIRTUAL, tmp_path, report=False)
    manifest = manifest_of(tmp_path)
    assert (manifest["status"], manifest["exit_code"]) == ("aborted", 130)


@pytest.mark.parametrize(
    ("gone", "options", "code", "status"),
    [
        ("later", [], 0, "ok"),
        ("at once", MISSED, 1, "failed"),
        ("later", ["--no-report", "--set", FAULT], 4, "faulted"),
    ],
    ids=["ok", "missed", "fault"],
)
def test_nobody_listens_any_more(tmp_path, gone, options, code, status):
    reader, writer = os.pipe()
    process = WarmProcess(rig_run(tmp_path, *options), stdout=writer, stderr=writer)
    os.close(writer)
    if gone == "later":
        assert b"recording to" in os.read(reader, 4096)
    os.close(reader)
    assert process.wait() == code
    manifest = manifest_of(tmp_path)
    assert (manifest["status"], manifest["exit_code"]) == (status, code)
    assert "pipe" not in str(manifest["message"])
    (folder,) = tmp_path.iterdir()
    assert (folder / "report.html").exists() == ("--no-report" not in options)


BUG = """
    from controllers.cylinder.pid import PidController as law
    from rig.cli import main
    def update(self, state, reference):
        raise ZeroDivisionError("1 / 0")
    law.update = update
    main()
"""


@pytest.mark.parametrize("heard", [True, False], ids=["heard", "unheard"])
def test_a_bug_in_a_process_of_its_own_exits_with_70(tmp_path, heard):
    plan = load_plan("cylinder-sine", SHORT, configs=CONFIGS)
    law = type(plan.controller)
    program = textwrap.dedent(BUG)
    program = program.replace("controllers.cylinder.pid", law.__module__)
    program = program.replace("PidController", law.__qualname__)
    reader, writer = os.pipe()
    process = WarmProcess(rig_run(tmp_path), program, stdout=writer, stderr=writer)
    os.close(writer)
    said = b""
    while heard and (some := os.read(reader, 65536)):
        said += some
    os.close(reader)
    assert process.wait() == 70
    assert not heard or (b"ZeroDivisionError" in said and b"bug in rig" in said)
    manifest = manifest_of(tmp_path)
    assert (manifest["status"], manifest["exit_code"]) == ("crashed", 70)


@pytest.mark.parametrize("size", GENERATOR.integers(350, 900, 2))
def test_a_full_disk_is_named_with_what_is_lost(tmp_path, size):
    disk, kept = tmp_path / "disk", tmp_path / "kept"
    disk.mkdir()
    kept.mkdir()
    if not may_mount(disk):
        pytest.skip("this machine lets nobody mount a small disk")
    done = on_a_small_disk(f"{size}k", disk, kept, [*RIG, *rig_run(disk)])
    assert done.returncode == 4, done.stderr
    assert "Traceback" not in done.stderr
    manifest = manifest_of(kept)
    assert (manifest["status"], manifest["exit_code"]) == ("faulted", 4)
    (folder,) = kept.iterdir()
    log = read_log(folder / "log.mcap")
    for message in (manifest["message"], done.stderr):
        assert "log.mcap: No space left" in message
        (lost,) = re.findall(r"it ends before (\S+) s, ", message)
        assert 0.0 < float(lost) - log.t[-1] < 1.5 * (log.t[1] - log.t[0])
        assert "timing.json" not in message
    assert "there is no report" in done.stderr or (folder / "report.html").exists()
    faults = [event for event in RunFolder.open(folder).events() if event["kind"] == "fault"]
    assert [event["message"] for event in faults] == [manifest["message"]]
    assert list(log.cycle) == list(range(len(log.cycle)))


@pytest.mark.parametrize("closed", ["2>&-", ">&-", ">&- 2>&-"])
def test_who_closed_the_outputs_gets_a_run_all_the_same(tmp_path, closed):
    words = shlex.join([*RIG, *rig_run(tmp_path, "--no-report")])
    done = subprocess.run(["sh", "-c", f"{words} {closed}"], check=False, timeout=120)
    assert done.returncode == 0
    assert (manifest_of(tmp_path)["status"]) == "ok"
