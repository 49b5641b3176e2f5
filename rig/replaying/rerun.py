"""A run once more, from its folder alone."""

from pathlib import Path

from rig.assembly import Backend
from rig.config.yaml_loader import read_source
from rig.experiment.plan import Plan
from rig.experiment.run import Result, run_experiment
from rig.experiment.watcher import Watcher
from rig.hal import ConfigurationError
from rig.replaying.recorded import plan_of
from rig.run_folder import RunFolder

_CALIBRATION = "calibration"


class Repeat:
    """A run that is to be repeated: its plan, and what it ran on.

    Parameters
    ----------
    path : Path
        The run folder. Its profile and experiment are resolved: nothing else is read but the
        device files beside them.

    Raises
    ------
    ConfigurationError
        It is no whole run folder, or the code at hand cannot run what is in it.
    """

    def __init__(self, path: Path) -> None:
        self.folder = RunFolder.open(path)
        manifest = self.folder.manifest
        plan = plan_of(self.folder)
        calibrations = {
            f"{_CALIBRATION}/{file.name}": read_source(file).text
            for file in sorted((path / _CALIBRATION).glob("*.yaml"))
        }
        self.plan: Plan = plan._replace(sources={**plan.sources, **calibrations})
        backend = manifest.get("backend", "")
        if backend not in list(Backend):
            raise ConfigurationError(f"{path}: its manifest names no backend to run on")
        self.backend = Backend(backend)
        words = manifest.get("command", [])
        on = words[words.index("--on") + 1] if "--on" in words[:-1] else backend
        self.on = on if on not in list(Backend) else None
        """Other CAN interfaces than the backend's own, if it ran on some."""

    def run(
        self, out: Path, watcher: Watcher, *, report: bool, uncommissioned: str | None = None
    ) -> Result:
        """Run it; the new folder's command repeats this one."""
        return run_experiment(
            self.plan,
            self.backend,
            out,
            on=self.on,
            watcher=watcher,
            report=report,
            uncommissioned=uncommissioned,
            command=("rig", "rerun", str(self.folder.path.resolve())),
        )
