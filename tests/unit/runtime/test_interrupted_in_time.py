"""An interrupt comes where nothing swallows it or makes another error of it, and comes once."""

import signal
import subprocess
import sys

import pytest

BEGIN = """
import importlib.util, os, signal, sys, time
from contextlib import suppress
from pathlib import Path
from rig.runtime import ending_signals
from rig.runtime.ending_signals import all_as_ctrl_c
from rig.runtime.stop import StopRequests
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job may ignore it
def tell(number=signal.SIGTERM):
    os.kill(os.getpid(), number)
def wait():
    until = time.monotonic() + 20.0
    while time.monotonic() < until:
        pass
Path("told.py").write_text("import __main__; __main__.within(); done = True")
sys.path.insert(0, "")
"""


def said_by(program, folder):
    words = [sys.executable, "-c", BEGIN + program]
    ended = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert not ended.stderr
    return ended.stdout.split()


def test_an_import_is_not_torn(tmp_path):
    program = """
def within():
    tell()
    time.sleep(0.1)
try:
    with all_as_ctrl_c():
        import told
        wait()
except KeyboardInterrupt:
    print(told.done)
"""
    assert said_by(program, tmp_path) == ["True"]


def test_a_source_is_compiled_although_somebody_interrupts(tmp_path):
    """Python's compiler imports the names of characters, and takes any error there for its own."""
    (tmp_path / "named.py").write_text('BULLET = "\\N{BULLET}"\n')
    program = """
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "unicodedata":
            tell(signal.SIGINT)
            time.sleep(0.01)
assert "unicodedata" not in sys.modules
sys.meta_path.insert(0, Finder())
try:
    with all_as_ctrl_c():
        import named
        wait()
except KeyboardInterrupt:
    print(named.BULLET)
"""
    assert said_by(program, tmp_path) == ["\N{BULLET}"]


@pytest.mark.parametrize("way", ["second", "patience"])
def test_an_import_that_takes_long_is_torn(way, tmp_path):
    program = f"""
ending_signals._PATIENCE = 0.1
def within():
    tell()
    if {way == "second"}:
        tell()
    else:
        wait()
try:
    with all_as_ctrl_c():
        import told
        print("went on")
except KeyboardInterrupt:
    print("told" in sys.modules)
"""
    assert said_by(program, tmp_path) == ["False"]


@pytest.mark.parametrize("ctrl_c", ["default_int_handler", "SIG_IGN"])
def test_what_a_destructor_swallows_comes_again(ctrl_c, tmp_path):
    program = f"signal.signal(signal.SIGINT, signal.{ctrl_c})"
    program += """
class Kept:
    def __del__(self):
        tell()
        time.sleep(0.01)
try:
    with all_as_ctrl_c():
        Kept()
        wait()
except KeyboardInterrupt:
    print("interrupted")
"""
    assert said_by(program, tmp_path) == ["interrupted"]


def test_a_run_that_begins_meanwhile_is_told_once(tmp_path):
    program = """
stop = StopRequests()
def within():
    tell()
    time.sleep(0.001)
    stop.__enter__()
    stop.shield()
with all_as_ctrl_c():
    import told
    time.sleep(0.1)
    stop.__exit__()
    time.sleep(0.1)
print(stop.count)
"""
    assert said_by(program, tmp_path) == ["1"]


def test_a_copy_has_its_own_way_to_end(tmp_path):
    program = """
with all_as_ctrl_c():
    if os.fork() == 0:
        try:
            tell()
            wait()
        finally:
            print("a copy unwinds")
    print(os.waitstatus_to_exitcode(os.wait()[1]))
"""
    assert said_by(program, tmp_path) == [f"{-signal.SIGTERM}"]
