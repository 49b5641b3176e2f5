"""A second master on a bus: it is refused, or heard, or what it does is a fault and not a crash.

The hardware is emulated nodes in virtual time, which the program takes for real ones; what the
other master sends is put into what the bus receives.
"""

import os
import textwrap
from pathlib import Path

import numpy as np
import pytest
from warm_start import WarmProcess

from drivers.canopen.settings import CanBusSettings
from rig.assembly import Backend
from rig.assembly.interface_lock import InterfaceLocks
from rig.assembly.simulated import build_virtual
from rig.cli import invoke
from rig.experiment import run as run_module
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal import ConnectionFailed
from rig.run_folder import RunFolder

CONFIGS = Path(__file__).parents[2] / "configs"
GENERATOR = np.random.default_rng(12)
SHORT = [
    "reference.tones=[{frequency: 1 Hz, periods: 2}]", "approach=0.3 s", "metrics={}",
    "loop.small_margin=a test",
]  # fmt: skip
FOREIGN = {  # identifier and bytes of what only the master sends, and its words
    "SYNC": (0x080, b"", "SYNC (identifier 0x080)"),
    "heartbeat": (0x77F, b"\x05", "the master's heartbeat (identifier 0x77F)"),
    "setpoints": (0x210, bytes(5), "setpoints (identifier 0x210)"),
}
LISTENS, RUNS = 0.1, (0.5, 2.0)
"""Until when the program only listens, and when its loop runs, s."""


class Overheard:
    """An interface on which somebody else sends as well."""

    def __init__(self, bus, clock, frames):
        self._bus, self._clock, self._frames = bus, clock, list(frames)

    def __getattr__(self, name):
        return getattr(self._bus, name)

    def drain(self, limit):
        now = self._clock.now()
        due = [frame for frame in self._frames if frame[0] <= now]
        self._frames = [frame for frame in self._frames if frame[0] > now]
        return [(can_id, data) for _, can_id, data in due] + self._bus.drain(limit)


@pytest.fixture
def beside(tmp_path, monkeypatch):
    """Return what runs the pair beside somebody who sends frames: (t, identifier, bytes)."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))

    def run(*frames, backend=Backend.HARDWARE):
        def build(profile, *_):
            made = build_virtual(profile, None)
            made.backend = backend
            bus = made.buses["can0"]
            opened = bus._open_bus
            bus._open_bus = lambda: Overheard(opened(), made.clock, frames)
            return made

        monkeypatch.setattr(run_module, "build_rig", build)
        plan = load_plan("cylinder-sine", SHORT, configs=CONFIGS)
        result = run_experiment(plan, backend, tmp_path / "runs", report=False)
        return result, RunFolder.open(result.path)

    return run


@pytest.mark.parametrize("kind", FOREIGN)
def test_a_master_that_is_heard_is_left_alone(beside, kind):
    can_id, data, words = FOREIGN[kind]
    result, folder = beside((GENERATOR.uniform(0.0, LISTENS), can_id, data))
    assert (result.exit_code, result.status.value) == (3, "faulted")
    assert f"can0: another master is on the bus: somebody sends {words}" in result.message
    sent = folder.manifest["buses"]["can0"]["frames_out"]
    assert sent == 0, "before anybody was reset"


@pytest.mark.parametrize("kind", FOREIGN)
def test_a_master_that_comes_later_is_a_fault_that_says_so(beside, kind):
    can_id, data, words = FOREIGN[kind]
    at = GENERATOR.uniform(*RUNS)
    result, _ = beside((at, can_id, data))
    assert (result.exit_code, result.status.value) == (4, "faulted")
    assert f"another master is on the bus: somebody sends {words}" in result.message


def test_who_is_no_master_is_heard_and_stops_nothing(beside):
    others = [(GENERATOR.uniform(0.0, 2.0), can_id, bytes(4)) for can_id in (0x5B5, 0x7B5, 0x1B5)]
    result, folder = beside(*others)
    assert result.exit_code == 0
    assert folder.manifest["buses"]["can0"]["unknown"] == 3


def test_frames_that_nobody_expects_are_an_event(beside):
    at = GENERATOR.uniform(*RUNS)
    result, folder = beside(*[(at + 1e-3 * k, 0x5B5, b"") for k in range(400)])
    assert result.exit_code == 0
    (event,) = [event for event in folder.events() if event["kind"] == "bus"]
    assert event["message"] == ("can0: frames have come that the profile knows nothing of")


def test_a_controller_that_lost_frames_is_an_event(beside):
    overflow = 0x2000_0004  # an error frame of the controller's class
    result, folder = beside((GENERATOR.uniform(*RUNS), overflow, bytes((0, 1, 0, 0, 0, 0, 0, 0))))
    assert result.exit_code == 0
    (event,) = [event for event in folder.events() if event["kind"] == "bus"]
    assert event["message"] == "can0: error frames say that the controller has lost frames"
    assert event["data"] == {"lost": 1}


@pytest.mark.parametrize("backend", [Backend.HARDWARE, Backend.VIRTUAL])
def test_an_answer_to_somebody_elses_question_is_counted(beside, backend):
    """Before a node is connected, nobody here has asked it anything."""
    answer = bytes.fromhex("4300100092010200")
    frames = [(0.0, 0x580 + node, answer) for node in (0x20, 0x21)]
    result, folder = beside(*frames, backend=backend)
    assert result.exit_code == 0, result.message
    assert folder.manifest["buses"]["can0"]["strange_answers"] == 2


HOLDER = """
    import sys, time
    from drivers.canopen.settings import CanBusSettings
    from rig.assembly.interface_lock import InterfaceLocks
    locks = InterfaceLocks()
    locks.take("can0", CanBusSettings("socketcan", sys.argv[1]))
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path, monkeypatch):
    """Return the channel that another process drives, and that process."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    channel = f"can{os.getpid()}"
    reader, writer = os.pipe()
    with os.fdopen(reader) as said, os.fdopen(writer, "w") as saying:
        process = WarmProcess([channel], textwrap.dedent(HOLDER), stdout=saying, stderr=2)
        assert said.readline() == "held\n"
        yield channel, process
        process.kill()
        process.wait()


def test_an_interface_has_one_master_on_a_host(holder, tmp_path, capsys):
    channel, process = holder
    words = ["--on", channel, "--out", str(tmp_path / "runs"), "--yes", "cylinder", "--no-report"]
    code = invoke(["run", "cylinder-step", *words, "--set", "cylinder.limits.stop_energy=1 J",
                   "--set", "loop.small_margin=a test"])  # fmt: skip
    said = capsys.readouterr().err
    assert code == 3
    assert f"process {process.pid} of this host drives {channel} (socketcan)" in said
    InterfaceLocks().take("can0", CanBusSettings("socketcan", f"{channel}1"))
    InterfaceLocks().take("can0", CanBusSettings("virtual", channel))
    process.kill()
    process.wait()
    locks = InterfaceLocks()
    locks.take("can0", CanBusSettings("socketcan", channel))
    with pytest.raises(ConnectionFailed, match=f"process {os.getpid()} of this host"):
        InterfaceLocks().take("can0", CanBusSettings("socketcan", channel))
    locks.give_back()
    locks.give_back()
    InterfaceLocks().take("can0", CanBusSettings("socketcan", channel))
