"""The commands around a run: what they print, and what they say when something is wrong."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from warm_start import WarmProcess

from rig.cli import invoke
from rig.hal.columns import Column
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder
from rig.runtime.recorder import LogRecorder

CONFIGS = Path(__file__).parents[2] / "configs"


def make_run(out, name="sine", status=RunStatus.OK, metrics=()):
    """Make a run folder with a log of three cycles; no status: its process died."""
    folder = RunFolder.create(out, name, "virtual", inputs={"profile.yaml": "name: x\n"})
    recorder = LogRecorder(folder.log_path, [Column("reading.position", "m", "position")])
    for cycle in range(3):
        recorder.write(cycle, cycle * 0.5, (cycle * 0.25,))
    recorder.close()
    folder.write_json("metrics.json", {"metrics": list(metrics)})
    if status is not None:
        folder.finish(status, 0)
    else:
        os.close(folder._events_fd)  # what the kernel does for a killed process
    return folder.path


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a command."""
    code = invoke([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_check_shows_the_profile_as_data(capsys):
    code, out, _ = run(capsys, "check", "cylinder", "--configs", CONFIGS, "--json")
    profile = json.loads(out)["profile"]
    assert code == 0
    assert profile["rate"] == 1000.0
    assert {device["name"]: device["node"] for device in profile["devices"]} == {
        "regulators": 0x10,
        "encoder-agonist": 0x20,
        "encoder-antagonist": 0x21,
    }
    bus = profile["buses"][0]
    assert bus["load"] == pytest.approx(sum(frame["load"] for frame in bus["frames"]))
    assert 0.0 < bus["load"] <= bus["max_load"]
    limits = {limit["name"]: limit for limit in profile["limits"]}
    assert limits["pressure"]["value"] == [0.0, 500e3]
    assert limits["pressure"]["unit"] == "Pa"


def test_check_shows_the_profile_to_people_and_talks_on_stderr(capsys):
    code, out, err = run(capsys, "check", "cylinder", "--configs", CONFIGS)
    assert code == 0
    assert "0 kPa … 500 kPa" in out
    assert "of at most 70 %" in out
    assert "\x1b" not in out
    assert "valid" in err and "valid" not in out


def test_check_shows_an_experiment_and_its_bounds(capsys):
    code, out, _ = run(capsys, "check", "cylinder-sine", "--configs", CONFIGS, "--json")
    experiment = json.loads(out)["experiment"]
    assert code == 0
    assert [s["name"] for s in experiment["segments"]] == ["0.1 Hz", "0.2 Hz", "0.5 Hz"]
    assert experiment["duration"] == experiment["segments"][-1]["end"]
    bounds = {metric["name"]: metric["max"] for metric in experiment["metrics"]}
    assert bounds["tracking_rms"] == 0.9e-3
    frozen = experiment["frozen"]
    assert frozen["device"] == {"device": "regulators", "after": 0.03}
    assert frozen["what"] == "position"
    assert frozen["device"]["after"] < frozen["longest"] < 0.2


def test_check_tells_people_what_happens_if_the_program_dies(capsys):
    code, out, _ = run(capsys, "check", "arm-shoulder-circle", "--configs", CONFIGS)
    assert code == 0
    assert "# if the program dies" in out
    assert "setpoints may stay for" in out
    assert " on: range of q4" in out
    assert "0.15 s (drives)" in out


def test_check_says_which_device_acts_too_late(capsys):
    late = ("buses.can0.heartbeat=85 ms", "buses.can0.heartbeat_timeout=185 ms")
    sets = [part for option in late for part in ("--set", option)]
    code, out, err = run(capsys, "check", "cylinder-sine", "--configs", CONFIGS, *sets)
    assert code == 0
    assert "0.185 s (regulators), which is too late: refused on hardware" in out
    assert "trying on the plant" in err


def test_check_applies_options(capsys):
    code, out, _ = run(
        capsys, "check", "cylinder", "--configs", CONFIGS, "--set", "loop.rate=500 Hz", "--json"
    )
    assert code == 0
    assert json.loads(out)["profile"]["rate"] == 500.0


def test_check_shows_every_error_with_its_place(capsys, tmp_path):
    text = (CONFIGS / "rigs" / "cylinder.yaml").read_text()
    text = text.replace("rate: 1 kHz", "rate: 1 kPa").replace("  bore: 16 mm", "  boar: 16 mm")
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    code, out, err = run(capsys, "check", path, "--configs", CONFIGS)
    line = text[: text.index("rate: 1 kPa")].count("\n") + 1
    assert code == 2
    assert out == ""
    assert f"mine.yaml:{line}:" in err
    assert "did you mean bore" in err


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("check", "cylindr"), "did you mean cylinder?"),
        (("check", "cylinder-sin"), "did you mean cylinder-sine?"),
        (("check", "/nowhere/x.yaml"), "/nowhere/x.yaml"),
        (("check", "cylinder", "--set", "lop.rate=1"), "lop"),
        (("check", "cylinder-sine", "--set", "controller=cascad"), "cascade"),
        (("check", "cylinder-sine", "--set", "metrics.tracking_rms.max=3 kPa"), "tracking_rms"),
        (("report", "lates"), "latest"),
        (("report", "latest"), "no run"),
        (("export", "nothing", "--format", "csv"), "nothing"),
        (("export", "latest", "--format", "cvs"), "csv"),
        (("schema", "profil"), "profile"),
        (("list", "rig"), "rigs"),
        (("chek",), "check"),
        (("list", "rigs", "--configs", "/nowhere"), "/nowhere"),
    ],
)
def test_what_is_wrong_is_named_and_exits_2(capsys, tmp_path, monkeypatch, arguments, named):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *arguments)
    assert code == 2
    assert out == ""
    assert named in err
    assert "Traceback" not in err


