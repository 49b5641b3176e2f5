"""`rig replay`, `diff` and `rerun` as their users call them, and what they say of bad input."""

import json
import os
import random
import shutil
import subprocess
import sys
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from rig.cli import invoke
from rig.runtime.log import read_log

ROOT = Path(__file__).parents[2]
SHORT = (
    "--set", "approach=0.2 s", "--set", "loop.rate=250 Hz", "--set", "reference.dwell=0.2 s",
    "--set", "reference.rise=0 s", "--set", "reference.size=1 mm",
)  # fmt: skip
BEND = ("--set", "approach=0.2 s", "--set", "reference.repeats=1", "--set", "reference.time=1 s")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return a folder with runs of one step: three seeds, and other settings."""
    out = tmp_path_factory.mktemp("runs")
    for options in (("--seed", "1"), ("--seed", "2"), ("--seed", "3"),
                    ("--seed", "1", "--set", "reference.size=4 mm")):  # fmt: skip
        assert invoke(["run", "cylinder-step", "--on", "sim", "--out", str(out), "--no-report",
                       *SHORT, *options]) in (0, 1)  # fmt: skip
    return out


def names(runs):
    return sorted(path.name for path in runs.iterdir())


def test_the_code_at_hand_commands_what_was_recorded(runs, capsys):
    name = names(runs)[0]
    assert invoke(["replay", name, "--runs", str(runs), "--verify"]) == 0
    cycles = len(read_log(runs / name / "log.mcap").cycle)
    assert capsys.readouterr().out == f"{cycles} cycles, every number the same\n"


def test_a_difference_is_named_and_explained(runs, capsys, monkeypatch):
    from controllers.cylinder.cascade import Cascade

    plain = Cascade.update
    at = random.Random(1).randrange(20, 60)
    calls = []

    def update(self, state, reference, load=0.0):
        command = plain(self, state, reference, load)
        calls.append(state.t)
        return command._replace(antagonist=command.antagonist + (len(calls) == at) * 0.5)

    monkeypatch.setattr(Cascade, "update", update)
    assert invoke(["replay", names(runs)[0], "--runs", str(runs), "--explain"]) == 1
    out = capsys.readouterr().out
    log = read_log(runs / names(runs)[0] / "log.mcap")
    row = int(np.argmax(log.column("clock") == calls[at - 1]))
    assert f"cycle {log.cycle[row]} (" in out and "command.antagonist" in out
    assert f"the same for {row} cycles" in out
    assert f"{log.cycle[row]}*" in out
    assert repr(float(log.column("reading.pressure_agonist")[row])) in out


def test_another_law_is_asked_in_open_loop_and_drawn(runs, capsys, tmp_path):
    name = names(runs)[0]
    asked = ["replay", name, "--runs", str(runs), "--controller", "pid", "--out", str(tmp_path)]
    assert invoke(asked) == 0
    told = capsys.readouterr()
    assert "open loop: pid" in told.err and "readings of cascade" in told.err
    assert "command.agonist" in told.out
    assert (tmp_path / "commands.png").stat().st_size > 10_000
    # The law that ran answers as it did: nothing is apart.
    asked = ["replay", name, "--runs", str(runs), "--controller", "cascade"]
    assert invoke([*asked, "--out", str(tmp_path)]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if "command." in line]
    assert {row[1] for row in rows} == {"0"}


def test_a_difference_that_chance_explains_is_told_from_one_that_it_does_not(runs, capsys):
    one, other, _, changed = names(runs)
    assert invoke(["diff", one, one, "--runs", str(runs)]) == 0
    assert "every cycle of both logs is the same" in capsys.readouterr().out
    assert invoke(["diff", one, other, "--runs", str(runs)]) == 1
    out = capsys.readouterr().out
    assert "simulation.seed" in out and "σ" in out and "differ first at cycle 0" in out
    assert invoke(["diff", one, changed, "--runs", str(runs)]) == 1
    out = capsys.readouterr().out
    assert "reference.size" in out and "simulation.seed" not in out
    first = next(line for line in out.splitlines() if "differ first" in line)
    # The seed is the same: the first that differs is where the reference goes.
    assert "reference." in first


def test_how_long_the_cycles_of_both_took_is_told_by_stage(runs, capsys, tmp_path):
    for name in names(runs)[:2]:
        shutil.copytree(runs / name, tmp_path / name)
    one, other = names(tmp_path)
    asked = ["diff", one, other, "--runs", str(tmp_path)]
    timing = {
        name: json.loads((tmp_path / name / "timing.json").read_text()) for name in names(tmp_path)
    }
    invoke([*asked, "--json"])
    found = {(t["stage"], t["which"]): (t["first"], t["second"])
             for t in json.loads(capsys.readouterr().out)["timing"]}  # fmt: skip
    assert {stage for stage, _ in found} == {"work", *timing[one]["stages"]}
    for (stage, which), values in found.items():
        of = [t["work"] if stage == "work" else t["stages"][stage] for t in timing.values()]
        assert values == tuple(t["p50" if which == "median" else "p99"] for t in of)
    timing[other]["stages"]["control"]["p99"] = 0.25
    (tmp_path / other / "timing.json").write_text(json.dumps(timing[other]))
    invoke(asked)
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "control, p99" in line)
    assert line.endswith("0.25 s")
    for spoil in (lambda path: path.write_text("{}"), Path.unlink):  # of a log without times; none
        spoil(tmp_path / other / "timing.json")
        invoke(asked)
        assert "control" not in capsys.readouterr().out


def test_what_never_came_is_no_missing_number(runs, capsys, tmp_path):
    for name in names(runs)[:2]:
        shutil.copytree(runs / name, tmp_path / name)
    one, other = names(tmp_path)
    for name, change in ((one, {"value": None}), (other, {"value": None, "is_nan": True})):
        path = tmp_path / name / "metrics.json"
        content = json.loads(path.read_text())
        content["metrics"][0].update(name="late", bound=None, **change)
        path.write_text(json.dumps(content))
    assert invoke(["diff", one, other, "--runs", str(tmp_path)]) == 1
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("late"))
    assert line.split()[1:4] == ["never", "-", "-"]


def test_without_seeds_beside_it_chance_is_unknown(runs, capsys, tmp_path):
    for name in names(runs)[:2]:
        shutil.copytree(runs / name, tmp_path / name)
    assert invoke(["diff", *names(runs)[:2], "--runs", str(tmp_path)]) == 1
    assert "spread over seeds unknown" in capsys.readouterr().out


# Frames -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def framed(tmp_path_factory):
    out = tmp_path_factory.mktemp("framed")
    made = {}
    for experiment, options in {
        "cylinder-step": SHORT,
        "arm-wrist-hit": ("--set", "approach=0.5 s"),
    }.items():
        assert invoke(["run", experiment, "--frames", "--out", str(out), "--no-report",
                       *options]) in (0, 1)  # fmt: skip
        (made[experiment],) = set(out.iterdir()) - set(made.values())
    return made


@pytest.mark.parametrize("experiment", ["cylinder-step", "arm-wrist-hit"])
def test_the_drivers_read_from_the_frames_what_they_read_then(experiment, framed, capsys):
    folder = framed[experiment]
    assert invoke(["replay", str(folder), "--frames"]) == 0
    cycles = len(read_log(folder / "log.mcap").cycle)
    assert capsys.readouterr().out == f"{cycles} cycles, every number the same\n"


def test_one_bit_of_one_frame_is_seen(framed, tmp_path, capsys):
    """In a reading of its cycle: a frame of an encoder, drawn among those of the run."""
    folder = tmp_path / "run"
    shutil.copytree(framed["cylinder-step"], folder)
    lines = (folder / "frames.log").read_text().splitlines()
    samples = [k for k, line in enumerate(lines) if " 1A0#" in line]
    k = random.Random(2).choice(samples[len(samples) // 4 :])
    head, data = lines[k].split("#")
    lines[k] = f"{head}#{int(data[:2], 16) ^ 1:02X}{data[2:]}"
    (folder / "frames.log").write_text("\n".join(lines) + "\n")
    assert invoke(["replay", str(folder), "--frames"]) == 1
    out = capsys.readouterr().out
    assert "the log says" in out and "the same for 0 cycles" not in out


def test_a_driver_that_sends_something_else_is_seen(framed, capsys, monkeypatch):
    from drivers.canopen.bus import CanopenBus

    plain = CanopenBus.transmit

    def transmit(self, now):
        for frame in self._cyclic:
            frame.data = bytes([255] * len(frame.data))
        plain(self, now)

    monkeypatch.setattr(CanopenBus, "transmit", transmit)
    assert invoke(["replay", str(framed["cylinder-step"]), "--frames"]) in (1, 3, 4)
    told = capsys.readouterr()
    assert "the drivers at hand send" in told.out + told.err


@pytest.mark.parametrize(
    ("experiment", "on", "options", "words"),
    [
        (
            "cylinder-step",
            "sim",
            SHORT,
            "on sim, which has no buses and so no frames; runs on virtual, vcan, hardware have",
        ),
        ("cylinder-step", "virtual", SHORT, "no frames: they are recorded by rig run --frames"),
        ("legs-squat", "virtual", BEND, "hangs on no CAN bus"),
    ],
)
def test_frames_that_are_not_there_are_a_sentence(experiment, on, options, words, tmp_path, capsys):
    assert invoke(["run", experiment, "--on", on, "--out", str(tmp_path), "--no-report",
                   *options]) in (0, 1)  # fmt: skip
    (folder,) = tmp_path.iterdir()
    assert invoke(["replay", str(folder), "--frames"]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("backend", ["vcan", "hardware"])
def test_frames_of_the_walls_clock_are_not_replayed(backend, framed, tmp_path, capsys):
    folder = shutil.copytree(framed["cylinder-step"], tmp_path / "run")
    manifest = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps({**manifest, "backend": backend}))
    assert invoke(["replay", str(folder), "--frames"]) == 2
    assert f"ran on {backend}: only frames of a run on virtual" in capsys.readouterr().err


# Again ------------------------------------------------------------------------------------------


def in_a_fresh_shell(line, tmp_path, path=ROOT):
    """Run a line as a user pastes it, elsewhere, with nothing but `rig` to be found."""
    shim = tmp_path / "bin" / "rig"
    shim.parent.mkdir(exist_ok=True)
    shim.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m rig "$@"\n')
    shim.chmod(0o755)
    there = tmp_path / "elsewhere"
    there.mkdir(exist_ok=True)
    env = {"PATH": f"{shim.parent}:{os.environ['PATH']}", "PYTHONPATH": str(path),
           "HOME": os.environ.get("HOME", "/"), "MPLBACKEND": "Agg"}  # fmt: skip
    done = subprocess.run(
        ["/bin/sh", "-c", line], cwd=there, env=env, capture_output=True, text=True, check=False
    )
    return done, there


def lines_of_report(folder):
    page = (folder / "report.html").read_text()
    return unescape(page.partition("run it again")[2].partition("<pre>")[2].partition("</pre>")[0])


def test_the_reports_line_runs_it_again(runs, tmp_path):
    """From a file that is nowhere near the configurations, and with an option of two words."""
    mine = tmp_path / "my lab" / "my-step.yaml"
    mine.parent.mkdir()
    text = (ROOT / "configs" / "experiments" / "cylinder-step.yaml").read_text()
    mine.write_text(text.replace("name: cylinder-step", "name: my-step"))
    out = tmp_path / "runs"
    words = ["run", str(mine), "--on", "sim", "--out", str(out), *SHORT]
    words += ["--set", "figures=[timing]"]
    assert invoke([*words, "--set", "simulation.seed=5"]) in (0, 1)
    (folder,) = out.iterdir()
    page = (folder / "report.html").read_text()
    assert "<dt>rig</dt><dd>cylinder</dd>" in page and "<dt>law</dt><dd>cascade</dd>" in page
    line = lines_of_report(folder).splitlines()[-1]
    done, there = in_a_fresh_shell(f"{line} --no-report", tmp_path)
    assert done.returncode in (0, 1), done.stderr
    (again,) = (there / "runs").iterdir()
    assert (again / "metrics.json").read_bytes() == (folder / "metrics.json").read_bytes()


def rows_of(folder):
    log = read_log(folder / "log.mcap")
    kept = [k for k, c in enumerate(log.columns) if not c.name.startswith("timing.")]
    return log.cycle.tobytes(), log.t.tobytes(), log.values[:, kept].tobytes()


def test_another_copy_of_the_code_comes_to_the_same_bytes(tmp_path):
    out = tmp_path / "runs"
    assert invoke(["run", "arm-wrist-hit", "--on", "sim", "--out", str(out), "--no-report",
                   "--set", "approach=0.5 s", "--seed", "7"]) in (0, 1)  # fmt: skip
    (folder,) = out.iterdir()
    copy = tmp_path / "copy"
    for part in ("rig", "drivers", "controllers", "configs"):
        shutil.copytree(ROOT / part, copy / part, ignore=shutil.ignore_patterns("__pycache__"))
    done, there = in_a_fresh_shell(f"rig rerun '{folder}' --no-report", tmp_path, copy)
    assert "every cycle is as it was" in done.stdout, done.stderr
    (again,) = (there / "runs").iterdir()
    assert rows_of(again) == rows_of(folder)
    assert (again / "metrics.json").read_bytes() == (folder / "metrics.json").read_bytes()
    manifest = json.loads((again / "manifest.json").read_text())
    assert manifest["command"] == ["rig", "rerun", str(folder)]
    assert manifest["seed"] == 7


def test_a_run_is_run_again_with_what_lay_over_its_profile(tmp_path, runs):
    """A calibration is in the folder's profile, and its file goes with it into the next one."""
    source = runs / names(runs)[0]
    folder = tmp_path / "calibrated"
    shutil.copytree(source, folder)
    (folder / "calibration").mkdir()
    (folder / "calibration" / "regulators.yaml").write_text("values: {}\n")
    assert invoke(["rerun", str(folder), "--out", str(tmp_path / "out"), "--no-report"]) in (0, 1)
    (again,) = (tmp_path / "out").iterdir()
    assert (again / "calibration" / "regulators.yaml").read_text() == "values: {}\n"
    assert rows_of(again) == rows_of(source)


