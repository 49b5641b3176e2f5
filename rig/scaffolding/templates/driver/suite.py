"""The sensor in a run: its column is in the log. Run pytest where `configs` is."""

from pathlib import Path

import rig


def test_the_sensor_is_logged(tmp_path: Path) -> None:
    """A run on emulated devices has a value of the sensor in every cycle, and it moves."""
    run = rig.run("my-sensor-sine", out=tmp_path, report=False, progress=False)
    value = run.data["device.my_sensor_value"]
    assert len(value) == len(run.data) > 1000
    assert max(value) - min(value) > 1.0  # N: the simulated sensor shows the wire's tension
