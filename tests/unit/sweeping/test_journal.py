"""What is finished of a sweep stays finished, whatever becomes of the process that kept it."""

import os

import pytest

from rig.hal import ConfigurationError
from rig.sweeping.errors import SweepStopped
from rig.sweeping.journal import JOURNAL, Journal


def finding(number):
    return {"point": f"{number:032x}", "status": "ok", "reason": "", "metrics": []}


def test_what_was_kept_is_there_again(tmp_path):
    journal = Journal(tmp_path)
    for number in range(5):
        journal.add(finding(number))
    journal.close()
    again = Journal(tmp_path)
    assert len(again) == 5
    assert again[f"{3:032x}"] == finding(3)
    assert f"{5:032x}" not in again
    again.close()


def test_a_torn_line_is_cut_off_wherever_it_was_torn(tmp_path):
    journal = Journal(tmp_path)
    journal.add(finding(1))
    journal.add(finding(2))
    journal.close()
    whole = (tmp_path / JOURNAL).read_bytes()
    first = whole.index(b"\n") + 1
    for length in range(first, len(whole)):
        (tmp_path / JOURNAL).write_bytes(whole[:length])
        torn = Journal(tmp_path)
        assert len(torn) == 1
        torn.add(finding(3))
        torn.close()
        assert (tmp_path / JOURNAL).read_bytes().count(b"\n") == 2


def test_one_process_at_a_time(tmp_path):
    journal = Journal(tmp_path)
    with pytest.raises(SweepStopped, match=f"another sweep works here .process {os.getpid()}"):
        Journal(tmp_path)
    journal.close()
    Journal(tmp_path).close()


def test_a_journal_of_something_else_is_refused(tmp_path):
    (tmp_path / JOURNAL).write_text('{"x": 1}\n')
    with pytest.raises(ConfigurationError, match="no journal of a sweep"):
        Journal(tmp_path)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigurationError, match="cannot keep a sweep"):
        Journal(tmp_path / "file" / "sweep")


def test_a_full_disk_loses_nothing_that_was_kept(tmp_path):
    import resource

    journal = Journal(tmp_path)
    journal.add(finding(1))
    size = (tmp_path / JOURNAL).stat().st_size
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    import signal

    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 40, before[1]))
    try:
        with pytest.raises(SweepStopped, match="what is finished is kept"):
            journal.add(finding(2))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert journal[f"{1:032x}"] == finding(1)
    journal.add(finding(2))
    journal.close()
    assert (tmp_path / JOURNAL).read_bytes().count(b"\n") == 2
