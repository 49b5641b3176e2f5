"""Descriptions of files are read once, and whatever stands in their store changes nothing."""

import json
import os

import pytest

from rig.cli import descriptions
from rig.cli.descriptions import descriptions_of
from rig.config import yaml_loader

TEXTS = {"one": "of one", "two": "of\n  two"}


@pytest.fixture
def files(tmp_path):
    made = [tmp_path / f"{name}.yaml" for name in TEXTS]
    for path, text in zip(made, TEXTS.values(), strict=True):
        write(path, text)
    return made


def write(path, text):
    path.write_text(f"name: x\ndescription: {text}\n")
    os.utime(path, ns=(0, path.stat().st_mtime_ns - 10**10))  # an hour's work, not this moment's


@pytest.fixture(autouse=True)
def store(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "rig" / "descriptions.json"


@pytest.fixture
def was_read(monkeypatch):
    """The names of the files that were read."""
    read, found = yaml_loader.read_plain, []

    def noted(path):
        found.append(path.stem)
        return read(path)

    monkeypatch.setattr(yaml_loader, "read_plain", noted)
    return found


def test_a_file_is_read_once(files, was_read):
    said = descriptions_of(files)
    assert list(said.values()) == ["of one", "of two"]
    assert descriptions_of(files) == said
    assert was_read == ["one", "two"]


def test_one_that_was_changed_is_read_anew(files, was_read):
    descriptions_of(files)
    write(files[0], "of 0ne")  # of the same length
    assert list(descriptions_of(files).values()) == ["of 0ne", "of two"]
    assert was_read == ["one", "two", "one"]


def test_one_that_was_just_written_may_be_written_again(files, was_read):
    files[0].touch()
    descriptions_of(files)
    descriptions_of(files)
    assert was_read == ["one", "two", "one"]


def test_one_that_cannot_be_read_is_tried_again(files):
    content = files[0].read_bytes()
    status = files[0].stat()
    files[0].write_text("name: [")
    os.utime(files[0], ns=(0, status.st_mtime_ns))
    assert descriptions_of(files)[files[0]].startswith("cannot be read; see `rig check ")
    files[0].write_bytes(content)
    assert descriptions_of(files)[files[0]] == "of one"


@pytest.mark.parametrize(
    "damage",
    [b"", b"\xff", b"[1]", b'{"/x": 3}', b'{"/x": {"seen": 3, "text": "x"}}', b"[" * 99999],
)
def test_a_damaged_store_is_none(files, store, damage):
    descriptions_of(files)
    store.write_bytes(damage)
    assert list(descriptions_of(files).values()) == ["of one", "of two"]
    assert len(json.loads(store.read_bytes())) == 2


@pytest.mark.parametrize(
    "place", [os.mkfifo, lambda path: path.symlink_to("/dev/zero"), lambda path: path.mkdir()]
)
def test_what_is_no_file_is_neither_waited_for_nor_read(files, store, place):
    store.parent.mkdir(parents=True)
    place(store)
    assert list(descriptions_of(files).values()) == ["of one", "of two"]


def test_one_that_is_longer_than_any_of_ours_is_none(files, store, was_read, monkeypatch):
    descriptions_of(files)
    monkeypatch.setattr(descriptions, "_LONGEST", store.stat().st_size - 1)
    descriptions_of(files)
    assert was_read == ["one", "two"] * 2


def test_where_nothing_can_be_kept_nothing_is(files, tmp_path, store):
    store.parent.parent.write_text("in the way")
    assert list(descriptions_of(files).values()) == ["of one", "of two"]


def test_no_more_are_kept_than_so_many(files, store, monkeypatch):
    monkeypatch.setattr(descriptions, "_MOST", 1)
    descriptions_of(files)
    assert len(json.loads(store.read_bytes())) == 1
    descriptions_of(files[1:])
    assert [*json.loads(store.read_bytes())] == [str(files[1])]
