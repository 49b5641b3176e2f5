"""The command line: one module per command, imported when it is called.

Its help is printed without click, whose import takes three times as long as all the rest: from
the same table of commands and the same introduction that click's group is made of.
"""

import contextlib
import gc
import io
import os
import sys
from typing import TYPE_CHECKING, cast

from rig.cli.command_table import COMMANDS, INTRODUCTION

if TYPE_CHECKING:
    import click
    from _typeshed import ReadableBuffer

    group: click.Group

_OPTIONS = {
    "--version": "Show the version and exit.",
    "-h, --help": "Show this message and exit.",
}
_INTERRUPTED = 130
_UNWRITTEN = 2  # what the shell was asked for cannot be: usage
_COLLECT_AFTER = (50_000, 20, 50)
"""Thresholds of the garbage collector. With Python's own, a tenth of a short command's time goes
into looking through modules and schemas that are made once and stay."""
_WIDE_ENOUGH = 80  # columns; the lines above are broken for no less, and click uses no more


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with its code.

    Exit codes: 0 ok, 1 a bound missed or something swung, 2 usage or configuration, 3 device or
    preflight (never energised), 4 fault while running, 70 a bug of ours, 130 interrupted. What
    would be 0 is 2 if the output cannot be written.
    """
    from rig.runtime.ending_signals import all_as_ctrl_c, end_by_signals

    code = _INTERRUPTED
    try:
        with all_as_ctrl_c():
            code = _run(arguments)
    except KeyboardInterrupt:  # before or after a command would hear it
        if sys.stderr is not None:
            sys.stderr.write("Interrupted.\n")
    end_by_signals(is_interrupted=code == _INTERRUPTED)
    # Python looks for garbage as it ends: among all that was imported, that takes longer than to
    # end without.
    gc.freeze()
    sys.exit(code)


def _run(arguments: list[str] | None) -> int:
    gc.set_threshold(*_COLLECT_AFTER)
    if sys.stderr is None:  # closed by the shell: what is opened next must not take its place
        sys.stderr = open(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8")  # noqa: SIM115, PTH123
    else:
        sys.stderr = _talk_to(sys.stderr.fileno())
    before = sys.stdout
    how: tuple[str, str | None] = ("utf-8", None)
    if before is None:  # closed by the shell: nobody wants it
        output = _Output(os.devnull, "w")
    else:
        output, how = _Output(before.fileno(), "w", closefd=False), (before.encoding, before.errors)
    sys.stdout = io.TextIOWrapper(io.BufferedWriter(output), *how)
    code = invoke(arguments)
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
    return code or (_UNWRITTEN if output.is_lost else 0)


class _Output(io.FileIO):
    """Standard output. If it takes nothing, on a full disk say, that is told once, and dropped.

    What the command does is done all the same, and so is its exit code, unless that were 0.
    """

    is_lost = False

    def write(self, data: "ReadableBuffer", /) -> int:
        """Write, or drop what cannot be written; a reader that has gone is told as ever."""
        try:
            return super().write(data)
        except BrokenPipeError:
            raise
        except OSError as error:
            if not self.is_lost and sys.stderr is not None:
                sys.stderr.write(f"error: cannot write the output: {error.strerror}\n")
            self.is_lost = True
            return memoryview(data).nbytes


class _Unheard(io.FileIO):
    """A file descriptor whose reader may go: what is written then is dropped.

    Talk must not end a run, nor change its exit code: `rig run … 2>&1 | tee` goes on without tee.
    """

    def write(self, data: "ReadableBuffer", /) -> int:
        """Write, or drop what cannot be written."""
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


def _talk_to(descriptor: int) -> io.TextIOWrapper:
    """Return a stream for what is said to the operator."""
    raw = _Unheard(descriptor, "w", closefd=False)
    # As `python -u` makes it: what a buffer kept when Ctrl-C came in the midst would be said twice.
    return io.TextIOWrapper(
        cast("io.BufferedWriter", raw), "utf-8", errors="backslashreplace", write_through=True
    )


def invoke(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; never shows a traceback for an input."""
    words = sys.argv[1:] if arguments is None else arguments
    if words in (["--help"], ["-h"]) and _columns() >= _WIDE_ENOUGH:
        return _print_help()
    # The matrices here are small: threads that wait for work would cost the loop its processor,
    # and a fit on a busy machine several times its time.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ["MPLBACKEND"] = "Agg"  # figures are files here, whatever is set for a notebook
    os.environ["NUMBA_DISABLE_JIT"] = "0"  # kernels are compiled here, whatever is debugged
    from rig.installation import missing_package
    from rig.kernel_cache import keep_kernels

    keep_kernels()
    try:
        from rig.cli.commands import invoke as invoke_click
    except ModuleNotFoundError as error:  # click is what tells of others
        lacking = missing_package(error)
        if lacking is None:
            raise
        print(f"error: {lacking}", file=sys.stderr)  # noqa: T201
        return _UNWRITTEN
    return invoke_click(words)


def plain_help() -> str:
    """Return the help as click formats it in a terminal of 80 columns and more."""
    paragraphs = "".join(f"  {line}".rstrip() + "\n" for line in INTRODUCTION.splitlines())
    commands = {name: text for name, (_, text) in COMMANDS.items()}
    return (
        "Usage: rig [OPTIONS] COMMAND [ARGS]...\n\n"
        f"{paragraphs}\nOptions:\n{_table(_OPTIONS)}\nCommands:\n{_table(commands)}"
    )


def _table(rows: dict[str, str]) -> str:
    width = max(map(len, rows)) + 2
    return "".join(f"  {name:<{width}}{text}\n" for name, text in rows.items())


def _print_help() -> int:
    try:
        print(plain_help(), end="", flush=True)  # noqa: T201 - this is the command's output
    except BrokenPipeError:
        sys.stderr.close()
    return 0


def _columns() -> int:
    """Return the terminal's width as the shell or the terminal says it, else 80."""
    said = os.environ.get("COLUMNS", "")
    if said.isdecimal() and int(said):
        return int(said)
    try:
        return os.get_terminal_size(1).columns or _WIDE_ENOUGH
    except OSError:  # standard output is no terminal
        return _WIDE_ENOUGH


def __getattr__(name: str) -> object:
    """Return click's group, which is imported when it is asked for."""
    if name == "group":
        from rig.cli.commands import group

        return group
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