def test_list_names_and_describes(capsys):
    code, out, _ = run(capsys, "list", "rigs", "--configs", CONFIGS, "--json")
    assert code == 0
    assert "cylinder" in {entry["name"] for entry in json.loads(out)}
    assert all(entry["description"] for entry in json.loads(out))


def test_list_survives_a_broken_file(capsys, tmp_path):
    (tmp_path / "rigs").mkdir()
    (tmp_path / "rigs" / "bad.yaml").write_text("name: [\n")
    code, out, _ = run(capsys, "list", "rigs", "--configs", tmp_path)
    assert code == 0
    assert "cannot be read" in out


def test_list_shows_a_missed_bound_first_and_a_dead_run_as_crashed(capsys, tmp_path):
    metrics = [
        {"name": "good", "value": 1e-3, "unit": "m", "bound": 1.0, "pass": True},
        {"name": "bad", "value": 2e-3, "unit": "m", "bound": 1e-3, "pass": False},
    ]
    failed = make_run(tmp_path, "first", RunStatus.FAILED, metrics)
    dead = make_run(tmp_path, "second", None)
    (tmp_path / "no-run").mkdir()
    code, out, _ = run(capsys, "list", "runs", "--out", tmp_path, "--json")
    runs = {entry["name"]: entry for entry in json.loads(out)}
    assert code == 0
    assert set(runs) == {failed.name, dead.name}
    assert runs[dead.name]["status"] == "crashed"
    assert runs[failed.name]["metric"]["name"] == "bad"
    assert "bad 2 mm MISSED" in run(capsys, "list", "runs", "--out", tmp_path)[1]


def test_list_shows_the_newest_run_first(capsys, tmp_path):
    for day in ("20", "22", "21"):
        folder = tmp_path / f"2026-11-{day}T000000Z-x-sim"
        folder.mkdir()
        (folder / "manifest.json").write_text('{"status": "ok"}')
    _, out, _ = run(capsys, "list", "runs", "--out", tmp_path, "--json")
    assert [entry["name"][8:10] for entry in json.loads(out)] == ["22", "21", "20"]


