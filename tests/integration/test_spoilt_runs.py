"""Run folders that somebody cut or edited, or of another version, and what is said of them."""

import json
import random
import shutil

import pytest

import rig
from rig.cli import invoke
from rig.run_facts import FORMAT
from rig.runtime.log import LogFile, read_log

SHORT = (
    "--set", "approach=0.2 s", "--set", "loop.rate=250 Hz", "--set", "reference.dwell=0.2 s",
    "--set", "reference.rise=0 s", "--set", "reference.size=1 mm",
    "--set", "figures=[timing]",
)  # fmt: skip


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return the folder of a run that came to its end."""
    out = tmp_path_factory.mktemp("runs")
    assert invoke(["run", "cylinder-step", "--on", "sim", "--out", str(out), "--no-report",
                   "--seed", "1", *SHORT]) in (0, 1)  # fmt: skip
    return next(out.iterdir())


@pytest.fixture
def folder(recorded, tmp_path):
    """Return a copy of it in a folder of its own."""
    return shutil.copytree(recorded, tmp_path / "runs" / recorded.name)


def edit(path, **changes):
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))


@pytest.mark.parametrize("seed", range(3))
def test_a_log_that_was_cut_off_is_not_taken_for_whole(seed, folder, capsys):
    log = folder / "log.mcap"
    before, file = read_log(log), LogFile(log)
    rows = random.Random(seed).randrange(1, len(before.t))
    start = log.read_bytes().index(next(file.pieces())[:1].tobytes())
    part = random.Random(seed).randrange(file.record.itemsize)
    log.write_bytes(log.read_bytes()[: start + rows * file.record.itemsize + part])
    metrics = (folder / "metrics.json").read_bytes()
    for command in (["replay", str(folder), "--verify"], ["replay", str(folder), "--frames"]):
        assert invoke(command) == 2
        assert "was cut off" in capsys.readouterr().err
    with pytest.raises(rig.ConfigurationError, match="was cut off"):
        rig.replay(folder)
    with pytest.warns(UserWarning, match=r"log.mcap was cut off: .* what was left") as told:
        assert len(rig.load(folder).data) == rows
    assert [one.filename for one in told] == [__file__]
    assert invoke(["export", str(folder), "--format", "csv"]) == 1
    said = capsys.readouterr()
    assert "was cut off" in said.err and said.out.strip() == str(folder / "log.csv")
    assert len((folder / "log.csv").read_text().splitlines()) == rows + 1
    assert invoke(["report", str(folder)]) == 0
    assert "was cut off" in capsys.readouterr().err
    assert "was cut off" in (folder / "report.html").read_text()
    assert (
        folder / "metrics.json"
    ).read_bytes() == metrics  # of the whole log, and not of the rest


@pytest.mark.parametrize("seed", range(3))
def test_a_flipped_bit_is_said_by_every_reader(seed, folder, capsys):
    log, chance = folder / "log.mcap", random.Random(seed)
    content = bytearray(log.read_bytes())
    file = LogFile(log)
    rows = sum(len(piece) for piece in file.pieces())
    first = content.index(next(file.pieces())[:1].tobytes())
    row = chance.randrange(rows)
    place = first + row * file.record.itemsize + chance.randrange(40, file.record.itemsize - 8)
    content[place] ^= 1 << chance.randrange(8)
    log.write_bytes(content)
    said = f"is damaged: row {row} of it does not fit its checksum"
    run = rig.load(folder)
    for read in (lambda: run.data, run.frame, lambda: run.figure("tracking"), lambda: run.segments):
        with pytest.raises(rig.ConfigurationError, match=said):
            read()
    with pytest.raises(rig.ConfigurationError, match=said):
        rig.replay(folder)
    assert invoke(["export", str(folder), "--format", "csv"]) == 2
    assert said in capsys.readouterr().err
    assert invoke(["report", str(folder)]) == 0
    assert said in capsys.readouterr().err
    assert said in (folder / "report.html").read_text()


@pytest.mark.parametrize("status", ["crashed", "faulted"])
def test_a_log_that_nobody_closed_is_exported_as_far_as_it_goes(status, folder, capsys):
    edit(folder / "manifest.json", status=status)
    content = (folder / "log.mcap").read_bytes()
    (folder / "log.mcap").write_bytes(content[: -random.Random(status).randrange(1, 5000)])
    assert invoke(["export", str(folder), "--format", "csv"]) == 0
    assert capsys.readouterr().err == ""


STRANGE = [
    {"git": []}, {"git": {"commit": "1234"}}, {"seed": [3]}, {"versions": "1.0"}, {"status": 7},
    {"files": None}, {"exit_code": "none"},
]  # fmt: skip


@pytest.mark.parametrize("changes", STRANGE, ids=str)
def test_a_strange_manifest_is_a_sentence_and_no_neighbour(changes, folder, recorded, capsys):
    neighbour = shutil.copytree(folder, folder.with_name("neighbour"))
    edit(neighbour / "manifest.json", **changes)
    assert invoke(["diff", str(folder), str(recorded)]) == 0
    for command in (["diff", str(folder), str(neighbour)], ["report", str(neighbour)]):
        assert invoke(command) == 2
        err = capsys.readouterr().err
        assert str(neighbour) in err and next(iter(changes)) in err and "Traceback" not in err


@pytest.mark.parametrize(
    "text",
    ["{", "[" * 100_000, '{"metrics": 3}', '{"metrics": [3]}', '{"metrics": [{"value": 1.0}]}',
     '{"metrics": [{"name": "hold_rms", "value": "wide"}]}'],
    ids=["torn", "deep", "number", "numbers", "nameless", "word"],
)  # fmt: skip
def test_metrics_that_are_none_are_a_sentence_and_no_neighbours(text, folder, recorded, capsys):
    neighbour = shutil.copytree(folder, folder.with_name("neighbour"))
    (neighbour / "metrics.json").write_text(text)
    assert invoke(["diff", str(folder), str(recorded)]) == 0
    assert invoke(["diff", str(folder), str(neighbour)]) == 2
    err = capsys.readouterr().err
    assert "metrics.json" in err and "Traceback" not in err


def test_another_version_says_so_before_it_replays(folder, capsys):
    assert invoke(["replay", str(folder)]) == 0
    assert "recorded it" not in capsys.readouterr().err
    versions = json.loads((folder / "manifest.json").read_text())["versions"]
    edit(folder / "manifest.json", versions={**versions, "rig-controller": "0.0.7"}, git=None)
    assert invoke(["replay", str(folder)]) == 0
    err = capsys.readouterr().err
    assert "rig 0.0.7 (no checkout) recorded it, rig " in err and "replays it" in err
    for more in ({}, {"controller": "pid"}):
        with pytest.warns(UserWarning, match=r"rig 0.0.7 \(no checkout\) recorded it") as told:
            rig.replay(folder, **more)
        assert [one.filename for one in told] == [__file__]


@pytest.mark.parametrize("command", ["replay", "rerun", "export", "report", "diff"])
def test_a_later_format_is_refused(command, folder, recorded, capsys):
    later = FORMAT + random.Random(command).randrange(1, 9)
    edit(folder / "manifest.json", format=later, versions={"rig-controller": "9.9"}, status="new")
    more = {"export": ["--format", "csv"], "diff": [str(recorded)]}.get(command, [])
    assert invoke([command, str(folder), *more]) == 2
    err = capsys.readouterr().err
    assert f"rig 9.9 recorded it in format {later}" in err and f"up to {FORMAT}" in err


def test_a_folder_that_says_no_format_is_of_the_first(folder, capsys):
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest.pop("format") == FORMAT
    (folder / "manifest.json").write_text(json.dumps(manifest))
    assert invoke(["replay", str(folder)]) == 0


@pytest.mark.parametrize("name", ["metrics.json", "report.html", "figures"])
def test_a_report_that_cannot_be_written_is_no_fault_of_a_rig(name, folder, tmp_path, capsys):
    outside = tmp_path / "outside"
    outside.mkdir()
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(outside)
    assert invoke(["report", str(folder)]) == 2
    assert "it is a link to" in capsys.readouterr().err
    assert list(outside.iterdir()) == []
