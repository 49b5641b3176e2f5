"""The gate sees the least change of any law, and whatever leaks into one from outside."""

import dataclasses
import math
import os
import random
import subprocess
import sys
import time
from functools import cache
from itertools import count
from pathlib import Path

import pytest
from replay.arithmetic import is_as_recorded
from replay.corpus_files import CORPUS, SUFFIX, unpack
from replay.recording import record
from replay.recordings import RECORDINGS

from controllers.cylinder.pid import Pid
from rig.experiment.plan import make_plan
from rig.replaying.recorded import Logged, open_recorded
from rig.replaying.verify import _compare, same_bits, verify
from rig.runtime.log import LogError, LogFile, read_log

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not is_as_recorded(), reason="the corpus was recorded where numbers are rounded otherwise"
    ),
]

LAWS = {
    **{f"cylinder {law}": f"cylinder-{law}-step"
       for law in ("pid", "pid-friction", "cascade", "super-twisting")},
    **{f"joint {law}": f"joint-{law}" for law in ("pid", "pid-friction", "cascade",
                                                  "super-twisting")},
    **{f"arm {law}": f"arm-{law}-turnback"
       for law in ("inverse", "servo-halt", "esc-paper", "esc")},
    "arm dls": "arm-dls-circle", "arm look-ahead": "arm-look-ahead-near-miss",
    **{f"legs {law}": f"legs-{law}-squat"
       for law in ("inverse", "sc", "min-jerk", "clamp", "dls")},
    "legs sc-trapezoid": "legs-walk-trapezoid", "legs sc-smooth": "legs-walk",
}  # fmt: skip

BITS = {"legs dls": 1 << 12}
"""Its λ² of 0.0025 is added to numbers near 1, where the last bits of λ are rounded away."""


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    home = tmp_path_factory.mktemp("corpus")

    @cache  # a plan may be followed again: a law that is reset has forgotten what it did
    def opened(name):
        return open_recorded(unpack(CORPUS / f"{name}{SUFFIX}", home / name))

    return opened


def nudged(value, which=None):
    """Return settings or a command with one of its numbers, or each, moved by its last bit."""
    number = count()

    def walk(part):
        if isinstance(part, float):
            return math.nextafter(part, math.inf) if which in (None, next(number)) else part
        if isinstance(part, tuple):
            made = [walk(item) for item in part]
            return type(part)(*made) if hasattr(part, "_fields") else tuple(made)
        if dataclasses.is_dataclass(part):
            fields = {f.name: walk(getattr(part, f.name)) for f in dataclasses.fields(part)}
            return dataclasses.replace(part, **fields)
        return part

    return walk(value)


def numbers_in(value):
    if isinstance(value, float):
        return 1
    if dataclasses.is_dataclass(value):
        value = tuple(getattr(value, field.name) for field in dataclasses.fields(value))
    return sum(map(numbers_in, value)) if isinstance(value, tuple) else 0


@pytest.mark.sampled(6)
@pytest.mark.parametrize("law", LAWS)
def test_one_bit_of_one_command_is_seen_in_its_cycle_and_column(law, unpacked, monkeypatch):
    run, chance = unpacked(LAWS[law]), random.Random(law)
    controller = run.plan.controller
    plain, calls, at = controller.update, count(), chance.randrange(60)
    where = []

    def update(state, reference):
        command = plain(state, reference)
        if next(calls) != at:
            return command
        where.append((state.t, chance.randrange(numbers_in(command))))
        return nudged(command, where[0][1])

    monkeypatch.setattr(controller, "update", update)
    difference = verify(run).difference
    (clock, number), commands = where[0], run.log.names("command.")
    assert difference is not None
    assert run.log.column("clock")[difference.row] == clock
    assert difference.column == commands[number]
    assert difference.now == math.nextafter(difference.logged, math.inf)


@pytest.mark.sampled(6)
@pytest.mark.parametrize("law", LAWS)
def test_the_last_bit_of_a_laws_numbers_is_seen(law, unpacked):
    run = unpacked(LAWS[law])
    name = run.plan.experiment.controller
    profile = run.plan.profile
    settings = profile.controllers[name]
    if not numbers_in(settings):
        pytest.skip("the law has no number of its own")
    for _ in range(BITS.get(law, 1)):
        settings = nudged(settings)
    others = {**profile.controllers, name: settings}
    plan = make_plan(run.plan.experiment, dataclasses.replace(profile, controllers=others))
    assert not verify(run._replace(plan=plan)).same


