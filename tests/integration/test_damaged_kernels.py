"""A run whose kept kernels are damaged, or have no room, is the run that it was."""

import os
import random
import shutil
import subprocess
import sys

import pytest
from small_disk import may_mount, on_a_small_disk

RUN = [sys.executable, "-m", "rig", "run", "cylinder-step", "--on", "sim", "--no-report", "--out"]


def metrics_of(out):
    (path,) = out.glob("*/metrics.json")
    return path.read_bytes()


def run(kernels, out, words=RUN):
    done = subprocess.run(
        [*words, str(out)], env={**os.environ, "NUMBA_CACHE_DIR": str(kernels)}, timeout=300,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return metrics_of(out)


@pytest.fixture(scope="module")
def undamaged(tmp_path_factory):
    """Return a folder of kernels, and the metrics of a run that wrote it."""
    folder = tmp_path_factory.mktemp("undamaged")
    return folder / "kernels", run(folder / "kernels", folder / "runs")


def empty(path, draw):
    path.write_bytes(b"")


def flip(path, draw):
    content = bytearray(path.read_bytes())
    content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    path.write_bytes(content)


def cut(path, draw):
    path.write_bytes(path.read_bytes()[: draw.randrange(path.stat().st_size)])


def pipe(path, draw):
    path.unlink()
    os.mkfifo(path)


def folder(path, draw):
    path.unlink()
    path.mkdir()


def alike(path, draw):
    """Every file of a kind is the same one."""
    kept = sorted(path.parents[1].rglob(f"*{path.suffix}"))
    if path != kept[0]:
        shutil.copy(kept[0], path)


@pytest.mark.parametrize(
    ("harm", "ending"),
    [(empty, ".nbc"), (empty, ".nbi"), (flip, ".nbc"), (alike, ".nbc"), (pipe, ".nb?")],
)
def test_damaged_kernels_change_nothing(tmp_path, undamaged, harm, ending):
    check(tmp_path, undamaged, harm, ending)


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
@pytest.mark.parametrize("harm", [flip, cut, folder, alike, pipe])
@pytest.mark.parametrize("seed", range(3))
def test_kernels_damaged_in_many_ways_change_nothing(tmp_path, undamaged, harm, ending, seed):
    check(tmp_path, undamaged, harm, ending, seed)


def check(tmp_path, undamaged, harm, ending, seed=0):
    kernels, metrics = tmp_path / "kernels", undamaged[1]
    shutil.copytree(undamaged[0], kernels)
    written, draw = sorted(kernels.rglob(f"*{ending}")), random.Random(seed)
    assert written
    for path in written:
        harm(path, draw)
    left = {path: path.stat().st_mtime_ns for path in written}
    assert run(kernels, tmp_path / "runs") == metrics
    changed = [path for path in written if path.stat().st_mtime_ns != left[path]]
    # `alike` leaves the first as it was.
    assert len(changed) == len(written) - (harm is alike)
    assert all(path.is_file() for path in written)


@pytest.mark.parametrize("size", ["4k", "40k", "160k"])
def test_without_room_for_kernels_the_run_goes_on(tmp_path, undamaged, size):
    disk, left = tmp_path / "disk", tmp_path / "left"
    disk.mkdir()
    left.mkdir()
    if not may_mount(disk):
        pytest.skip("nothing may be mounted here")
    there = ["env", f"NUMBA_CACHE_DIR={disk}", *RUN, str(tmp_path / "runs")]
    done = on_a_small_disk(size, disk, left, there)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert metrics_of(tmp_path / "runs") == undamaged[1]
    assert subprocess.run(
        ["find", left, "-name", "*.tmp.*"], capture_output=True, check=True
    ).stdout == b""  # fmt: skip