def test_export_takes_the_latest_run(capsys, tmp_path):
    path = make_run(tmp_path, status=None)
    code, out, _ = run(capsys, "export", "latest", "--runs", tmp_path, "--format", "csv")
    assert code == 0
    assert Path(out.strip()) == path / "log.csv"
    lines = (path / "log.csv").read_text().splitlines()
    assert lines[0] == "cycle,t [s],reading.position [m]"
    assert len(lines) == 4


def test_export_says_where_it_cannot_write(capsys, tmp_path):
    path = make_run(tmp_path)
    target = tmp_path / "absent" / "log.csv"
    code, _, err = run(capsys, "export", path, "--format", "csv", "--out", target)
    assert code == 2
    assert str(target) in err and "Traceback" not in err


def test_report_works_on_a_run_that_crashed(capsys, tmp_path):
    path = make_run(tmp_path, status=None)
    code, out, _ = run(capsys, "report", path.name, "--runs", tmp_path)
    assert code == 0
    assert Path(out.strip()) == path / "report.html"
    assert "crashed" in (path / "report.html").read_text()


@pytest.mark.parametrize("kind", ["profile", "experiment"])
def test_schema_is_json(capsys, kind):
    code, out, _ = run(capsys, "schema", kind)
    assert code == 0
    assert json.loads(out)["title"] == kind.capitalize()


def test_light_commands_import_nothing_heavy():
    script = (
        "import sys; from rig.cli import invoke\n"
        f"configs = {str(CONFIGS)!r}\n"
        "for words in (['--help'], ['list', '--configs', configs], "
        "['check', 'cylinder', '--configs', configs]):\n"
        "    assert invoke(words) == 0, words\n"
        "heavy = {'numpy', 'scipy', 'matplotlib', 'numba', 'filterpy', 'canopen', 'can'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=False, capture_output=True, text=True
    )
    assert done.stderr.splitlines()[-1] == "[]"


@pytest.mark.parametrize("columns", [80, 81, 200])
def test_the_plain_help_is_what_click_says(capsys, monkeypatch, columns):
    from rig.cli import group

    monkeypatch.setenv("COLUMNS", str(columns))
    code, plain, _ = run(capsys, "--help")
    assert code == 0
    with pytest.raises(SystemExit):
        group.main(["--help"], prog_name="rig")
    assert plain == capsys.readouterr().out