# Leaks ------------------------------------------------------------------------------------------


def leaking(leak):
    """Return an update of the PID law into which something leaks."""
    plain = Pid.update

    def update(self, state, reference, load=0.0):
        command = plain(self, state, reference, load)
        return command._replace(agonist=command.agonist + leak())

    return update


_KEPT = []


def address():
    """Return something of where a new object is; those before stay, or it would be there again."""
    _KEPT.append(object())
    return id(_KEPT[-1]) % 7


@pytest.mark.parametrize(
    "leak",
    [lambda: 1e-9 * time.perf_counter(), lambda: 1e-9 * random.random(), address],
    ids=["clock", "random", "address"],
)
def test_what_leaks_into_a_law_is_seen(leak, tmp_path, monkeypatch):
    monkeypatch.setattr(Pid, "update", leaking(leak))
    folder = record(RECORDINGS["cylinder-pid-step"], tmp_path)
    assert not verify(open_recorded(folder)).same


SET_ORDER = """
import sys
from pathlib import Path
sys.path[:0] = [{tests!r}]
from controllers.cylinder.pid import Pid
from replay.recording import record
from replay.recordings import RECORDINGS
from rig.replaying.recorded import open_recorded
from rig.replaying.verify import verify

plain = Pid.update
parts = {{"first": 0.1, "second": 0.2, "third": 0.3, "fourth": 1e15, "fifth": -1e15}}

def update(self, state, reference, load=0.0):
    command = plain(self, state, reference, load)
    return command._replace(agonist=command.agonist + sum(parts[name] for name in set(parts)))

Pid.update = update
if sys.argv[1] == "record":
    print(record(RECORDINGS["cylinder-pid-step"], Path(sys.argv[2])))
else:
    order = sum(parts[name] for name in set(parts))
    print(order, verify(open_recorded(Path(sys.argv[2]))).same)
"""


def test_the_order_of_a_set_is_seen(tmp_path):
    script = tmp_path / "leak.py"
    script.write_text(SET_ORDER.format(tests=str(Path(__file__).parents[1])))

    def run(seed, *words):
        return subprocess.run(
            [sys.executable, script, *words], env={**os.environ, "PYTHONHASHSEED": str(seed)},
            capture_output=True, text=True, check=True,
        ).stdout.split()  # fmt: skip

    folder = run(1, "record", str(tmp_path))[-1]
    here, same = run(1, "verify", folder)
    assert same == "True"  # the same order in both: nothing to see
    others = [run(seed, "verify", folder) for seed in (2, 3, 4)]
    assert {order for order, _ in others} != {here}
    assert all((same == "True") == (order == here) for order, same in others)


# Bits and rows ----------------------------------------------------------------------------------


def test_numbers_are_compared_by_their_bits():
    nan = float("nan")
    assert same_bits(nan, nan) and same_bits(-0.0, -0.0)
    assert not same_bits(0.0, -0.0)
    assert not same_bits(nan, -nan)
    logged = Logged(7, 0.7, {"command.x": nan, "reading.y": 1.0})
    columns = [("reading.y", "m"), ("command.x", "Pa")]
    assert _compare(0, logged, columns, (1.0, nan)) is None
    found = _compare(0, logged, columns, (2.0, 1.0))
    assert (found.column, found.cycle, found.others) == ("command.x", 7, ("reading.y",))


def test_a_row_that_is_missing_is_a_failure(unpacked, tmp_path):
    """Wherever it is taken out of the file, and however: neither a gap nor an end too early."""
    source = unpack(CORPUS / f"cylinder-pid-step{SUFFIX}", tmp_path / "run") / "log.mcap"
    content, log = source.read_bytes(), read_log(source)
    record_size = LogFile(source).record.itemsize
    start = content.index(b"\x05" + (record_size - 9).to_bytes(8, "little"))
    last = len(log.cycle) - 1
    for row in (0, *random.Random(3).sample(range(last), 4), last):
        at = start + row * record_size
        source.write_bytes(content[:at] + content[at + record_size :])
        with pytest.raises(LogError, match="missing"):
            read_log(source)
