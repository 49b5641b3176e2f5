"""What plain ``pytest`` leaves out, and how many processes share the work."""

import gc
import os
import signal
import sys
import unittest.mock

import hypothesis
import pytest
import sample_of_the_day

from rig import plug_ins, provenance
from rig.commissioning import record
from rig.config import calibration, names

pytest_plugins = "rig.testing.plugin"

# As many processes as cores: threads of linear algebra beside them would only wait for each other,
# and make a fit of 2 s one of 14 s. Read when numpy is imported, here and in what tests start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Some containers keep no bytecode. Every process that a test starts would compile all of rig again,
# and every worker all tests: half of what such a start costs.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# A shell that begins the tests in the background has them ignore Ctrl-C, `nohup` the end of the
# terminal, and so would every process that a test starts and ends by these.
for number, handler in (
    (signal.SIGINT, signal.default_int_handler),
    (signal.SIGHUP, signal.SIG_DFL),
):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, handler)

# What passed once passes again: the same examples in every run. Others are drawn with
# `--hypothesis-profile=default`.
hypothesis.settings.register_profile("repeatable", derandomize=True, print_blob=True, deadline=None)
hypothesis.settings.load_profile("repeatable")

APART = ("benchmark", "slow")
TOGETHER = ("tests/unit/controllers/gait/", "tests/closed_loop/test_legs_")
"""Starts of the paths of files that share plans of walks, which are slow to make."""


@pytest.fixture(scope="session", autouse=True)
def _state_of_its_own(tmp_path_factory):
    """Keep the faults of this user's rigs out of the tests, and theirs out of this user's rigs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(autouse=True)
def _environment_is_put_back():
    """Leave to the next test what it would have found alone: the product sets variables, too."""
    with unittest.mock.patch.dict(os.environ):
        yield


@pytest.fixture(scope="session", autouse=True)
def _no_records_of_this_checkout():
    """Keep what this user found and tested of the shipped rigs out of the tests."""

    def elsewhere(search):
        return [folder for folder in search if folder.resolve() != names.SHIPPED]

    def found(rig, device, search):
        return calibration.find_calibration(rig, device, elsewhere(search))

    def loaded(rig, search):
        return record.load_record(rig, elsewhere(search))

    with pytest.MonkeyPatch.context() as patch:
        for module in ("rig.config.laid_over", "rig.config.profile", "rig.calibration.store"):
            patch.setattr(f"{module}.find_calibration", found)
        for module in ("permission", "session"):
            patch.setattr(f"rig.commissioning.{module}.load_record", loaded)
        yield


@pytest.fixture(scope="session", autouse=True)
def _one_look_at_the_checkout():
    """Ask git once for the state of this checkout, which every run writes down."""
    git_state = provenance.git_state
    ours = git_state()

    def remembered(directory=None):
        return ours if directory is None else git_state(directory)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(provenance, "git_state", remembered)
        yield


@pytest.fixture(autouse=True)
def _led_to_nothing_yet(monkeypatch):
    """Forget the packages that rows led other tests of this process to: manifests name them."""
    monkeypatch.setattr(plug_ins, "_LED_TO", set())


def pytest_ignore_collect(collection_path, config):
    """Do not even import the benchmarks where nobody asks for one: they take seconds to start."""
    asked = config.option.markexpr
    if collection_path.name == "stranger":  # a package of its own, whose tests run beside it
        return True
    if collection_path.name == "benchmarks" and not any(marker in asked for marker in APART):
        return True
    return None


def pytest_collection_finish(session):
    """Look for garbage seldom: what is imported is most of what is there, and stays."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


@pytest.hookimpl(tryfirst=True)  # before pytest itself heeds -m
def pytest_collection_modifyitems(config, items):
    """Deselect marked tests whose marker the ``-m`` expression does not speak of."""
    sample_of_the_day.set_the_others_apart(items, sample_of_the_day.today())
    asked = config.option.markexpr
    apart = [marker for marker in APART if marker not in asked]
    left_out = [item for item in items if any(item.get_closest_marker(m) for m in apart)]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in set(left_out)]


def pytest_xdist_make_scheduler(config, log):
    """Give a file, or files that share what they set up, to one process."""
    from xdist.scheduler import LoadFileScheduling

    class ByFiles(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return next((start for start in TOGETHER if file.startswith(start)), file)

    return ByFiles(config, log) if config.option.dist == "loadfile" else None


def pytest_xdist_auto_num_workers(config):
    """Measure alone, and test on every core."""
    return 0 if "benchmark" in config.option.markexpr else os.cpu_count()


def pytest_report_header(config):
    """Say which day's sample of the slow cases this is."""
    return f"slow cases that take turns: {sample_of_the_day.DAY}={sample_of_the_day.today()}"


def pytest_terminal_summary(terminalreporter):
    """Say how much was exchanged with software that others wrote, and how often it disagreed."""
    stats = terminalreporter.stats
    failed = {report.nodeid for report in stats.get("failed", ())}
    exchanged, disagreed = {}, {}
    for report in stats.get("", ()):  # what passed beside the tests themselves
        if report.when != "teardown":  # only there everything has been counted
            continue
        for name, value in report.user_properties:
            if name == "exchanges":
                who, count = value
                exchanged[who] = exchanged.get(who, 0) + count
                disagreed[who] = disagreed.get(who, 0) + (report.nodeid in failed)
    if exchanged:
        terminalreporter.section("counterparts")
        for who, count in sorted(exchanged.items()):
            terminalreporter.line(f"{who}: {count} exchanges, {disagreed[who]} disagreements")
