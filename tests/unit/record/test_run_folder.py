"""The run folder: never reused, never half written, honest about a death."""

import errno
import hashlib
import json
import os
import signal
import subprocess
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest

from rig import provenance
from rig.hal import ConfigurationError
from rig.run_facts import EVENTS, MANIFEST, RunStatus
from rig.run_folder import RunFolder, RunFolderError

NOW = datetime(2026, 11, 21, 3, 45, 12, tzinfo=UTC)
INPUTS = {
    "profile.yaml": "name: cylinder\n",
    "experiment.yaml": "name: sine\n",
    "calibration/encoder.yaml": "offset: 0.001\n",
}


def create(out: Path, now: datetime = NOW) -> RunFolder:
    return RunFolder.create(
        out, "cylinder-sine", "virtual", inputs=INPUTS, seed=3, command=["rig", "run"], now=now
    )


def test_folder_holds_what_was_used(tmp_path: Path) -> None:
    folder = create(tmp_path / "runs")
    assert folder.path.name == "2026-11-21T034512Z-cylinder-sine-virtual"
    for name, text in INPUTS.items():
        assert (folder.path / name).read_text() == text
    manifest = json.loads((folder.path / MANIFEST).read_text())
    assert manifest["status"] == "running"
    assert (manifest["backend"], manifest["seed"]) == ("virtual", 3)
    assert manifest["files"] == {
        name: hashlib.sha256(text.encode()).hexdigest() for name, text in INPUTS.items()
    }
    assert {"python", "numpy", "mcap"} <= manifest["versions"].keys()
    assert manifest["machine"]["host"] and manifest["machine"]["platform"]
    assert manifest["started"] == "2026-11-21T03:45:12.000+00:00"
    folder.finish(RunStatus.FAILED, 1, "a bound was missed", {"buses": {"can0": {"lost": 0}}})
    manifest = json.loads((folder.path / MANIFEST).read_text())
    assert (manifest["status"], manifest["exit_code"]) == ("failed", 1)
    assert manifest["ended"] and manifest["message"] == "a bound was missed"
    assert manifest["buses"]["can0"]["lost"] == 0
    assert RunFolder.open(folder.path).status is RunStatus.FAILED


def test_folder_is_never_reused(tmp_path: Path) -> None:
    local = NOW.astimezone(timezone(timedelta(hours=9)))
    names = [create(tmp_path, now).path.name for now in (NOW, NOW, local)]
    stem = "2026-11-21T034512Z-cylinder-sine-virtual"
    assert names == [stem, f"{stem}-2", f"{stem}-3"]


def test_unwritable_place_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ConfigurationError, match=r"file: .*--out"):
        create(tmp_path / "file")


def test_events_are_there_at_once_and_a_torn_line_is_left_out(tmp_path: Path) -> None:
    folder = create(tmp_path)
    folder.record_event(None, "state", "idle → running", old="idle")
    folder.record_event(1.5, "limit", "rate", value=float("inf"))
    expected = [
        {"t": None, "kind": "state", "message": "idle → running", "data": {"old": "idle"}},
        {"t": 1.5, "kind": "limit", "message": "rate", "data": {"value": None}},
    ]
    assert folder.events() == expected
    with (folder.path / EVENTS).open("ab") as stream:
        stream.write('{"t": 2.0, "kind": "fault", "message": "½'.encode()[:-1])
    assert folder.events() == expected
    folder.finish(RunStatus.OK, 0)
    with pytest.raises(RunFolderError, match="not open"):
        folder.record_event(2.0, "mark", "too late")


def test_killed_run_is_found_crashed(tmp_path: Path) -> None:
    ready, tell = os.pipe()
    child = os.fork()
    if child == 0:  # pragma: no cover
        try:
            folder = create(tmp_path)
            folder.record_event(0.0, "state", "running")
            os.write(tell, b"x")
            signal.pause()
        finally:
            os._exit(1)
    os.read(ready, 1)
    (path,) = tmp_path.iterdir()
    assert RunFolder.open(path).status is RunStatus.RUNNING
    assert RunFolder.open(path).is_live()
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(ready)
    os.close(tell)
    folder = RunFolder.open(path)
    assert folder.status is RunStatus.CRASHED
    manifest = json.loads((path / MANIFEST).read_text())
    assert manifest["status"] == "crashed" and manifest["ended"]
    assert manifest["exit_code"] is None
    assert folder.events()[0]["message"] == "running"


def test_json_is_written_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = create(tmp_path)
    folder.write_timing({"overruns": 1, "p99": float("nan")})
    assert folder.read_json("timing.json", dict[str, object]) == {"overruns": 1, "p99": None}

    def full(fd: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RunFolderError, match=r"timing\.json: No space left"):
        folder.write_timing({"overruns": 2})
    monkeypatch.undo()
    assert folder.read_json("timing.json", dict[str, object])["overruns"] == 1
    assert not [p for p in folder.path.iterdir() if p.name.startswith(".")]
    assert folder.read_json("metrics.json", dict[str, object]) == {}


@pytest.mark.parametrize(
    "content",
    [
        None,
        "not json",
        "[]",
        "{}",
        '{"status": "exploded"}',
        '{"status": []}',
        "[" * 100_000,
        '{"status": "ok", "seed": "one"}',
        '{"status": "ok", "format": "new"}',
    ],
    ids=["none", "text", "list", "empty", "status", "type", "deep", "seed", "format"],
)
def test_other_folders_are_refused(tmp_path: Path, content: str | None) -> None:
    if content is not None:
        (tmp_path / MANIFEST).write_text(content)
    with pytest.raises(ConfigurationError, match="not a run folder"):
        RunFolder.open(tmp_path)


def test_git_state_of_a_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "a.py").write_text("a = 1\n")
    assert provenance.git_state(tmp_path / "package") is None
    identity = ["-c", "user.name=a", "-c", "user.email=a@b.invalid"]
    for arguments in (["init", "-q"], ["add", "."], [*identity, "commit", "-q", "-m", "first"]):
        subprocess.run(["git", *arguments], cwd=tmp_path, check=True)
    state = provenance.git_state(tmp_path / "package")
    assert state is not None and len(state["commit"]) == 40 and state["dirty"] is False
    (tmp_path / "package" / "a.py").write_text("a = 2\n")
    state = provenance.git_state(tmp_path / "package")
    assert state is not None and state["dirty"] is True
    subprocess.run(["git", "checkout", "-q", "."], cwd=tmp_path, check=True)
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "profile.yaml").write_text("name: mine\n")
    state = provenance.git_state(tmp_path / "package")
    assert state is not None and state["dirty"] is False  # what runs leave shapes none
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    (tmp_path / "configs" / "rigs" / "mine.yaml").write_text("name: mine\n")
    state = provenance.git_state(tmp_path / "package")
    assert state is not None and state["dirty"] is True
    monkeypatch.setenv("PATH", str(tmp_path))
    assert provenance.git_state(tmp_path / "package") is None


@pytest.mark.parametrize("fails", ["write_json", "SpareRoom", "beside another"])
def test_a_folder_that_cannot_be_made_whole_is_not_left_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: str
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    if fails == "beside another":  # what was there before stays
        create(tmp_path).finish(RunStatus.OK, 0)
    monkeypatch.setattr(
        "rig.run_folder." + ("write_json" if fails == "beside another" else fails), full
    )
    before = list(tmp_path.iterdir())
    with pytest.raises(ConfigurationError, match="No space left on device"):
        create(tmp_path, NOW + timedelta(seconds=5))
    assert list(tmp_path.iterdir()) == before
