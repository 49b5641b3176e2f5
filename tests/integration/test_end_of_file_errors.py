"""The end of a file is no Ctrl-C, whoever comes upon it."""

import click
import pytest

from rig.cli import command_table, invoke
from rig.cli.commands import group

MESSAGES = ["", "Ran out of input", "EOF when reading a line", "truncated"]


@pytest.mark.parametrize("message", MESSAGES)
def test_an_error_of_a_file_is_told_as_one(monkeypatch, capsys, message):
    @click.command()
    def fails():
        raise EOFError(message)

    monkeypatch.setattr(type(group), "get_command", lambda *_: fails)
    assert invoke([next(iter(command_table.COMMANDS))]) == 70
    told = capsys.readouterr().err
    assert "Interrupted" not in told and "EOFError" in told and "bug in rig" in told


@pytest.mark.parametrize(
    "asks", [lambda: click.confirm("sure?", abort=True), lambda: click.prompt("name")]
)
def test_the_end_of_what_is_typed_is_an_interruption(monkeypatch, capsys, asks):
    @click.command()
    def fails():
        asks()

    def ended(*_):
        raise EOFError

    monkeypatch.setattr(type(group), "get_command", lambda *_: fails)
    monkeypatch.setattr(click.termui, "visible_prompt_func", ended)
    assert invoke([next(iter(command_table.COMMANDS))]) == 130
    assert "Interrupted." in capsys.readouterr().err


def test_so_is_ctrl_c(monkeypatch, capsys):
    @click.command()
    def fails():
        raise KeyboardInterrupt

    monkeypatch.setattr(type(group), "get_command", lambda *_: fails)
    assert invoke([next(iter(command_table.COMMANDS))]) == 130
    assert "Interrupted." in capsys.readouterr().err
