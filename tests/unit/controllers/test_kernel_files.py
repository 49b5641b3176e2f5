"""Kernels in files: what is damaged is compiled anew, and never run."""

import errno
import importlib.util
import os
import random
import shutil
import time
import warnings

import numpy as np
import pytest
from numba import NumbaWarning
from numba.core import caching, config

from controllers.kernel_files import kept_kernel

SOURCE = """
WEIGHT = {weight}
def law(values, gain):
    total = 0.0
    for value in values:
        total += WEIGHT * value / (gain + value * value)
    return total
def other(values, gain):
    return gain * values[0]
"""


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Return what writes a module of laws and imports it; the same file may be written again."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")  # beside it, wherever who runs the tests keeps theirs
    config.reload_config()

    def written(weight=3.0):
        path = tmp_path / "laws.py"
        path.write_text(SOURCE.format(weight=weight))
        specification = importlib.util.spec_from_file_location("laws", path)
        module = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(module)
        return module

    return written


def called(law, chance, gain=0.7):
    """Compile a law as a new process does, hold it against Python; return whether a file served."""
    kernel, values = kept_kernel(law), chance.uniform(-9.0, 9.0, 5)
    assert kernel(values, gain) == pytest.approx(law(values, gain), rel=1e-12)
    return sum(kernel.stats.cache_hits.values()) == 1


def files_of(tmp_path, law, ending):
    return sorted((tmp_path / "__pycache__").glob(f"laws.{law}-*{ending}"))


def flip(path, content, draw):
    at, changed = draw.randrange(len(content)), bytearray(content)
    changed[at] ^= 1 << draw.randrange(8)
    path.write_bytes(changed)


def make(place):
    def instead(path, content, draw):
        path.unlink()
        place(path)

    return instead


DAMAGES = {
    "flipped": flip,
    "cut": lambda path, content, draw: path.write_bytes(content[: draw.randrange(len(content))]),
    "empty": lambda path, content, draw: path.write_bytes(b""),
    "zero from some place on": lambda path, content, draw: path.write_bytes(
        content[: (at := draw.randrange(len(content)))].ljust(len(content) - (at == 0), b"\0")
    ),
    "noise": lambda path, content, draw: path.write_bytes(draw.randbytes(len(content))),
    "longer": lambda path, content, draw: path.write_bytes(content + draw.randbytes(9)),
    "twice": lambda path, content, draw: path.write_bytes(content * 2),
    "as numba itself writes it": lambda path, content, draw: path.write_bytes(content[:-32]),
    "folder": make(lambda path: path.mkdir()),
    "pipe": make(os.mkfifo),
    "link to nowhere": make(lambda path: path.symlink_to("/nowhere/x")),
    "link to itself": make(lambda path: path.symlink_to(path)),
    "gone": lambda path, content, draw: path.unlink(),
    "not to be read": lambda path, content, draw: path.chmod(0),
}


@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
@pytest.mark.parametrize("damage", DAMAGES)
def test_what_is_damaged_is_compiled_anew_and_replaced(tmp_path, write, damage, ending):
    law, draw, chance = write().law, random.Random(damage + ending), np.random.default_rng(7)
    assert not called(law, chance)
    assert called(law, chance)
    (path,) = files_of(tmp_path, "law", ending)
    DAMAGES[damage](path, path.read_bytes(), draw)
    # Root reads what nobody may.
    assert called(law, chance) == (damage == "not to be read" and os.getuid() == 0)
    assert called(law, chance)


@pytest.mark.parametrize("seed", range(12))
def test_no_flipped_bit_is_run(tmp_path, write, seed):
    law, draw, chance = write().law, random.Random(seed), np.random.default_rng(seed)
    called(law, chance)
    (path,) = files_of(tmp_path, "law", draw.choice([".nbi", ".nbc"]))
    flip(path, path.read_bytes(), draw)
    assert not called(law, chance)


def test_a_folder_with_something_in_it_stays(tmp_path, write):
    law, chance = write().law, np.random.default_rng(1)
    called(law, chance)
    (path,) = files_of(tmp_path, "law", ".nbc")
    path.unlink()
    (path / "theirs").mkdir(parents=True)
    assert not called(law, chance) and not called(law, chance)
    assert (path / "theirs").is_dir()


@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
def test_the_file_of_another_kernel_is_not_taken(tmp_path, write, ending):
    laws, chance = write(), np.random.default_rng(2)
    called(laws.law, chance)
    called(laws.other, chance)
    shutil.copy(files_of(tmp_path, "other", ending)[0], files_of(tmp_path, "law", ending)[0])
    assert not called(laws.law, chance)


