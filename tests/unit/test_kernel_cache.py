"""Kernels are kept where they can be, and never where somebody else could put one."""

import os

import pytest

from rig import kernel_cache


@pytest.fixture
def nowhere(monkeypatch, tmp_path):
    """A program that can write neither beside itself nor at home; return the temporary folder."""
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda path: False)
    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr(kernel_cache.os, "environ", {"TMPDIR": str(tmp_path)})
    return tmp_path / f"rig-kernels-{os.getuid()}"


def chosen():
    kernel_cache.keep_kernels()
    return os.environ.get("NUMBA_CACHE_DIR")


def test_a_folder_of_ones_own_is_made(nowhere):
    assert chosen() == str(nowhere)
    assert nowhere.stat().st_mode & 0o777 == 0o700


def test_what_the_user_says_stays(nowhere):
    os.environ["NUMBA_CACHE_DIR"] = "/elsewhere"
    assert chosen() == "/elsewhere"
    assert not nowhere.exists()


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o701, 0o720])
def test_a_folder_that_others_may_enter_is_not_used(nowhere, mode):
    nowhere.mkdir()
    nowhere.chmod(mode)
    assert chosen() is None


def test_neither_is_a_link_nor_what_belongs_to_another(nowhere, tmp_path, monkeypatch):
    (tmp_path / "theirs").mkdir(mode=0o700)
    nowhere.symlink_to(tmp_path / "theirs")
    assert chosen() is None
    nowhere.unlink()
    nowhere.mkdir(mode=0o700)
    other = os.getuid() + 1
    nowhere.rename(tmp_path / f"rig-kernels-{other}")
    monkeypatch.setattr(kernel_cache.os, "getuid", lambda: other)
    assert chosen() is None


@pytest.mark.parametrize("place", ["_beside", "_at_home"])
def test_numba_is_left_alone_where_it_can_write(monkeypatch, tmp_path, place):
    for name in ("_beside", "_at_home"):
        monkeypatch.setattr(kernel_cache, name, lambda: tmp_path / "file" / "below")
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(kernel_cache, place, lambda: tmp_path / "new" / "below")
    monkeypatch.setattr(kernel_cache.os, "environ", {})
    assert chosen() is None


@pytest.mark.parametrize("said", ["", ".", "x", "..", "/nowhere", "/dev/null"])
def test_python_making_do_with_the_working_folder_is_not_meant(tmp_path, monkeypatch, said):
    """Where no folder for temporary files can be written."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernel_cache, "_is_writable", lambda path: False)
    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr(kernel_cache.os, "environ", {"TMPDIR": said})
    assert chosen() is None
    assert not list(tmp_path.iterdir())


def test_a_working_folder_that_is_named_is_meant(nowhere, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.environ["TMPDIR"] = f"{tmp_path}/"
    assert chosen() == str(nowhere)


def test_without_any_folder_for_temporary_files_nothing_is_kept(nowhere, monkeypatch):
    def fails():
        raise FileNotFoundError("No usable temporary directory found")

    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", fails)
    assert chosen() is None
