"""The command line: one module per command, imported when it is called."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import click

_COMMANDS = {
    "run": ("rig.cli.run:run", "Run an experiment and leave a run folder."),
    "compare": ("rig.cli.compare:compare", "Run an experiment under several controllers."),
    "check": ("rig.cli.check:check", "Check a profile and show what it says."),
    "list": ("rig.cli.listing:listing", "List rigs, experiments and runs."),
    "report": ("rig.cli.report:report", "Make a run's figures and report again."),
    "export": ("rig.cli.export:export", "Write a run's log as csv, npz or mat."),
    "schema": ("rig.cli.schema:schema", "Print the JSON Schema of a file, for editors."),
    "completion": ("rig.cli.completion:completion", "Print a shell's completion script."),
}


class _LazyGroup(click.Group):
    """A group that imports a command only when it is called: help stays fast."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        module, name = _COMMANDS[cmd_name][0].split(":")
        command: click.Command = getattr(importlib.import_module(module), name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in _COMMANDS:
            import difflib

            near = difflib.get_close_matches(args[0], _COMMANDS, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            ctx.fail(f"There is no command {args[0]!r}.{hint}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in _COMMANDS.items()])


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="rig-controller", prog_name="rig")
def group() -> None:
    """Run experiments on a research rig, on hardware or in simulation.

    Start with `rig run cylinder-sine`: an antagonistic pair of pneumatic cylinders tracks a
    sine over emulated CANopen devices. `rig list` shows what else there is.
    """


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with its code.

    Exit codes: 0 ok, 1 an acceptance bound missed, 2 usage or configuration, 3 device or
    preflight (never energised), 4 fault while running, 70 a bug of ours, 130 interrupted.
    """
    sys.exit(invoke(arguments))


def invoke(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; never shows a traceback for an input."""
    try:
        result: Any = group.main(args=arguments, prog_name="rig", standalone_mode=False)
    except click.exceptions.Abort:
        click.echo("Interrupted.", err=True)
        return 130
    except click.ClickException as error:
        error.show()
        return 2
    except KeyboardInterrupt:
        click.echo("Interrupted.", err=True)
        return 130
    except BrokenPipeError:
        # The reader (`rig list | head`) has had enough: not an error, and nothing more to say.
        sys.stderr.close()
        return 0
    except Exception as error:
        return _report(error)
    return result if isinstance(result, int) else 0


def _report(error: Exception) -> int:
    from rig.hal import ConfigurationError, DeviceError, RigError

    if isinstance(error, RigError):
        click.echo(f"error: {error}", err=True)
        if isinstance(error, ConfigurationError):
            return 2
        return 3 if isinstance(error, DeviceError) else 4
    import traceback

    traceback.print_exc()
    click.echo(
        "\nThis is a bug in rig, not in your files. Please report it with the text above.", err=True
    )
    return 70