def test_two_that_began_together_may_have_named_their_files_alike(tmp_path, write):
    """Each finds no index, takes the first name, and one writes last of all."""
    law, chance = write().law, np.random.default_rng(3)
    called(law, chance, gain=0.7)
    (code,) = files_of(tmp_path, "law", ".nbc")
    of_the_first = code.read_bytes()
    files_of(tmp_path, "law", ".nbi")[0].unlink()
    called(law, chance, gain=2)
    assert files_of(tmp_path, "law", ".nbc") == [code]
    code.write_bytes(of_the_first)
    assert not called(law, chance, gain=2)
    assert called(law, chance, gain=2)


def test_a_death_between_both_files_leaves_no_older_kernel(tmp_path, write, monkeypatch):
    """The constant is in the machine code, and in nothing that numba's key is made of."""
    chance = np.random.default_rng(4)
    called(write(weight=3.0).law, chance)
    with monkeypatch.context() as killed:
        killed.setattr(caching.IndexDataCacheFile, "_save_data", lambda *_: None)
        called(write(weight=40.0).law, chance)
    assert not called(write(weight=40.0).law, chance)


@pytest.mark.parametrize("reason", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO])
@pytest.mark.parametrize("after", range(3))
def test_a_disk_without_room_ends_nothing(tmp_path, write, monkeypatch, reason, after):
    """At the first file, the second, or none."""
    law, chance, moved = write().law, np.random.default_rng(5), []
    replace = os.replace

    def full(*paths):
        moved.append(paths)
        if len(moved) > after:
            raise OSError(reason, os.strerror(reason))
        replace(*paths)

    with monkeypatch.context() as patched:
        patched.setattr(caching.os, "replace", full)
        assert not called(law, chance)
        assert called(law, chance) == (after == 2)
    assert called(law, chance) == (after == 2)
    assert called(law, chance)
    assert not list((tmp_path / "__pycache__").glob("*.tmp.*"))


def test_what_a_killed_process_had_begun_is_taken_away_after_an_hour(tmp_path, write):
    laws, chance = write(), np.random.default_rng(8)
    called(laws.law, chance)
    (path,) = files_of(tmp_path, "law", ".nbc")
    old, new, theirs = (path.with_name(path.name + f".tmp.{n}") for n in ("0ld", "new", "theirs"))
    for begun in (old, new):
        begun.touch()
    theirs.mkdir()
    for begun, age in ((old, 4000.0), (new, 3000.0), (theirs, 4000.0), (path, 4000.0)):
        os.utime(begun, (time.time() - age, time.time() - age))
    called(laws.other, chance)
    assert [one.exists() for one in (old, new, theirs, path)] == [False, True, True, True]


def test_nobody_is_warned_of_a_kernel_that_cannot_be_kept(write, monkeypatch, recwarn):
    """As with NUMBA_OPT=0, by which the machine code of a few has addresses of this process."""

    def refuses(*_):
        warnings.warn("Cannot cache compiled function", NumbaWarning, stacklevel=2)
        return False

    monkeypatch.setattr(caching.CompileResultCacheImpl, "check_cachable", refuses)
    law, chance = write().law, np.random.default_rng(9)
    assert not called(law, chance) and not called(law, chance)
    assert not [one for one in recwarn if issubclass(one.category, NumbaWarning)]


def test_what_was_written_with_another_library_is_compiled_anew(write, monkeypatch):
    law, chance = write().law, np.random.default_rng(6)
    called(law, chance)

    def fails(_):
        raise ModuleNotFoundError("No module named 'numpy._core'", name="numpy._core")

    with monkeypatch.context() as patched:
        patched.setattr(caching.pickle, "loads", fails)
        assert not called(law, chance)
    assert called(law, chance)


def test_who_waits_is_told_of_what_is_compiled_and_of_nothing_else(write, caplog):
    caplog.set_level("INFO", "controllers.kernel_files")
    module, chance = write(), np.random.default_rng(5)
    assert not called(module.law, chance)
    assert [record.getMessage() for record in caplog.records] == [
        "compiling kernels for this machine, once"
    ]
    assert called(module.law, chance)
    assert len(caplog.records) == 1


def test_who_waits_is_told_that_nothing_is_kept(write, caplog, monkeypatch):
    caplog.set_level("INFO", "controllers.kernel_files")
    module = write()
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])
    assert not called(module.law, np.random.default_rng(6))
    (record,) = caplog.records
    assert record.getMessage() == "compiling kernels, which no folder here can keep"
