"""`rig explain` of a run after which a device is not known to be safe: that comes first."""

from rig.cli import invoke


def test_what_may_not_be_safe_is_said_first(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    broken = "simulation.faults=[{at: 1 s, device: regulators, fault: wire_break}]"
    short = ("reference.tones=[{frequency: 1 Hz, periods: 2}]", "approach=0.3 s", "metrics={}")
    words = [word for setting in (broken, *short) for word in ("--set", setting)]
    assert invoke(["run", "cylinder-sine", "--no-report", *words]) == 4
    capsys.readouterr()
    assert invoke(["explain"]) == 0
    lines = capsys.readouterr().out.splitlines()
    labels = [line.partition(":")[0] for line in lines if not line.startswith(" ")]
    assert labels[:3] == ["run", "not safe", "message"]
    kinds = [line for line in lines if line.startswith("kind: ")]
    assert kinds == ["kind: not_safe", "kind: monitor"]
    assert "regulators: not known to be safe" in " ".join(lines)
