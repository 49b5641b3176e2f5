"""What is said of a computer, on systems that a test makes up."""

import collections
import os
import resource
import shutil

import pytest

from rig.doctor import computer
from rig.doctor.computer import look_at_computer
from rig.doctor.look import Fitness

Usage = collections.namedtuple("Usage", "total used free")


@pytest.fixture
def system(tmp_path):
    """Return a place where a test writes what the kernel shows."""

    def write(path, text):
        file = tmp_path / "sys" / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{text}\n")
        return tmp_path / "sys"

    write("kernel/realtime", "0")
    return write


def look(tmp_path, priority=0):
    found = look_at_computer(tmp_path / "runs" / "deep", priority, tmp_path / "sys")
    return {one.what.split(" in ")[0]: one for one in found}


def test_a_real_time_kernel_is_told_from_another(tmp_path, system):
    assert look(tmp_path)["kernel"].found.endswith("without PREEMPT_RT")
    system("kernel/realtime", "1")
    assert look(tmp_path)["kernel"].found.endswith(", PREEMPT_RT")


def test_elsewhere_than_on_linux_nothing_is_run_on_hardware(tmp_path, system, monkeypatch):
    monkeypatch.setattr(computer.sys, "platform", "darwin")
    assert look(tmp_path)["kernel"].verdict is Fitness.NO


@pytest.mark.parametrize(
    ("governors", "verdict"),
    [(["performance"] * 3, Fitness.OK), (["performance", "powersave"], Fitness.POOR)],
)
def test_a_governor_that_saves_power_is_mended(tmp_path, system, governors, verdict):
    assert look(tmp_path)["clock of the processors"].verdict is Fitness.OK
    for k, name in enumerate(governors):
        system(f"devices/system/cpu/cpu{k}/cpufreq/scaling_governor", name)
    found = look(tmp_path)["clock of the processors"]
    assert found.verdict is verdict
    assert ("cpupower frequency-set" in found.mend) is (verdict is Fitness.POOR)


@pytest.mark.parametrize(("name", "verdict"), [("tsc", Fitness.OK), ("hpet", Fitness.POOR)])
def test_a_slow_clock_is_told(tmp_path, system, name, verdict):
    system("devices/system/clocksource/clocksource0/current_clocksource", name)
    assert look(tmp_path)["clock source"].verdict is verdict


def test_real_time_that_is_refused_names_the_line_that_permits_it(tmp_path, system, monkeypatch):
    def refuse(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    found = look(tmp_path, 80)["SCHED_FIFO at priority 80"]
    assert (found.verdict, found.found) == (Fitness.POOR, "refused: Operation not permitted")
    assert "rtprio 99" in found.mend
    assert look(tmp_path, 0)["SCHED_FIFO at priority 0"].verdict is Fitness.OK


def test_memory_that_may_not_be_locked_names_the_line_that_permits_it(
    tmp_path, system, monkeypatch
):
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (8 * 2**20, 8 * 2**20))
    found = look(tmp_path)["locked memory"]
    assert (found.verdict, found.found) == (Fitness.POOR, "8 MiB at most")
    assert "12345 - memlock unlimited" in found.mend
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY,) * 2)
    assert look(tmp_path)["locked memory"].verdict is Fitness.OK


def test_a_full_disk_and_a_folder_of_somebody_elses_are_no(tmp_path, system, monkeypatch):
    assert look(tmp_path)["room for runs"].verdict is Fitness.OK
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(1, 1, 2**29))
    found = look(tmp_path)["room for runs"]
    assert (found.verdict, found.found) == (Fitness.NO, "0.50 GiB")
    monkeypatch.setattr(os, "access", lambda *_: False)
    found = look(tmp_path)["room for runs"]
    assert (found.verdict, found.found) == (Fitness.NO, "may not be written")
    assert str(tmp_path) in found.mend


def test_a_library_that_is_missing_is_installed_by_its_name(tmp_path, system, monkeypatch):
    assert "numpy" in look(tmp_path)["versions"].found
    known = computer.version

    def version(name):
        if name == "canopen":
            raise computer.PackageNotFoundError(name)
        return known(name)

    monkeypatch.setattr(computer, "version", version)
    found = look(tmp_path)["versions"]
    assert found.verdict is Fitness.NO
    assert found.mend.endswith("-m pip install canopen")


@pytest.mark.parametrize(
    ("slack", "verdict", "words"),
    [
        ((50_000, 1), Fitness.OK, "50000 ns; the loop sets 1 ns"),
        ((50_000, 50_000), Fitness.POOR, "the loop sets 50000 ns"),
        ((-1, -1), Fitness.OK, "does not say"),
    ],
)
def test_how_late_sleeps_may_end_is_said(tmp_path, system, monkeypatch, slack, verdict, words):
    monkeypatch.setattr(computer, "timer_slack", lambda: slack)
    found = look(tmp_path)["timer slack"]
    assert (found.verdict, words in found.found) == (verdict, True)


def test_looking_at_the_slack_leaves_it_as_it_was():
    before, _ = computer.timer_slack()
    assert computer.timer_slack()[0] == before
