"""The sensor in a run: its column is in the log. Run pytest where `configs` is."""

from pathlib import Path

import rig


def test_the_sensor_is_logged(tmp_path: Path) -> None:
    """A run on emulated devices has a value of the sensor in every cycle."""
    run = rig.run("my-sensor-sine", out=tmp_path, report=False, progress=False)
    assert len(run.data["device.my_sensor_value"]) == len(run.data) > 1000
