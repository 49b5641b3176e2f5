"""What a page is sent of a log: rows as they are, or all that stuck out of them."""

import json
import shutil

import numpy as np
import pytest

from rig.hal import Column
from rig.run_folder import RunFolder, RunStatus
from rig.runtime.recorder import LogRecorder
from rig.stopping import CannotStop, request_stop
from rig.watching.followed_run import FollowedRun
from rig.watching.studio import Studio

ROWS, SPIKES, PERIOD = 400_000, 1000, 1e-3
COLUMNS = np.array([0])


@pytest.fixture(scope="module")
def spiky(tmp_path_factory):
    """A run with 1000 spikes of one cycle each, never two in 200 rows; places and heights."""
    chance = np.random.default_rng(3)
    folder = RunFolder.create(tmp_path_factory.mktemp("spiky"), "spikes", "sim", inputs={})
    every = ROWS // SPIKES
    places = np.arange(SPIKES) * every + chance.integers(0, every // 2, SPIKES)
    heights = np.where(chance.random(SPIKES) < 0.5, -1.0, 1.0) * chance.uniform(5.0, 9.0, SPIKES)
    values = chance.normal(size=ROWS) * 1e-3
    values[places] = heights
    with LogRecorder(folder.log_path, [Column("reading.x", "m", "spiky")]) as recorder:
        for k, value in enumerate(values.tolist()):
            recorder.write(k, k * PERIOD, (value,))
    folder.finish(RunStatus.OK, 0)
    run = FollowedRun(folder.path)
    while run.advance():
        pass
    yield run, values, places, heights
    run.close()


@pytest.mark.parametrize("most", [4000, 6000])
def test_each_of_1000_spikes_of_one_cycle_is_seen_in_the_whole_run(spiky, most):
    run, _, places, heights = spiky
    t, shown = run.window(0, ROWS, COLUMNS, most)
    assert len(t) <= most + 2
    pixel = 2.0 * (t[-1] - t[0]) / (len(t) / 2)
    found = 0
    for place, height in zip(places, heights, strict=True):
        near = np.abs(t - place * PERIOD) <= pixel
        found += bool(np.isclose(shown[near, 0], height, rtol=1e-6).any())
    assert found == SPIKES


@pytest.mark.parametrize("seed", range(8))
def test_each_spike_of_a_window_is_seen_whatever_its_width(spiky, seed):
    run, values, places, heights = spiky
    chance = np.random.default_rng(seed)
    width = int(10 ** chance.uniform(2.0, 5.5))
    first = int(chance.integers(0, ROWS - width))
    t, shown = run.window(first, first + width, COLUMNS, 6000)
    inside = (places >= first) & (places < first + width)
    drawn = set(np.round(shown[:, 0].astype(float), 4))
    assert len(t) <= 6002
    assert {round(float(np.float32(height)), 4) for height in heights[inside]} <= drawn
    if width <= 6000:  # then it is the log itself
        assert np.array_equal(shown[:, 0], values[first : first + width].astype(np.float32))


def test_a_time_leads_to_its_row(spiky):
    run = spiky[0]
    chance = np.random.default_rng(5)
    for row in chance.integers(0, ROWS, 50).tolist():
        assert run.row_at(row * PERIOD) == row
        assert run.row_at(row * PERIOD + 1e-5) == row + 1
    assert run.row_at(-1.0) == 0
    assert run.row_at(1e9) == ROWS


def test_what_cycles_were_like_is_told(tmp_path):
    folder = RunFolder.create(tmp_path, "facts", "hardware", inputs={})
    columns = [
        Column("phase", "", "phase"),
        Column("reference.time", "s", "time"),
        Column("timing.lateness", "s", "late"),
        Column("timing.slack", "s", "slack"),
    ]
    with LogRecorder(folder.log_path, columns) as recorder:
        run = FollowedRun(folder.path)
        for k in (k for k in range(3000) if k % 100 != 50):  # every hundredth tick is missed
            late = 1e-4 if k % 20 == 0 else 1e-6
            recorder.write(k, k * 2e-3, (1.0, k * 2e-3 - 3.0, late, 5e-4 - late))
            if k % 700 == 0:
                run.advance()
        while run.advance():
            pass
        facts = run.facts()
    assert facts.t == pytest.approx(2999 * 2e-3)
    assert facts.reference_time == pytest.approx(2999 * 2e-3 - 3.0)
    assert facts.phase == 1.0
    assert facts.rate == pytest.approx(495.0, rel=0.01)
    assert facts.missed == 30
    assert facts.late == pytest.approx(1e-4)
    assert facts.slack == pytest.approx(4e-4)
    assert not run.is_simulated  # whatever is no simulation by name counts as hardware
    folder.finish(RunStatus.OK, 0)
    run.close()


def test_events_are_read_once_and_torn_ones_later(tmp_path):
    folder = RunFolder.create(tmp_path, "events", "sim", inputs={})
    run = FollowedRun(folder.path)
    folder.record_event(0.1, "state", "first")
    run.look_again()
    with (folder.path / "events.jsonl").open("ab") as stream:
        stream.write(b'{"t": 0.2, "kind": "mark", "mess')
        stream.flush()
        run.look_again()
        assert [event["message"] for event in run.events] == ["first"]
        stream.write(b'age": "second", "data": {}}\nno JSON\n[1]\n')
    folder.record_event(0.3, "state", "third")
    run.look_again()
    run.look_again()
    assert [event["message"] for event in run.events] == ["first", "second", "third"]
    folder.finish(RunStatus.OK, 0)
    run.close()


@pytest.mark.parametrize("approach", [0.0, 0.25, 3.0])
def test_two_runs_are_laid_over_each_other_by_their_motions(tmp_path, approach):
    """However long each rig has taken to get to where the motion begins."""
    runs = []
    for name, before in (("rig", approach), ("rehearsal", 1.0)):
        folder = RunFolder.create(tmp_path, name, "sim", inputs={})
        columns = [
            Column("phase", "", "phase"),
            Column("reference.time", "s", "time"),
            Column("reading.x", "m", "x"),
        ]
        with LogRecorder(folder.log_path, columns) as recorder:
            for k in range(6000):
                t = k * PERIOD
                row = (float(t >= before - 1e-9), t - before, np.sin(t - before))
                recorder.write(k, t, row)
        folder.finish(RunStatus.OK, 0)
        runs.append(FollowedRun(folder.path))
    run, beside = runs
    studio = Studio(run, beside=beside)
    assert run.motion_began() is None  # nothing was read yet
    assert studio.shift == 0.0
    for one in runs:
        while one.advance():
            pass
    assert run.motion_began() == pytest.approx(approach, abs=1e-9)
    assert studio.shift == pytest.approx(approach - 1.0, abs=1e-9)
    t, values = beside.window(1500, 1501, np.array([2]), 10)
    row = run.row_at(float(t[0]) + studio.shift - 1e-9)
    assert run.window(row, row + 1, np.array([2]), 10)[1] == pytest.approx(values, abs=2e-3)
    for one in runs:
        one.close()


def test_a_run_that_was_stopped_on_its_way_has_no_motion(tmp_path):
    folder = RunFolder.create(tmp_path, "stopped", "sim", inputs={})
    with LogRecorder(folder.log_path, [Column("phase", "", "phase")]) as recorder:
        for k in range(100):
            recorder.write(k, k * PERIOD, (0.0 if k < 50 else 2.0,))
    folder.finish(RunStatus.ABORTED, 130)
    run = FollowedRun(folder.path)
    run.advance()
    assert run.motion_began() is None
    run.close()


EVENT = '{"t": 1.0, "kind": "mark", "message": "said"'


@pytest.mark.parametrize(
    "line",
    [
        EVENT + ', "data": {"a": NaN, "b": -Infinity, "c": [1e999], "d": {"e": NaN}}}',
        EVENT + ', "data": {"a": "' + "x" * 3_000_000 + '"}}',
        "x" * 3_000_000,
        '{"t": NaN, "kind": "mark", "message": "said"}',
    ],
)
def test_no_event_of_a_damaged_folder_keeps_pages_from_the_next_ones(tmp_path, line):
    folder = RunFolder.create(tmp_path, "damaged", "sim", inputs={})
    events = folder.path / "events.jsonl"
    events.write_text(f'{line}\n{EVENT[:-5]}after"}}\n')
    run = FollowedRun(folder.path)
    for _ in range(5):
        run.look_again()
    json.dumps(run.events, allow_nan=False).encode()  # as a page is sent them
    assert run.events[-1]["message"] == "after"
    run.close()


def test_a_folder_that_is_deleted_while_it_is_watched_is_shown_as_it_was(tmp_path):
    folder = RunFolder.create(tmp_path, "deleted", "sim", inputs={})
    folder.record_event(1.0, "mark", "said")
    run = FollowedRun(folder.path)
    run.look_again()
    shutil.rmtree(folder.path)
    run.look_again()
    run.advance()
    assert "deleted" in run.trouble
    assert [event["message"] for event in run.events] == ["said"]
    assert not run.is_live
    with pytest.raises(CannotStop, match="nobody can tell whether"):
        request_stop(folder.path, at_once=False)
    run.close()
