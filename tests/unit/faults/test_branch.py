"""A home that moves: what was recorded goes along, and what comes next goes its own way."""

import os

import pytest

from rig.faults.branch import make_home


@pytest.fixture
def home(tmp_path):
    home = make_home(tmp_path / "first")
    yield home
    os.close(home.descriptor)


def test_open_files_go_on_in_the_copy(home, tmp_path):
    (home.path / "run").mkdir()
    appended = os.open(home.path / "run" / "events", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    with (home.path / "run" / "log").open("wb", buffering=0) as log:
        log.write(b"before ")
        os.write(appended, b"before ")
        home.move(tmp_path / "second")
        log.write(b"after")
        os.write(appended, b"after")
        (home.path / "run" / "new").write_text("new")
    os.close(appended)
    for name in ("log", "events"):
        assert (tmp_path / "first" / "run" / name).read_bytes() == b"before "
        assert (tmp_path / "second" / "run" / name).read_bytes() == b"before after"
    assert not (tmp_path / "first" / "run" / "new").exists()
    assert (tmp_path / "second" / "run" / "new").exists()


def test_files_elsewhere_stay(home, tmp_path):
    with (tmp_path / "first-not").open("wb", buffering=0) as elsewhere:
        home.move(tmp_path / "second")
        elsewhere.write(b"here")
    assert (tmp_path / "first-not").read_bytes() == b"here"
