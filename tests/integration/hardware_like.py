"""A run as of hardware whose loop goes round in the test: its page asks for somebody to hold on."""

import contextlib
import threading
import time
from pathlib import Path

from rig.assembly import make_controller
from rig.config import dump_resolved
from rig.experiment.plan import load_plan
from rig.hal import Column
from rig.run_folder import RunFolder, RunStatus
from rig.runtime.recorder import LogRecorder
from rig.steering.mailbox import Mailbox
from rig.steering.online_gains import OnlineGains

EXPERIMENT = "cylinder-sine"
PERIOD = 1e-3
COLUMNS = [
    Column("phase", "1", "Part of the run."),
    Column("reading.position", "m", "Of the pair."),
]


class HardwareLike:
    """Its law is a real one whose gains change; nothing moves, and nothing is computed.

    Attributes
    ----------
    folder : RunFolder
        Of the run.
    gains : OnlineGains
        In the place of the law.
    pause : threading.Event
        While it is set the loop hangs.
    """

    def __init__(self, out: Path) -> None:
        plan = load_plan(EXPERIMENT)
        profile = dump_resolved(plan.profile)
        self.folder = RunFolder.create(
            out, EXPERIMENT, "hardware", inputs={"profile.yaml": profile}, law="cascade"
        )
        law = make_controller(plan.profile, "cascade")
        law.update = lambda state, reference: None
        self.gains = OnlineGains(law, Mailbox(self.folder.path, create=True), needs_hold=True)
        self.pause = threading.Event()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._loop, daemon=True)

    def _loop(self) -> None:
        begun, hung, cycle = time.monotonic(), 0.0, 0
        with LogRecorder(self.folder.log_path, COLUMNS) as recorder:
            while not self._over.wait(5e-3):
                if self.pause.is_set():
                    hung = time.monotonic() - begun - cycle * PERIOD
                while cycle * PERIOD < time.monotonic() - begun - hung and not self.pause.is_set():
                    self.gains.update(None, None)
                    recorder.write(cycle, cycle * PERIOD, (1.0, 1e-3 * (cycle % 1000)))
                    cycle += 1
                for said in self.gains.said:
                    t = said.cycle * PERIOD
                    self.folder.record_event(t, "tuning", said.message, who="test", **said.data)
                self.gains.said.clear()


@contextlib.contextmanager
def hardware_like(out: Path):
    """Yield a `HardwareLike` that goes on."""
    run = HardwareLike(out)
    run._thread.start()
    try:
        yield run
    finally:
        run._over.set()
        run._thread.join()
        run.folder.finish(RunStatus.OK, 0)
