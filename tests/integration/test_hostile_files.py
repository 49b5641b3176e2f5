"""Files of others under every command that reads one: no escape sequence, no hang, no bomb."""

import json
import os
import resource
import signal
import subprocess
import sys

import pytest

from rig.cli import invoke
from rig.cli.tables import visible

BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join([f'*{chr(97 + k)}'] * 10)}]\n" for k in range(10)
)
TEXTS = {
    "bomb": BOMB,
    "deep": "[" * 3000,
    "deeper": "[" * 100_000,
    "deepest": "{a: " * 200_000,
    "escape": 'description: "\\e]0;pwned\\a"\nmechanism: cylinder\n',
    "latin": "description: \xff\n",
    "list": "- a\n",
    "empty": "",
    "tag": "description: !!python/object/apply:os.system [touch pwned]\n",
}


@pytest.fixture
def quick():
    """Fail what takes longer than it may, wherever it waits."""

    def too_long(*_):
        raise TimeoutError

    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(20)
    yield
    signal.alarm(0)


@pytest.fixture
def configs(tmp_path):
    for folder in ("rigs", "experiments"):
        (tmp_path / "configs" / folder).mkdir(parents=True)
    return tmp_path / "configs"


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("folder", ["rigs", "experiments"])
@pytest.mark.parametrize("kind", [*TEXTS, "pipe", "endless", "gone", "folder"])
def test_a_list_shows_its_neighbours_whatever_a_file_holds(folder, kind, configs, capfd):
    (configs / folder / "good.yaml").write_text("description: the good one\n")
    bad = configs / folder / "bad.yaml"
    if kind == "pipe":
        os.mkfifo(bad)
    elif kind in ("endless", "gone"):
        bad.symlink_to("/dev/zero" if kind == "endless" else "/nowhere")
    elif kind == "folder":
        bad.mkdir()
    else:
        bad.write_bytes(TEXTS[kind].encode("latin-1"))
    assert invoke(["list", folder, "--configs", str(configs)]) == 0
    out = capfd.readouterr().out
    assert "the good one" in out
    assert "\x1b" not in out and "\x07" not in out
    if kind not in ("list", "empty"):
        assert "cannot be read; see `rig check" in out


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("kind", [*TEXTS, "pipe", "endless", "gone", "folder"])
@pytest.mark.parametrize("command", ["check", "run", "monitor"])
def test_no_command_waits_for_a_file_or_obeys_it(command, kind, tmp_path, capfd):
    path = tmp_path / "mine.yaml"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind in ("endless", "gone"):
        path.symlink_to("/dev/zero" if kind == "endless" else "/nowhere")
    elif kind == "folder":
        path.mkdir()
    else:
        path.write_bytes(TEXTS[kind].encode("latin-1"))
    assert invoke([command, str(path)]) == 2
    err = capfd.readouterr().err
    assert "Traceback" not in err and "\x1b" not in err
    assert not (tmp_path / "pwned").exists()


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("kind", ["pipe", "endless", "secret", "large", "folder"])
@pytest.mark.parametrize("key", ["eds", "extends"])
def test_what_a_profile_names_is_bounded_and_not_quoted(key, kind, tmp_path, capsys):
    other = tmp_path / "other"
    if kind == "pipe":
        os.mkfifo(other)
    elif kind == "endless":
        other.symlink_to("/dev/zero")
    elif kind == "folder":
        other.mkdir()
    else:
        other.write_text("root:*:20228:secret\n" * (1 if kind == "secret" else 1_000_000))
    path = tmp_path / "mine.yaml"
    path.write_text(
        f"extends: {other}\n" if key == "extends"
        else f"extends: cylinder\ndevices:\n  regulators:\n    eds: {other}\n"
    )  # fmt: skip
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert invoke(["check", str(path)]) == 2
    err = capsys.readouterr().err
    assert "secret" not in err.replace(str(tmp_path), "") and "mine.yaml:" in err
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - most < 300_000  # kB


@pytest.mark.parametrize("text", ["\x1b]0;pwned\x07", "\x9b2J", "a\u202eb", "\ud800", "\x00"])
def test_what_a_terminal_would_obey_is_written_out(text):
    shown = visible(text)
    assert shown.isprintable() and "\\u" in shown
    assert json.loads(f'"{shown}"') == text
    assert visible("µ – \n\t日本") == "µ – \n\t日本"


def test_an_error_that_quotes_a_megabyte_is_cut(tmp_path, capsys):
    path = tmp_path / "mine.yaml"
    path.write_text(f"experiment: cylinder-step\nrepeat: 2\nstop_when: {'x' * 200_000}\n")
    assert invoke(["sweep", str(path)]) == 2
    err = capsys.readouterr().err
    assert len(err) < 20_000
    assert "stop_when: stop when 'xxx" in err and "as in marker_rms < 0.2 mm" in err


def test_a_frame_log_has_plain_channels_and_finite_times(tmp_path, capsys):
    path = tmp_path / "frames.log"
    for line in (f"({'9' * 400}.0) can0 190#00", "(1.0) \x1b]0;x\x07 190#00"):
        path.write_text(f"{line}\n(2.0) can0 190#00\n")
        assert invoke(["monitor", "cylinder", "--frames", str(path), "--json"]) == 2
        said = capsys.readouterr()
        assert "frames.log:1: this is no frame" in said.err
        assert "Infinity" not in said.out and "\x1b" not in said.out + said.err


def test_no_segmentation_fault_in_a_process_of_its_own(configs):
    (configs / "rigs" / "deep.yaml").write_text("[" * 500_000)
    done = subprocess.run(
        [sys.executable, "-m", "rig", "list", "--configs", str(configs)],
        capture_output=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0


LONG = "x" * 5000
NAMED = [
    ["run", LONG], ["run", f"{LONG}.yaml"], ["run", "cylinder-sine", "--out", LONG],
    ["run", "cylinder-sine", "--rig", LONG], ["check", LONG], ["explain", LONG], ["replay", LONG],
    ["report", LONG], ["export", LONG], ["compare", LONG, LONG], ["rerun", LONG], ["watch", LONG],
    ["monitor", "cylinder", "--frames", LONG], ["tune", LONG], ["calibrate", LONG],
    ["sweep", "--seeds", "0:2", LONG], ["faults", "run", LONG], ["faults", "list", LONG],
    ["stop", LONG], ["doctor", LONG], ["new", "rig", LONG],
]  # fmt: skip


@pytest.mark.parametrize("words", NAMED, ids=lambda words: " ".join(word[:9] for word in words))
def test_a_name_longer_than_any_file_may_have_is_no_bug(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert invoke(words) in (1, 2)
    said = capsys.readouterr().err
    assert "rror: " in said
    assert "Traceback" not in said
