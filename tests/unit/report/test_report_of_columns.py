"""A report of a log that is too long for the memory."""

from rig.report.data import load_run
from rig.report.regenerate import write_report
from rig.runtime import log_columns
from rig.runtime.log import Log
from rig.runtime.log_columns import FiledColumns

ALL = 64 << 20


def test_it_has_the_same_bytes(make_run, monkeypatch):
    folder = make_run(duration=4.0)
    found = []
    for short, expected in ((ALL, Log), (0, FiledColumns)):
        monkeypatch.setattr(log_columns, "_SHORT", short)
        assert isinstance(load_run(folder).log, expected)
        for name in ("metrics.json", "timing.json"):
            (folder / name).unlink()
        assert write_report(folder).failures == []
        files = [
            folder / "metrics.json",
            folder / "timing.json",
            *folder.glob("figures/*.[cps][sn]?"),
        ]
        found.append({path.name: path.read_bytes() for path in files})
    assert len(found[0]) > 4
    assert found[0] == found[1]
