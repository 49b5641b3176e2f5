from pathlib import Path

import pytest
from config_fakes import CALIBRATION, EXPERIMENT, PROFILE, FakeRegistry

from rig.config.calibration import seal
from rig.config.experiment import load_experiment
from rig.config.profile import load_profile


class Configs:
    """A folder of configurations on disk."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.registry = FakeRegistry()
        self.write("rigs/bench.yaml", PROFILE)
        self.write("experiments/bench-sine.yaml", EXPERIMENT)

    def write(self, name: str, text: str) -> Path:
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def edit(self, old: str, new: str, name: str = "rigs/bench.yaml") -> None:
        path = self.path / name
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    def calibrate(self, old: str = "", new: str = "") -> None:
        text = seal(CALIBRATION.replace(old, new, 1))
        self.write("calibration/bench/encoder.yaml", text)

    def profile(self, source="bench", *overrides: str):
        return load_profile(source, self.registry, overrides, [self.path])

    def experiment(self, source="bench-sine", *overrides: str):
        return load_experiment(source, self.registry, overrides, [self.path])


@pytest.fixture
def configs(tmp_path):
    return Configs(tmp_path)
