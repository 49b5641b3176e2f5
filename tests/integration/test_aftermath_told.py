"""What came of a case is told where a person looks: explanation, page, figure and events."""

import json

import pytest

from rig.cli import invoke


@pytest.fixture
def broken(tmp_path, monkeypatch, capfd):
    """Return a function that cuts a wire, and returns exit code, run folder and what was said."""
    monkeypatch.chdir(tmp_path)

    def breaks(when, rest=""):
        (tmp_path / "wire.yaml").write_text(
            "rig: cylinder\nexperiment: cylinder-sine\nfault: wire_cut\nwhere: plant agonist\n"
            f"when: {when}\n{rest}"
        )
        code = invoke(["faults", "run", "wire.yaml", "--keep-all", "--workers", "1",
                       "--out", "faults"])  # fmt: skip
        (folder,) = tmp_path.glob("faults/seed-0/*/*-cylinder-sine-virtual")
        return code, folder, capfd.readouterr()

    return breaks


def test_a_hazard_that_is_not_counted_is_told_wherever_one_looks(broken, capfd):
    code, folder, said = broken("{phase: run, after: 2 s}")
    hit = "end stop hit of position: -30."
    assert code == 0
    assert f"not counted: {hit}" in said.err and "ms after it broke" in said.err
    page = (folder.parents[1] / "campaign.html").read_text()
    assert hit in page and "nothing could keep off after wire_cut" in page
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    assert [e["data"]["hazard"] for e in events if e["kind"] == "not counted"] == [
        "position", "end stop hit",
    ]  # fmt: skip
    assert invoke(["explain", str(folder)]) == 0
    assert hit in " ".join(capfd.readouterr().out.split())
    assert invoke(["report", str(folder)]) == 0
    assert (folder / "figures" / "truth.png").stat().st_size > 10_000
    assert hit in (folder / "report.html").read_text()
    drawn = (folder / "figures" / "truth.csv").read_text()
    assert "position" in drawn.partition("\n")[0]


def test_what_broke_before_the_log_began_is_explained(broken, capfd):
    code, folder, _ = broken("{phase: connect, after: 20 ms}")
    assert code == 0
    assert invoke(["explain", str(folder)]) == 0
    assert "plant agonist, before the log's clock began" in " ".join(capfd.readouterr().out.split())
    assert invoke(["report", str(folder)]) == 0
    assert (folder / "figures" / "truth.png").exists()
