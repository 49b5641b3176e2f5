"""A simulated arm that is steered by a gamepad, whose owner lives in real time."""

import json
import os
import sys
from types import SimpleNamespace

import pytest

from rig.cli import invoke

EXPERIMENT = """\
name: steered
rig: arm
law: esc
reference: {kind: arm-gamepad, duration: 2 s}
approach: 4 s
metrics: {}
"""


class QuietPad:
    """A gamepad that is there and that nobody touches."""

    def __init__(self, path):
        del path
        self.fd, self._out = os.pipe()

    def absinfo(self, code):
        del code
        return SimpleNamespace(min=0, max=255)

    def capabilities(self, absinfo=True):
        del absinfo
        return {1: [0x136], 3: [0x00, 0x01, 0x03, 0x04, 0x10, 0x11]}

    def close(self):
        os.close(self.fd)
        os.close(self._out)


@pytest.mark.slow
def test_a_gamepad_is_heard_in_a_simulation(monkeypatch, tmp_path):
    """As fast as the simulation could go, 60 ms without a word would pass in no time."""
    module = SimpleNamespace(InputDevice=QuietPad, list_devices=lambda: ["/dev/input/event0"])
    monkeypatch.setitem(sys.modules, "evdev", module)
    file = tmp_path / "steered.yaml"
    file.write_text(EXPERIMENT)
    command = ["run", str(file), "--on", "sim", "--no-report", "--out", str(tmp_path / "runs")]
    assert invoke(command) == 0
    (run,) = (tmp_path / "runs").iterdir()
    events = [json.loads(line) for line in (run / "events.jsonl").read_text().splitlines()]
    assert "silence" not in {event["kind"] for event in events}
