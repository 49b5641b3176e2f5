"""A trip that friction at a recommended pressure causes has a mend that names both."""

from pathlib import Path

import pytest

from rig.cli import invoke

WIDE = """\
extends: cylinder
name: wide
cylinder: {bore: 25 mm, rod: 10 mm, stroke: 100 mm, home: 50 mm, base_pressure: 43 kPa}
devices: {encoder-agonist: {stroke: 100 mm}, encoder-antagonist: {stroke: 100 mm}}
plant:
  cylinder: {bore: 25 mm, rod: 10 mm, stroke: 100 mm}
  home: 50 mm
"""


@pytest.mark.parametrize("friction", [1.5, 1.7])
def test_a_pair_that_friction_holds_at_the_recommended_pressure(
    tmp_path, monkeypatch, capsys, friction
):
    monkeypatch.chdir(tmp_path)
    Path("wide.yaml").write_text(WIDE)
    run = ["run", "cylinder-step", "--rig", "wide.yaml", "--on", "sim", "--no-report"]
    assert invoke([*run, "--set", f"plant.friction_scale={friction}"]) == 4
    capsys.readouterr()
    assert invoke(["explain", "latest"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    message = said.partition("message: ")[2].partition("kind: ")[0]
    assert "RIG" not in message
    assert "rig calibrate" not in message or "`rig calibrate wide.yaml friction" in message
    mend = said.partition("mend: ")[2]
    assert "rig calibrate wide.yaml friction" in mend
    assert "a higher `base_pressure`" in mend
