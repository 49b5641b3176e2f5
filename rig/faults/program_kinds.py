"""What may go wrong in the program itself and in the computer that it runs on."""

import dataclasses
import os
import sys
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from rig.faults.kind import Expect, FaultKind, Magnitudes, Must, Place, Sizes, either, ride, safe
from rig.faults.stage import Stage
from rig.faults.subject import Subject
from rig.run_facts import LOG


def _here(words: tuple[str, ...], subject: Subject) -> list[Place]:
    return [Place("program", "program", words)]


def replace_numbers(command: object, value: float) -> object:
    """Return a controller's command with every number replaced."""
    if isinstance(command, float):
        return value
    if isinstance(command, tuple):
        changed = [replace_numbers(part, value) for part in command]
        make: Callable[[Iterable[object]], object] = getattr(type(command), "_make", tuple)
        return make(changed)
    if dataclasses.is_dataclass(command) and not isinstance(command, type):
        fields = {
            field.name: replace_numbers(getattr(command, field.name), value)
            for field in dataclasses.fields(command)
        }
        return dataclasses.replace(command, **fields)
    return command


def _spoil(value: float, stage: Stage, place: Place, sizes: Sizes) -> Callable[[], None]:
    stage.program.spoils = partial(replace_numbers, value=value)
    return partial(_well_again, stage)


def _raise(stage: Stage, place: Place, sizes: Sizes) -> Callable[[], None]:
    def fail(command: object) -> object:
        raise ZeroDivisionError("injected: the law divides by zero")

    stage.program.spoils = fail
    return partial(_well_again, stage)


def _dawdle(stage: Stage, place: Place, sizes: Sizes) -> None:
    def dawdle(command: object) -> object:
        stage.program.spoils = None
        stage.clock.sleep_until(stage.clock.now() + (sizes.magnitude or 0.0))
        return command

    stage.program.spoils = dawdle


def _well_again(stage: Stage) -> None:
    stage.program.spoils = None


def _pause(stage: Stage, place: Place, sizes: Sizes) -> None:
    stage.clock.pause(sizes.magnitude or 0.0)


def _kill(stage: Stage, place: Place, sizes: Sizes) -> None:
    stage.program.dies()


def _interrupt(times: int, stage: Stage, place: Place, sizes: Sizes) -> None:
    for _ in range(times):
        stage.interrupt()


def _fill_disk(stage: Stage, place: Place, sizes: Sizes) -> None:
    stage.program.fill_disk()


def _slow_disk(stage: Stage, place: Place, sizes: Sizes) -> Callable[[], None]:
    """Have every write of the log take so long; the world does not wait for it."""
    write = os.write

    def wait_and_write(descriptor: int, data: bytes, /) -> int:
        if Path(f"/proc/self/fd/{descriptor}").readlink().name == LOG:
            stage.clock.sleep_until(stage.clock.now() + (sizes.magnitude or 0.0))
        return write(descriptor, data)

    def be_fast() -> None:
        os.write = write

    os.write = wait_and_write  # type: ignore[assignment]
    return be_fast


def _step_clock(stage: Stage, place: Place, sizes: Sizes) -> None:
    stage.program.step_clock(sizes.magnitude or 0.0)


def _lose_reader(stage: Stage, place: Place, sizes: Sizes) -> None:
    """Have whoever read the messages be gone, as `tee` that was killed."""
    reader, writer = os.pipe()
    os.close(reader)
    os.dup2(writer, sys.stderr.fileno())


def _late_if(least: float) -> Expect:
    return lambda sizes, subject: Must.SAFE if (sizes.magnitude or 0.0) > least else Must.EITHER


def _slow_if_written(sizes: Sizes, subject: Subject) -> Must:
    """Expect a stop if a write of the log falls into it: there is one in each cycle."""
    is_written = sizes.lasts > subject.period
    return _late_if(0.2)(sizes, subject) if is_written else Must.EITHER


_LAW = ("controller", "command", "law")
_HOST = ("paused", "stall", "late", "overrun", "program", "ticks")

_KINDS = (
    FaultKind(name="controller_nan", spoils_law=True,
              what="The controller commands what is no number.",
              places=partial(_here, _LAW), apply=partial(_spoil, float("nan")), must=safe,
              within=0.02),
    FaultKind(name="controller_huge", spoils_law=True,
              what="The controller commands 1e9.",
              places=partial(_here, _LAW), apply=partial(_spoil, 1e9), must=safe, within=0.05),
    FaultKind(name="controller_raises", spoils_law=True,
              what="The controller raises an exception.",
              places=partial(_here, ("divides",)), apply=_raise, must=safe, within=0.02),
    FaultKind(name="controller_slow", spoils_law=True, stalls=True,
              what="The controller takes many periods once.",
              places=partial(_here, _HOST), apply=_dawdle, must=_late_if(0.2), within=0.6,
              magnitude=Magnitudes(5e-3, 0.5, "s"), why="a few late cycles are ridden through"),
    FaultKind(name="host_paused", stalls=True,
              what="The computer does not run the program for a while.",
              places=partial(_here, _HOST), apply=_pause, must=_late_if(0.2), within=0.6,
              magnitude=Magnitudes(5e-3, 0.5, "s"), why="a few late cycles are ridden through"),
    FaultKind(name="program_killed", what="The program is killed.",
              places=partial(_here, ()), apply=_kill, must=either,
              why="nobody is left to say so; what the devices do is judged"),
    FaultKind(name="interrupted", what="Ctrl-C is pressed once.",
              places=partial(_here, ()), apply=partial(_interrupt, 1), must=ride),
    FaultKind(name="interrupted_twice", what="Ctrl-C is pressed twice.",
              places=partial(_here, ()), apply=partial(_interrupt, 2), must=ride),
    FaultKind(name="disk_full", what="The disk is full.",
              places=partial(_here, ("log", "File too large", "disk", "write")),
              apply=_fill_disk, must=safe, within=0.05),
    FaultKind(name="reader_gone", what="Whoever read the messages is gone.",
              places=partial(_here, ()), apply=_lose_reader, must=ride),
    FaultKind(name="disk_slow", what="Every write of the log takes long.",
              places=partial(_here, _HOST), apply=_slow_disk, must=_slow_if_written, within=0.6,
              magnitude=Magnitudes(10e-3, 0.5, "s"), lasts=Magnitudes(1e-3, 1.0, "s"),
              why="a few late cycles are ridden through"),
    FaultKind(name="clock_stepped", what="The wall's clock is set to another time.",
              places=partial(_here, ()), apply=_step_clock, must=ride,
              magnitude=Magnitudes(1e-3, 1e8, "s", signed=True)),
)  # fmt: skip

KINDS = tuple(dataclasses.replace(kind, is_rehearsable=True) for kind in _KINDS)
