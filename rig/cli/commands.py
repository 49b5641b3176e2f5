"""The group of all commands, as click has it, and what becomes of their errors."""

from __future__ import annotations

import importlib
import sys
import time

import click

from rig.cli.command_table import COMMANDS, INTRODUCTION
from rig.cli.patience import told_of_compiling
from rig.cli.tables import brief, print_json, printed_so_far, visible
from rig.installation import missing_package


class _LazyGroup(click.Group):
    """A group that imports a command only when it is called: help stays fast."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module, name = COMMANDS[cmd_name][0].split(":")
        command: click.Command = getattr(importlib.import_module(module), name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS:
            import difflib

            near = difflib.get_close_matches(args[0], COMMANDS, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else f" There are: {', '.join(COMMANDS)}."
            ctx.fail(f"There is no command {args[0]!r}.{hint}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group(
    cls=_LazyGroup,
    help=INTRODUCTION,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="rig-controller", prog_name="rig")
def group() -> None:
    """Run experiments on a research rig; the command line's help is its introduction."""


def invoke(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; never shows a traceback for an input.

    With ``--json`` an error is on stdout, too, as ``{"error": …, "exit": …}``, unless what was
    found is there already: two objects would be no JSON.
    """
    words = sys.argv[1:] if arguments is None else arguments
    printed, began = printed_so_far(), time.time()
    code, error = _invoked(arguments)
    if error and "--json" in words and printed_so_far() == printed:
        print_json({"error": error, "exit": code})
    if error and words[:1] not in ([], ["explain"]):
        _keep_refusal(words, code, error, began)
    return code


def _keep_refusal(words: list[str], code: int, error: str, began: float) -> None:
    try:
        from rig.explaining.refused_run import REFUSED, keep_refusal
    except ModuleNotFoundError as lack:
        if missing_package(lack) is None:
            raise
        return  # which is what was said
    if code in REFUSED:
        keep_refusal(words, code, error, began)


def _invoked(arguments: list[str] | None) -> tuple[int, str]:
    """Return the exit code, and what went wrong if that was said as an error."""
    try:
        with told_of_compiling():
            result: object = group.main(args=arguments, prog_name="rig", standalone_mode=False)
    except click.exceptions.Abort as error:
        # Click takes an EOFError for the end of what is typed, whoever raised it; where something
        # is typed, it leaves none behind.
        if isinstance(error.__cause__, EOFError):
            return _report(error.__cause__), f"{error.__cause__}" or "EOFError"
        click.echo("Interrupted.", err=True)
        return 130, "Interrupted."
    except click.ClickException as error:
        error.show()
        return 2, error.format_message()
    except KeyboardInterrupt:
        click.echo("Interrupted.", err=True)
        return 130, "Interrupted."
    except BrokenPipeError:
        # The reader (`rig list | head`) has had enough: not an error, and nothing more to say.
        sys.stderr.close()
        return 0, ""
    except (Exception, SystemExit) as error:  # somebody's code may want to end the program
        return _report(error), missing_package(error) or f"{error}" or type(error).__name__
    return (result if isinstance(result, int) else 0), ""


def _report(error: BaseException) -> int:
    lacking = missing_package(error)
    if lacking is not None:
        click.echo(f"error: {lacking}", err=True)
        return 2
    from rig.hal import ConfigurationError, DeviceError, RigError

    if isinstance(error, RigError):
        for line in (f"error: {error}", *getattr(error, "__notes__", ())):
            click.echo(brief(visible(line)), err=True)
        if isinstance(error, ConfigurationError):
            _tell_of_broken_packages(str(error))
            return 2
        from rig.run_folder import RunFolderError

        if isinstance(error, RunFolderError):  # of a run that has ended: no rig has failed
            return 2
        return 3 if isinstance(error, DeviceError) else 4
    import traceback

    from rig.assembly.contract_check import lines_of_others, said, whose_bug

    place = whose_bug(error)
    theirs = [] if place is None else lines_of_others(error)
    if theirs:  # the way there is ours, and says nothing to who wrote them
        for text in (*traceback.format_list(theirs), *getattr(error, "__notes__", ())):
            click.echo(text.rstrip("\n"), err=True)
    else:
        traceback.print_exc()
    if place is not None:
        click.echo(f"\nerror: {place}: {said(error)}", err=True)
        return 2
    click.echo(
        "\nThis is a bug in rig, not in your files. Please report it with the text above.", err=True
    )
    return 70


def _tell_of_broken_packages(told: str) -> None:
    """Say what is installed and cannot be used: a name that is missing may be one of its."""
    from rig.assembly import REGISTRY

    for sentence in REGISTRY.broken():
        if sentence not in told:
            click.echo(f"besides: {sentence}", err=True)
