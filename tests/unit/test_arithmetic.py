"""Kernels of matrices are the same everywhere, unless somebody asked for others."""

import os
import subprocess
import sys

import pytest

from rig import arithmetic

FLAGS = "processor : 0\nmodel name : drawn\nflags : fpu sse2 {}\nbugs : avx2\n"


@pytest.fixture
def said(tmp_path, monkeypatch):
    """Return what is set on a processor with these flags."""
    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    monkeypatch.setattr(arithmetic, "PROCESSORS", tmp_path / "cpuinfo")
    monkeypatch.setattr(arithmetic.platform, "machine", lambda: "x86_64")

    def on(flags):
        arithmetic.PROCESSORS.write_text(FLAGS.format(flags))
        arithmetic.round_alike()
        return os.environ.get("OPENBLAS_CORETYPE")

    return on


@pytest.mark.parametrize("flags", ["avx2 fma", "fma f16c avx2 avx512f amx_tile"])
def test_a_processor_that_can_run_them_does(said, flags):
    assert said(flags) == arithmetic.KERNELS


@pytest.mark.parametrize("flags", ["", "sse4_2 avx", "avx2", "fma avx512f", "avx2x fma4"])
def test_a_processor_that_cannot_picks_its_own(said, flags):
    assert said(flags) is None


def test_neither_does_one_of_another_kind_or_of_which_nothing_is_known(said, monkeypatch):
    assert said("") is None
    arithmetic.PROCESSORS.unlink()
    arithmetic.round_alike()
    assert "OPENBLAS_CORETYPE" not in os.environ
    monkeypatch.setattr(arithmetic.platform, "machine", lambda: "aarch64")
    assert said("avx2 fma") is None


def test_what_somebody_asked_for_stays(said, monkeypatch):
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Nehalem")
    assert said("avx2 fma") == "Nehalem"


def test_it_is_set_before_numpy_is_imported():
    asked = "import rig, sys; assert 'numpy' not in sys.modules"
    subprocess.run([sys.executable, "-c", asked], check=True)
