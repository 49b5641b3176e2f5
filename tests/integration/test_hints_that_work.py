"""Commands that the program recommends do what they are recommended for."""

import re

import pytest

from rig.cli import invoke
from rig.explaining.faults import fault_topics, refusal_topics

STOP = "cylinder.limits.stop_energy=1 J"


def monitors():
    """Return every `rig monitor` with words of its own that a topic names."""
    texts = [str(topic) for topic in (*fault_topics(), *refusal_topics())]
    found = {said for text in texts for said in re.findall(r"`(rig monitor[^`]*)`", text)}
    assert len(found) > 1
    return sorted(found)


@pytest.mark.parametrize("said", monitors())
def test_what_shows_frames_says_whose(tmp_path, monkeypatch, capsys, said):
    """There is neither a bus nor a run: more than that nobody has against it."""
    monkeypatch.chdir(tmp_path)
    words = said.replace("RIG", "cylinder").replace("RUN", "no-run").split()[1:]
    invoke([*words, "--for", "0.1", "--set", "buses.can0.channel=nocan7"])
    told = capsys.readouterr().err
    assert "Say whose frames" not in told and "Usage" not in told, told
    assert "nocan7" in told or "no-run" in told or "SocketCAN" in told


def test_nobody_is_sent_to_a_recording_that_holds_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    words = ["calibrate", "cylinder", "response", "--on", "hardware", "--yes", "cylinder"]
    words += ["--uncommissioned", "a test", "--set", STOP, "--set", "buses.can0.channel=nocan7"]
    assert invoke(words) == 3
    told = capsys.readouterr().err
    assert list((tmp_path / "runs").iterdir())
    assert "nothing was changed; nothing was recorded\n" in told
    assert "--from" not in told
