"""No option that takes a number takes nan or an infinite one."""

import importlib

import click
import pytest

from rig.cli import invoke
from rig.cli.command_table import COMMANDS


def number_options():
    """Yield each command's words and option that takes a number which need not be whole."""

    def look(words, command):
        if isinstance(command, click.Group):
            for name, below in command.commands.items():
                yield from look([*words, name], below)
        for option in command.params:
            kind = option.type
            if isinstance(kind, click.types.FloatParamType) or kind is click.FLOAT:
                yield words, option

    for name, (place, _) in COMMANDS.items():
        module, _, attribute = place.partition(":")
        yield from look([name], getattr(importlib.import_module(module), attribute))


FOUND = [(words, option.opts[0]) for words, option in number_options()]


def test_there_are_some():
    known = {("doctor", "--rate"), ("doctor", "--abuse"), ("simulate", "--for"), ("run", "--pace")}
    assert known <= {(words[0], option) for words, option in FOUND}


@pytest.mark.parametrize("value", ["nan", "NaN", "-nan", "inf", "-inf", "Infinity", "1e999"])
@pytest.mark.parametrize(("words", "option"), FOUND, ids=str)
def test_it_is_not_in_the_range(words, option, value, capsys):
    assert invoke([*words, f"{option}={value}"]) == 2
    told = capsys.readouterr().err
    assert f"'{option}" in told and "is not in the range" in told