def test_help_in_a_narrow_terminal_is_broken_for_it(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    code, out, _ = run(capsys, "-h")
    assert code == 0
    assert max(map(len, out.splitlines())) <= 60


def test_help_leaves_click_alone():
    script = (
        "import sys; from rig.cli import invoke\n"
        "invoke(['--help']); sys.exit('click' in sys.modules)"
    )
    environment = {**os.environ, "COLUMNS": "80"}
    subprocess.run([sys.executable, "-c", script], check=True, env=environment, capture_output=True)


def test_linear_algebra_runs_in_one_thread():
    script = (
        "import json, sys; from pathlib import Path; from rig.cli import invoke; invoke(['list'])\n"
        "import numpy; numpy.ones((400, 400)) @ numpy.ones((400, 400))\n"
        "print(len(list(Path('/proc/self/task').iterdir())))"
    )
    free = {name: value for name, value in os.environ.items() if "THREADS" not in name}
    done = subprocess.run(
        [sys.executable, "-c", script], env=free, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "1"


def test_a_reader_that_leaves_is_no_error():
    reader, writer = os.pipe()
    os.close(reader)
    with tempfile.TemporaryFile() as said:
        process = WarmProcess(["schema", "profile"], stdout=writer, stderr=said)
        os.close(writer)
        assert process.wait() == 0
        said.seek(0)
        assert said.read() == b""


def test_names_are_completed(tmp_path, monkeypatch):
    from click.shell_completion import ShellComplete

    from rig.cli import group

    make_run(tmp_path / "runs", "sine")
    monkeypatch.chdir(tmp_path)

    def completed(words, incomplete):
        complete = ShellComplete(group, {}, "rig", "_RIG_COMPLETE")
        return [item.value for item in complete.get_completions(words, incomplete)]

    assert "cylinder-sine" in completed(["check"], "cyl")
    assert completed(["report"], "la") == ["latest"]
    assert len(completed(["export"], "20")) == 1


def test_errors_of_an_experiment_and_of_its_profile_are_shown_at_once(tmp_path, capsys):
    for folder, name, old, new in (
        ("rigs", "cylinder", "rate: 1 kHz", "rate: 1 kg"),
        ("experiments", "cylinder-sine", "kind: sine", "kind: sinus"),
    ):
        text = (CONFIGS / folder / f"{name}.yaml").read_text()
        target = tmp_path / folder / f"{name}.yaml"
        target.parent.mkdir(parents=True)
        target.write_text(text.replace(old, new))
    code, _, err = run(capsys, "run", "cylinder-sine", "--configs", tmp_path, "--out", tmp_path)
    assert code == 2
    assert "no reference is called 'sinus'" in err and "'1 kg' is not in Hz" in err


def test_a_figure_that_there_is_not_is_named(tmp_path, capsys):
    code, _, err = run(
        capsys, "run", "cylinder-sine", "--configs", CONFIGS, "--out", tmp_path,
        "--set", "figures=[tracing]",
    )  # fmt: skip
    assert code == 2 and "no figure is called 'tracing'" in err and "'tracking'" in err


SHORT = "reference.tones=[{frequency: 1 Hz, periods: 2}]"


def compare(capsys, out, *options):
    return run(
        capsys, "compare", "cylinder-sine", "--on", "sim", "--configs", CONFIGS, "--out", out,
        "--set", SHORT, "--set", "metrics={tracking_rms: {}}", "--set", "figures=[tracking]",
        "--json", *options,
    )  # fmt: skip


@pytest.mark.usefixtures("warm_workers")
def test_compare_runs_controllers_side_by_side(tmp_path, capsys):
    code, out, err = compare(capsys, tmp_path, "--controllers", "pid,cascade")
    content = json.loads(out)
    assert code == 0 and content["labels"] == ["pid", "cascade"]
    row, *_ = content["metrics"]
    assert row["values"][0] > row["values"][1] > 0.0
    figure = Path(err.rpartition("figure: ")[2].strip())
    assert figure.stat().st_size > 10_000


def test_compare_varies_a_setting_and_leaves_out_what_is_refused(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # so that this process does it all
    amplitudes = "reference.amplitude=5 mm,8 mm,25 mm"
    code, out, err = compare(capsys, tmp_path, "--vary", amplitudes)
    assert code == 0
    content = json.loads(out)
    assert content["labels"] == ["amplitude 5 mm", "amplitude 8 mm", "amplitude 25 mm"]
    assert len(content["runs"]) == 2 and list(content["refused"]) == ["amplitude 25 mm"]
    assert "amplitude 25 mm: refused" in err and "limits.position" in err
    code, out, err = compare(capsys, tmp_path, "--vary", "cylinder.limits.following=4 mm,0.01 mm")
    content = json.loads(out)
    assert code == 4 and content["labels"] == ["following 4 mm", "following 0.01 mm"]
    assert "outside" in content["faulted"]["following 0.01 mm"]
    assert content["metrics"][0]["values"][1] is None
    code, _, err = compare(capsys, tmp_path, "--vary", "reference.amplitude=25 mm,26 mm")
    assert code == 2 and "at 26 mm" in err
    code, _, err = compare(capsys, tmp_path, "--vary", "reference.amplitude")
    assert code == 2 and "two values" in err


@pytest.mark.parametrize(
    "words",
    [
        ["calibrate", "cylinder", "encoders", "--dry-run", "--valid-for", "99999999999"],
        ["commission", "cylinder", "--dry-run", "--valid-for", "99999999999"],
        ["faults", "run", "cylinder", "--quiet", "1e300"],
    ],
)
def test_a_time_that_nobody_lives_to_see_is_refused(words, capsys):
    assert invoke(words) == 2
    assert "is not in the range" in capsys.readouterr().err
