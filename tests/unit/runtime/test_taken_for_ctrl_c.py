"""What ends a program is taken for Ctrl-C, but for what was ignored before it began."""

import os
import signal
import time

import pytest

from rig.runtime.ending_signals import all_as_ctrl_c
from rig.runtime.stop import ENDING


@pytest.fixture
def handlers():
    before = {number: signal.getsignal(number) for number in ENDING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", ENDING)
def test_each_is_ctrl_c_while_it_lasts(number, handlers):
    signal.signal(number, signal.SIG_DFL)
    with pytest.raises(KeyboardInterrupt), all_as_ctrl_c():
        os.kill(os.getpid(), number)
        time.sleep(5.0)
    assert signal.getsignal(number) is signal.SIG_DFL


@pytest.mark.parametrize("number", ENDING)
def test_what_is_ignored_goes_on_being_ignored(number, handlers):
    """`nohup rig export` outlives its terminal."""
    signal.signal(number, signal.SIG_IGN)
    with all_as_ctrl_c():
        os.kill(os.getpid(), number)
        time.sleep(0.01)
    assert signal.getsignal(number) is signal.SIG_IGN
