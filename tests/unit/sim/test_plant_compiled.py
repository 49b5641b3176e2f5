"""Compilation of kernels: what the cache watches, and life without one."""

from drivers.sim.plants import compiled
from drivers.sim.plants.compiled import cached_kernel


def test_a_kernel_compiles_where_nothing_can_be_cached():
    """Code without a file has no place for a cache, like a package in a read-only folder."""
    space = {}
    exec("def build(sources):\n def kernel(x):\n  return x + sources\n return kernel", space)
    kernel = cached_kernel(space["build"])
    assert kernel(1) == 1 + compiled._digest_of_sources()


def test_the_digest_changes_with_any_source(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "compiled.py"))
    (tmp_path / "friction.py").write_text("coulomb = 3.0")
    before = compiled._digest_of_sources()
    (tmp_path / "friction.py").write_text("coulomb = 3.1")
    assert compiled._digest_of_sources() != before