# Bad input --------------------------------------------------------------------------------------


def no_manifest(folder):
    (folder / "manifest.json").unlink()


def no_profile(folder):
    (folder / "profile.yaml").unlink()


def torn_experiment(folder):
    text = (folder / "experiment.yaml").read_text()
    (folder / "experiment.yaml").write_text(text[: len(text) // 2] + "\nrefer: [")


def other_profile(folder):
    text = (folder / "profile.yaml").read_text()
    (folder / "profile.yaml").write_text(text + "gravity_compensation: true\n")


def no_log(folder):
    (folder / "log.mcap").unlink()


def torn_log(folder):
    (folder / "log.mcap").write_bytes((folder / "log.mcap").read_bytes()[:700])


def flipped_log(folder):
    content = bytearray((folder / "log.mcap").read_bytes())
    content[len(content) // 2] ^= 1
    (folder / "log.mcap").write_bytes(content)


def other_log(folder):
    (folder / "log.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(500))


BAD = {
    no_manifest: "not a run folder", no_profile: "profile.yaml",
    torn_experiment: "experiment.yaml", other_profile: "gravity_compensation",
    no_log: "log.mcap", torn_log: "ends before", flipped_log: "checksum", other_log: "log.mcap",
}  # fmt: skip


@pytest.mark.parametrize("spoil", BAD, ids=lambda spoil: spoil.__name__)
def test_a_folder_that_is_not_whole_is_a_sentence(spoil, runs, tmp_path, capsys):
    folder = tmp_path / "run"
    shutil.copytree(runs / names(runs)[0], folder)
    spoil(folder)
    commands = [["replay", str(folder)]]
    if "log" not in spoil.__name__:
        commands.append(["rerun", str(folder), "--out", str(tmp_path / "out")])
    if spoil not in (other_profile, torn_experiment):
        commands.append(["diff", str(runs / names(runs)[0]), str(folder)])
    for command in commands:
        assert invoke(command) in (2, 3), command
        err = capsys.readouterr().err
        assert BAD[spoil] in err and "Traceback" not in err, (command, err)


def test_a_log_of_an_older_version_is_told_from_a_damaged_one(runs, tmp_path, capsys):
    from rig.runtime.recorder import LogRecorder

    folder = tmp_path / "run"
    shutil.copytree(runs / names(runs)[0], folder)
    log = read_log(folder / "log.mcap")
    (folder / "log.mcap").unlink()
    kept = [k for k, column in enumerate(log.columns) if column.name not in ("clock", "fault")]
    with LogRecorder(folder / "log.mcap", [log.columns[k] for k in kept]) as recorder:
        for cycle, t, row in zip(log.cycle, log.t, log.values[:, kept], strict=True):
            recorder.write(int(cycle), float(t), row.tolist())
    assert invoke(["replay", str(folder)]) == 2
    assert "no column clock, fault: an older version" in capsys.readouterr().err


def test_options_that_do_not_go_together_are_refused(runs, capsys):
    asked = ["replay", names(runs)[0], "--runs", str(runs), "--verify", "--controller", "pid"]
    assert invoke(asked) == 2
    assert "--verify" in capsys.readouterr().err
    assert invoke(["replay", names(runs)[0], "--runs", str(runs), "--controller", "bang"]) == 2
    assert "bang" in capsys.readouterr().err
